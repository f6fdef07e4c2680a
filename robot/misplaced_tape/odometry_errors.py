"""What odometry errs by: `joint_errors` of pose and wheels, and how a step changes them."""

from __future__ import annotations

import math

import numpy as np

from robot.geometry import Array, Pose2

AHEAD, ASIDE, TURN, TURN_BY_WAY = 0.0425, 0.015, 0.0425, 0.03
"""What odometry errs by, a step's standard deviation: shares of a way along the robot, and across
it; of a turn; and a turn by the way [rad/m]."""
STILL_SD = 3e-5, 1e-4
"""What odometry of a robot that stands errs by, a step's standard deviation [m], [rad]."""
WHEELS_SD, LASTING = (0.02, 0.2, 0.03), 0.98
"""What it errs by for a while, as wheels slip: shares of a way, turns by the way [rad/m], and
shares of a turn; standard deviations. So much of that is left at the next scan. Where each wheel
slips by 2 % of its way, the robot turns by 0.25 rad/m; with 0.05 slipping wheels were taken for
tape that lies aside."""
LEAST_SD = 3e-4
"""Scans one after the other see the same errors of the drawing, so a place is not known better [m],
[rad]."""
POSE, WHEELS = slice(0, 3), slice(3, 6)
"""Where a state has the pose, and the errors of the wheels."""


def joint_errors(covariance: Array, size: int = WHEELS.stop) -> Array:
    """Return the covariance (size, size) of a state at the beginning.

    Args:
        covariance: (3, 3) of the pose [m, m, rad].
        size: how many members the state has; what comes after the wheels is 0.
    """
    joint = np.zeros((size, size))
    joint[POSE, POSE] = covariance
    joint[WHEELS, WHEELS] = np.diag(np.square(WHEELS_SD))
    return joint


def corrected_step(moved: Pose2, wheels: Array) -> Pose2:
    """Return a step of odometry less the errors of the wheels (3,)."""
    ahead, turn_by_way, turn = wheels.tolist()
    theta = (1 + turn) * moved.theta + turn_by_way * moved.x
    return Pose2((1 + ahead) * moved.x, (1 + ahead) * moved.y, theta)


def predict(joint: Array, pose: Pose2, moved: Pose2, step: Pose2) -> None:
    """Carry a covariance (n, n) over a step from a pose, in its place.

    Args:
        joint: of the state: pose, wheels, and what does not change.
        pose: before the step.
        moved: the step as odometry has it.
        step: the same, corrected.
    """
    cos, sin = math.cos(pose.theta), math.sin(pose.theta)
    by_step, added = _step_errors(cos, sin, step)
    way_x, way_y = cos * moved.x - sin * moved.y, sin * moved.x + cos * moved.y
    by_wheels = np.array([[way_x, 0.0, 0.0], [way_y, 0.0, 0.0], [0.0, moved.x, moved.theta]])
    joint[WHEELS], joint[:, WHEELS] = LASTING * joint[WHEELS], LASTING * joint[:, WHEELS]
    joint[WHEELS, WHEELS] += (1 - LASTING**2) * np.diag(np.square(WHEELS_SD))
    joint[POSE] = by_step @ joint[POSE] + by_wheels @ joint[WHEELS]
    joint[:, POSE] = joint[:, POSE] @ by_step.T + joint[:, WHEELS] @ by_wheels.T
    joint[POSE, POSE] += added + LEAST_SD**2 * np.eye(3)


def _step_errors(cos: float, sin: float, step: Pose2) -> tuple[Array, Array]:
    """Return how a step moves errors of the pose (3, 3), and what it adds (3, 3)."""
    way = math.hypot(step.x, step.y)
    dx, dy = cos * step.x - sin * step.y, sin * step.x + cos * step.y
    motion = np.array([[1.0, 0.0, -dy], [0.0, 1.0, dx], [0.0, 0.0, 1.0]])
    turn = TURN * abs(step.theta) + TURN_BY_WAY * way + STILL_SD[1]
    sds = np.array([AHEAD * way + STILL_SD[0], ASIDE * way + STILL_SD[0], turn])
    to_map = np.array([[cos, -sin, 0.0], [sin, cos, 0.0], [0.0, 0.0, 1.0]]) * sds
    return motion, to_map @ to_map.T
