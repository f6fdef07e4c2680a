def log_weight(poses, bearings, ranges, field, sigma):
    """Lesson 3. Return how well a scan fits each pose: the logarithm of its likelihood, (n,).

    poses: (n, 3) x, y [m], theta [rad]; bearings [rad], ranges [m]: (k,), infinite without a
    return; field.distances[row, column]: distance of a cell from the tape's nearest edge [m];
    field.origin: x, y of the first cell's corner [m]; field.cell: a cell's side [m].
    An end beyond the cells counts as in the nearest of them.
    A ray whose end is the distance d away has the likelihood 0.95 exp(-d²/(2 sigma²)) + 0.05.
    """
    raise NotImplementedError
