"""A filter of one's own: the book's particle filter, with BrickPose's models, on its own scans."""

import math

import numpy as np

from brickpose import MAPS, LocalizationParameters, Pose2, Scan, Setup, load_field

field = load_field("square", MAPS)
setup = Setup.of_field(field, LocalizationParameters())
rng = np.random.default_rng(0)
bearings = np.radians(np.arange(-60.0, 61.0, 3.0))


class TextbookFilter:
    """Predict, weigh, resample (Probabilistic Robotics, Table 4.3)."""

    def __init__(self, around: Pose2, count: int = 1000) -> None:
        self.poses = around.to_array() + [0.03, 0.03, 0.1] * rng.standard_normal((count, 3))

    def update(self, moved: Pose2, scan: Scan) -> Pose2:
        """Return the mean pose after a step of odometry and a scan."""
        predicted = setup.motion.sample(self.poses, moved, rng)
        log_weights = setup.sensor.log_likelihood(predicted, scan)
        weights = np.exp(log_weights - log_weights.max())
        chosen = rng.choice(len(predicted), len(predicted), p=weights / weights.sum())
        self.poses = predicted[chosen]
        x, y = self.poses[:, :2].mean(axis=0)
        sine, cosine = np.sin(self.poses[:, 2]).mean(), np.cos(self.poses[:, 2]).mean()
        return Pose2(x, y, math.atan2(sine, cosine))


true, step = Pose2(0.1, -0.15, 0.0), Pose2(0.02, 0.0, 0.133)
belief = TextbookFilter(Pose2(0.12, -0.17, 0.1))
for tick in range(60):
    true = true @ step
    (ranges,) = field.ranges(true.to_array()[None], bearings, range_max=2.0)
    pose = belief.update(step, Scan(tick / 10, bearings, ranges, extra_sd=0.005))
    if tick % 20 == 19:
        print(f"{1000 * math.hypot(pose.x - true.x, pose.y - true.y):.1f} mm off")
