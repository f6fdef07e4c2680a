def kalman(mean, sd, moved, moved_sd, seen, seen_sd):
    """Lesson 9. Return mean and standard deviation of a place on a line after a step and a look.

    mean, sd: what was believed [m]; moved, moved_sd: the step by the wheels and its standard
    deviation [m]; seen, seen_sd: the place that a scan tells, and its standard deviation [m].
    """
    raise NotImplementedError
