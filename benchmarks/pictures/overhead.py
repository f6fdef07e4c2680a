"""Poses of a robot by cameras above the floor: read, noisy odometry of them, and alignment."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import yaml
from scipy.optimize import least_squares

from app.trajectories.trajectory import Trajectory
from robot.geometry import Array, Pose2, wrap_angle

SCALE_SD, STEP_SD, ASIDE_SD = 0.03, 0.05, 0.02
"""Errors of the made odometry: of the scale of distances and of turns, the same for a whole drive;
of each step along its way (and of its turn); and across it. As shares."""
FIT_M, FIT_RAD = 0.015, math.radians(1.5)
"""Errors of these sizes weigh alike in the alignment."""
LONGEST_SHIFT = 0.5
"""Largest time shift that is tried [s]."""


@dataclass(frozen=True, eq=False)
class Overhead:
    """The poses that cameras above the floor measured."""

    stamps: Array
    """(n,) [s], rising."""
    poses: Array
    """(n, 3) x, y [m] and heading [rad], which is unwrapped."""

    @classmethod
    def load(cls, path: Path) -> Overhead:
        """Read the file of one robot's trajectory: rows of x, y, z and a rotation matrix."""
        content: Any = yaml.load(path.read_text(encoding="utf-8"), yaml.CSafeLoader)
        rows = sorted((float(key), row) for key, row in content["trajectory_data"].items())
        table = np.array([[float(text) for text in row] for _, row in rows])
        headings = np.unwrap(np.arctan2(table[:, 6], table[:, 3]))
        stamps = float(content["begin_time_stamp"]) + np.array([since for since, _ in rows])
        return cls(stamps, np.column_stack([table[:, :2], headings]))

    def at(self, stamps: Array) -> Array:
        """Return the poses (m, 3) at stamps (m,), interpolated."""
        columns = [np.interp(stamps, self.stamps, column) for column in self.poses.T]
        return np.column_stack(columns)

    def odometry(self, seed: int) -> Trajectory:
        """Return the robot's motion as wheels of some quality would tell it, from (0, 0, 0) on."""
        rng = np.random.default_rng(seed)
        scale, turn_scale = 1 + rng.normal(0, SCALE_SD, 2)
        pose, poses = Pose2(), [np.zeros(3)]
        for before, after in zip(self.poses[:-1], self.poses[1:], strict=True):
            step = Pose2.from_array(before).inverse() @ Pose2.from_array(after)
            way, turn = math.hypot(step.x, step.y), abs(step.theta)
            noise = rng.normal(0, (STEP_SD * way, ASIDE_SD * way, STEP_SD * turn))
            pose = pose @ Pose2(
                scale * step.x + noise[0],
                scale * step.y + noise[1],
                turn_scale * step.theta + noise[2],
            )
            poses.append(pose.to_array())
        return Trajectory.of_poses(self.stamps, poses)


@dataclass(frozen=True, eq=False)
class Aligned:
    """Poses beside overhead ones, after one rigid transform and one time shift were fitted."""

    moved: Pose2
    """The transform from the overhead frame to the map, about the first pose."""
    shift: float
    """How much later than the overhead poses the others are stamped [s]."""
    distances: Array
    """(n,) [m]"""
    turns: Array
    """(n,) absolute errors of the heading [rad]."""


def align(trajectory: Trajectory, overhead: Overhead) -> Aligned:
    """Fit the transform and the time shift that bring overhead poses next to a trajectory."""
    # From the first stamp on: a shift is below the resolution of the derivatives otherwise.
    begin = float(trajectory.stamps[0])
    stamps, poses = trajectory.stamps - begin, trajectory.poses
    camera_poses = Overhead(overhead.stamps - begin, overhead.poses)
    centre = camera_poses.at(stamps[:1])[0, :2]

    def errors(values: Array) -> Array:
        x, y, turn, shift = values
        true = camera_poses.at(stamps - shift)
        true[:, :2] = Pose2(x, y, turn).apply(true[:, :2] - centre) + centre
        away: Array = poses - true
        away[:, 2] = wrap_angle(away[:, 2] - turn)
        return away

    def weighed(values: Array) -> Array:
        return np.asarray((errors(values) / (FIT_M, FIT_M, FIT_RAD)).ravel())

    most = LONGEST_SHIFT
    start = [*(poses[0, :2] - centre), 0.0, 0.0]
    result = least_squares(
        weighed,
        start,
        loss="soft_l1",
        x_scale=[0.01, 0.01, 0.02, 0.02],
        bounds=([-np.inf, -np.inf, -math.pi, -most], [np.inf, np.inf, math.pi, most]),
    )
    away = errors(result.x)
    x, y, turn, shift = result.x.tolist()
    return Aligned(Pose2(x, y, turn), shift, np.hypot(away[:, 0], away[:, 1]), np.abs(away[:, 2]))
