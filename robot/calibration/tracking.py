"""Follows a drive picture by picture, for the adjustment to begin near the true path.

An extended Kalman filter (Probabilistic Robotics, Table 3.3): the wheels predict the pose, and the
edges that were seen are laid on those of the field.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from robot.calibration.adjustment import STEP_SD, DriveEstimate
from robot.calibration.misses import misses
from robot.calibration.sightings import FloorPoints, Sightings
from robot.calibration.start_poses import edge_ends, pose_near
from robot.calibration.wheel_motion import WheelMotion
from robot.geometry import Array
from robot.localization.models.entry_field import EntryField

FIRST_GATE, GATE, LEAST_GATE = 0.25, 0.10, 0.015
"""Edges farther off than this do not count [m]: in the first picture, at most in later ones, and if
the pose is known exactly."""
AHEAD = 0.3
"""How far ahead most edges are seen [m]."""
DOUBT = 5.0
"""Factor on the edges' standard deviations, because the camera is not known yet."""
NEAR = 0.02
"""Edges much farther off than this count less [m]."""
STEPS = 6
"""Most Gauss-Newton steps by which a picture is laid on the field."""
SLIP_STEP, TURN_BY_WAY = 0.16, 1.2
"""Standard deviation of a step between two pictures, as a share of it, and of its turn by its way
[rad/m]: as if all slip were of one step, four times that of a wheel, as slip lasts for a second."""
UNSURE, TOGETHER, AGAIN_SD = 0.04, 6, np.array([0.012, 0.012, 0.03])
"""If edges may be farther off than the first [m], after a stretch without tape, the second is how
many pictures are laid on the field together, and the third how exact that is [m, m, rad]."""
LEAST_MATCHED, MOST_MOVED = 0.5, 4.0
"""A picture tells where the robot is if at least the first, a share of its edges, lies on the
field's, and the pose moves by at most the second, in standard deviations."""


def follow_path(
    state: DriveEstimate,
    covariance: Array,
    seen: Sightings,
    motion: WheelMotion,
    entries: EntryField,
    *,
    first: bool,
) -> DriveEstimate:
    """Return a state with the poses of all pictures of a window.

    Args:
        state: what is known; its poses are those of the first pictures.
        covariance: of the last of these poses (3, 3) [m, m, rad].
        seen: the window's sightings.
        motion: the window's wheels.
        entries: the field, for edges to be laid on.
        first: whether the state's only pose is the start as told.
    """
    known, total = len(state.poses), len(motion.stamps)
    slip = np.vstack([state.slip, np.zeros((total - known, 2))])
    steps, _ = motion.steps(state.values, slip[:-1])
    floor = seen.floor_points(state.values, motion.twists(state.values))
    poses = np.vstack([state.poses, np.zeros((total - known, 3))])
    for k in range(0 if first else known, total):
        widest, pose = FIRST_GATE, poses[0]
        if k > 0:
            widest = GATE
            pose, covariance = predicted(poses[k - 1], covariance, steps[k - 1])
            if _reach(covariance) > UNSURE and np.isfinite(floor.points[k, :, 0]).any():
                last = min(total, k + TOGETHER)
                ends = edge_ends(floor.part(k, last), steps[k : last - 1])
                likely = pose_near(pose, covariance, ends, entries)
                if likely is not None:
                    pose, covariance = likely, np.diag(AGAIN_SD**2)
        gate = min(widest, LEAST_GATE + 3 * _reach(covariance))
        place = seen.part(k, k + 1), floor.part(k, k + 1)
        poses[k], covariance = laid(pose, covariance, *place, state.values, gate)
    return replace(state, poses=poses, slip=slip)


def _reach(covariance: Array) -> float:
    """Return the standard deviation of where an edge is seen, by a pose's covariance [m]."""
    return float(np.sqrt(np.trace(covariance[:2, :2]) + AHEAD**2 * covariance[2, 2]))


def predicted(pose: Array, covariance: Array, step: Array) -> tuple[Array, Array]:
    """Return a pose (3,) and its covariance (3, 3) after a step (3,) by the wheels."""
    c, s = np.cos(pose[2]), np.sin(pose[2])
    turn = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1.0]])
    moved = turn @ step
    by_pose = np.eye(3)
    by_pose[:2, 2] = -moved[1], moved[0]
    # Wheels of unknown size: one that is larger than the other turns the robot as it rolls.
    sd = SLIP_STEP * np.abs(step) + STEP_SD + np.array([0.0, 0.0, TURN_BY_WAY * abs(step[0])])
    noise = turn @ np.diag(sd**2) @ turn.T
    return pose + moved, by_pose @ covariance @ by_pose.T + noise


def laid(
    pose: Array,
    covariance: Array,
    seen: Sightings,
    floor: FloorPoints,
    values: Array,
    gate: float,
    least_matched: float = LEAST_MATCHED,
) -> tuple[Array, Array]:
    """Lay the edges of one picture on those that are known; return the pose and its covariance.

    The pose stays as predicted if a smaller share of the picture's edges lies on known ones.
    """
    information = np.linalg.inv(covariance)
    result = pose.copy()
    for _ in range(STEPS):
        offsets = misses(seen, floor, result[None], values, gate)
        weight = 1 / (1 + (offsets.metres / NEAR) ** 2) / DOUBT**2
        weighted = offsets.by_pose * weight[:, None]
        left = information + weighted.T @ offsets.by_pose
        right = information @ (pose - result) - weighted.T @ offsets.residuals
        step = np.linalg.solve(left, right)
        result = result + step
        if np.abs(step).max() < 1e-4:
            break
    matched = len(misses(seen, floor, result[None], values, gate).residuals)
    moved = result - pose
    if (
        matched < least_matched * np.isfinite(seen.pixels[:, :, 0]).sum()
        or moved @ information @ moved > MOST_MOVED**2
    ):
        return pose, covariance
    remaining = np.asarray(np.linalg.inv(left), np.float64)
    return result, remaining
