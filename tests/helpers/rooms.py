"""A room with walls, a laser robot that drives in it, and its recording as a CARMEN log."""

import math
from itertools import pairwise
from pathlib import Path

import numpy as np

from robot.geometry import Array, Pose2
from robot.scan import Scan

WALLS = np.array(
    [
        *((0, 0, 6, 0), (6, 0, 6, 4), (6, 4, 0, 4), (0, 4, 0, 0)),
        *((2.5, 1.7, 3.4, 1.7), (3.4, 1.7, 3.4, 2.2), (3.4, 2.2, 2.5, 2.2), (2.5, 2.2, 2.5, 1.7)),
    ],
    float,
)
"""(m, 4) of a room of 6 by 4 m with a box in it [m]."""
HALL = np.array(
    [
        *((-2, -1, 8, -1), (8, -1, 8, 6.5), (8, 6.5, -2, 6.5), (-2, 6.5, -2, -1)),
        *((2.8, 1.6, 3.1, 2.4), (3.1, 2.4, 2.8, 1.6), (6, 4.5, 8, 4.5), (0, 5, 0, 6.5)),
    ],
    float,
)
"""(m, 4) of another building, in which the robot can drive the same way [m]."""
BEARINGS = np.radians(np.arange(-90, 90))
NOISE_M = 0.01


def ranges(pose: Pose2, walls: Array = WALLS) -> Array:
    """How far each beam of a laser is from the first wall [m]."""
    way = np.column_stack([np.cos(BEARINGS + pose.theta), np.sin(BEARINGS + pose.theta)])[:, None]
    start, along = walls[:, :2] - (pose.x, pose.y), walls[:, 2:] - walls[:, :2]
    sine = way[..., 0] * along[:, 1] - way[..., 1] * along[:, 0]
    with np.errstate(divide="ignore", invalid="ignore"):
        far = (start[:, 0] * along[:, 1] - start[:, 1] * along[:, 0]) / sine
        part = (start[:, 0] * way[..., 1] - start[:, 1] * way[..., 0]) / sine
    return np.where((far > 0) & (part >= 0) & (part <= 1), far, np.inf).min(axis=1)


def lap(
    seed: int, looks: int = 60, walls: Array = WALLS
) -> tuple[list[Pose2], list[Pose2], list[Scan]]:
    """A lap around the box: true poses, the steps by odometry that drifts, and the scans."""
    rng = np.random.default_rng(seed)
    turns = np.linspace(0, 2.2 * math.pi, looks)
    true = [
        Pose2(3 + 2 * math.sin(turn), 2 - 1.2 * math.cos(turn), math.atan2(
            1.2 * math.sin(turn), 2 * math.cos(turn)))
        for turn in turns
    ]  # fmt: skip
    steps = [Pose2()]
    for before, after in pairwise(true):
        moved = before.inverse() @ after
        far = math.hypot(moved.x, moved.y)
        steps.append(
            Pose2(
                1.04 * moved.x + rng.normal(0, 0.03 * far),
                moved.y,
                1.06 * moved.theta + rng.normal(0, 0.03 * far),
            )
        )
    scans = [
        Scan(0.5 * k, BEARINGS, ranges(pose, walls) + rng.normal(0, NOISE_M, len(BEARINGS)))
        for k, pose in enumerate(true)
    ]
    return true, steps, scans


def write_log(path: Path, steps: list[Pose2], scans: list[Scan], start: Pose2) -> None:
    """Write what a robot has measured as CARMEN does."""
    pose, lines = start, ["# CARMEN Logfile", "PARAM robot_frontlaser_offset 0.0 nohost 0"]
    for step, scan in zip(steps, scans, strict=True):
        pose = pose @ step
        place = f"{pose.x:.6f} {pose.y:.6f} {pose.theta:.6f}"
        read = " ".join(f"{far:.3f}" for far in scan.ranges)
        lines.append(f"ODOM {place} 0 0 0 {scan.stamp:.3f} host {scan.stamp:.3f}")
        lines.append(
            f"FLASER {len(scan.ranges)} {read} {place} {place} {scan.stamp:.3f} host "
            f"{scan.stamp:.3f}"
        )
    path.write_text("\n".join(lines) + "\n")


def from_walls(points: Array) -> Array:
    """How far points (n, 2) lie from the nearest wall (n,) [m]."""
    start, along = WALLS[:, :2], WALLS[:, 2:] - WALLS[:, :2]
    away = points[:, None] - start
    part = np.clip((away * along).sum(axis=2) / (along**2).sum(axis=1), 0, 1)
    return np.hypot(*(away - part[..., None] * along).transpose(2, 0, 1)).min(axis=1)
