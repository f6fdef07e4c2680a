def init(extent, count, rng):
    """Lesson 7. Return particles (count, 3) all over the field, looking everywhere.

    extent: left, bottom, right, top [m]; headings in [-pi, pi).
    """
    raise NotImplementedError


def estimate(poses, weights):
    """Lesson 7. Return x, y, theta: the weighted mean of the heaviest particle's place.

    To its place belong particles less than 0.1 m away whose heading differs by less than 0.5 rad.
    """
    raise NotImplementedError
