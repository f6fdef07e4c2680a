class MyMotion:
    """With this the dashboard moves its particles by your motion; nothing is to be done here."""

    def __init__(self, parameters):
        names = ("alpha1", "alpha2", "alpha3", "alpha4")
        self.alphas = np.array([getattr(parameters, name) for name in names])

    def sample(self, poses, moved, rng):
        step = np.array([moved.x, moved.y, moved.theta])
        return np.asarray(motion(poses, step, self.alphas, rng))


class MySensor:
    """With this the dashboard weighs its particles by your log_weight; nothing is to be done."""

    CELL, MARGIN = 0.005, 200

    def __init__(self, field, parameters):
        from scipy.ndimage import distance_transform_edt

        tape = np.pad(field.occupancy(self.CELL).occupied, self.MARGIN)
        self.sigma = parameters.sigma_hit
        self.field = types.SimpleNamespace(
            distances=np.abs(distance_transform_edt(~tape) - distance_transform_edt(tape))
            * self.CELL,
            origin=np.array(field.extent[:2]) - self.MARGIN * self.CELL,
            cell=self.CELL,
        )

    def log_likelihood(self, poses, scan):
        sigma = math.hypot(max(self.sigma, self.CELL), scan.extra_sd)
        return np.asarray(log_weight(poses, scan.bearings, scan.ranges, self.field, sigma))
