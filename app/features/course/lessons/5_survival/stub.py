def resample(poses, weights, rng):
    """Lesson 5. Return n survivors, drawn by weight, and their new weights: poses, weights.

    poses: (n, 3); weights: (n,), their sum is 1; rng: the only source of chance, as rng.random().
    """
    raise NotImplementedError
