"""Find a robot by scans of one's own: a field, a filter, and no program around them.

It compiles for a minute at first. Your own drawing is ``load_field("my_field.svg", MAPS)``.
"""

import math

import numpy as np

from brickpose import MAPS, Localizer, Pose2, Scan, load_field

field = load_field("square", MAPS)
localizer = Localizer.of_field(field)
bearings = np.radians(np.arange(-60.0, 61.0, 3.0))
noise = np.random.default_rng(0)

# It drives a circle, and its wheels say so exactly; its start is known to some centimetres only.
start = Pose2(0.1, -0.15, 0.0)
localizer.set_pose(Pose2(0.12, -0.17, 0.1), np.diag([0.03**2, 0.03**2, 0.1**2]))
for tick in range(101):
    turn = tick / 20
    odometry = Pose2(0.15 * math.sin(turn), 0.15 * (1 - math.cos(turn)), turn)
    true = start @ odometry
    (ranges,) = field.ranges(true.to_array()[None], bearings, range_max=2.0)
    ranges += noise.normal(0.0, 0.003, len(bearings))
    estimate = localizer.update(odometry, Scan(tick / 25, bearings, ranges))
    if estimate is not None and tick % 20 == 0:
        pose = estimate.pose
        print(f"{1000 * math.hypot(pose.x - true.x, pose.y - true.y):.1f} mm off")
