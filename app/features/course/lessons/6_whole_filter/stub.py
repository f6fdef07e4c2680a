def loop(poses, weights, moved, scan, parts):
    """Lesson 6. Return poses and weights after one round of the filter.

    moved: dx, dy [m], turn [rad]. If it is shorter than 0.001 m and turns less than 0.01 rad, the
    robot stands, and all stays as it is. parts.motion(poses, moved) gives poses,
    parts.log_weight(poses, scan) gives log-weights, parts.resample(poses, weights) gives both.
    Resample when the effective sample size is below half the number of particles.
    """
    raise NotImplementedError
