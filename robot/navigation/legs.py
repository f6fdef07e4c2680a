"""WayLeg: a part of a way, driven along a curve or turned on the spot; a way is several of them."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from robot.geometry import Array, Pose2, wrap_angle

STEP = 0.005
"""Points of a curve are about so far from each other [m]."""
FEWEST = 4
"""Steps of a short curve: it begins and ends at rest, and moves between."""


@dataclass(frozen=True, eq=False)
class WayLeg:
    """Poses that the robot passes without standing in between."""

    poses: Array
    """(n, 3) x, y [m] and heading [rad], which does not jump by a turn; 2 or more."""
    backwards: bool = False
    """Whether the robot drives it backwards."""

    @property
    def on_spot(self) -> bool:
        """Whether the robot only turns."""
        return bool((self.poses[:, :2] == self.poses[0, :2]).all())

    @property
    def length(self) -> float:
        """Of the way [m]."""
        return float(np.hypot(*np.diff(self.poses[:, :2], axis=0).T).sum())

    @property
    def end(self) -> Pose2:
        """Where it ends."""
        return Pose2.from_array(self.poses[-1])


def turn(pose: Pose2, theta: float) -> WayLeg:
    """Return a turn on the spot, by the shorter way, to a heading [rad]."""
    angle = wrap_angle(theta - pose.theta)
    parts = max(1, math.ceil(abs(angle) / 0.1))
    poses = np.tile(pose.to_array(), (parts + 1, 1))
    poses[:, 2] += np.linspace(0.0, angle, parts + 1)
    return WayLeg(poses)


def straight(pose: Pose2, distance: float) -> WayLeg:
    """Return a straight way from a pose; a negative distance [m] is driven backwards."""
    parts = max(FEWEST, math.ceil(abs(distance) / STEP))
    along = np.linspace(0.0, distance, parts + 1)
    x, y = pose.x + along * math.cos(pose.theta), pose.y + along * math.sin(pose.theta)
    return WayLeg(np.column_stack([x, y, np.full(parts + 1, pose.theta)]), backwards=distance < 0)


def curve(points: Array, *, backwards: bool = False) -> WayLeg:
    """Return the way along points (n, 2) [m] that are near to each other; headings follow them."""
    ahead = np.diff(points, axis=0)
    ahead = ahead[np.hypot(ahead[:, 0], ahead[:, 1]) > 1e-9]
    points = np.concatenate([points[:1], points[0] + np.cumsum(ahead, axis=0)])
    headings = np.unwrap(np.arctan2(ahead[:, 1], ahead[:, 0]))
    # A heading at a point is the mean of those before and after it.
    inner = (headings[:-1] + headings[1:]) / 2
    first, last = headings[0], headings[-1]
    if len(headings) > 1:
        first, last = 2 * headings[0] - inner[0], 2 * headings[-1] - inner[-1]
    theta = np.concatenate([[first], inner, [last]])
    return WayLeg(np.column_stack([points, theta + (math.pi if backwards else 0.0)]), backwards)


def rounded(corners: Array, length: float) -> Array:
    """Return points (n, 2) of straight lines between corners (m, 2) [m], rounded at the corners.

    A corner's turn is spread over twice the length [m]. Both ends stay where they are.
    """
    points = _dense(corners)
    half = round(length / STEP / 2)
    if half < 1 or len(points) < 3:
        return points
    half = min(half, (len(points) - 1) // 2)
    kernel = np.ones(2 * half + 1) / (2 * half + 1)
    for _ in range(2):
        # Mirrored at both ends, so that the means there are the ends themselves.
        before = 2 * points[0] - points[half:0:-1]
        after = 2 * points[-1] - points[-2 : -half - 2 : -1]
        framed = np.concatenate([before, points, after])
        points = np.column_stack([np.convolve(axis, kernel, "valid") for axis in framed.T])
    return points


def _dense(corners: Array) -> Array:
    lengths = np.hypot(*np.diff(corners, axis=0).T)
    along = np.concatenate([[0.0], np.cumsum(lengths)])
    wanted = np.linspace(0.0, along[-1], max(FEWEST, math.ceil(along[-1] / STEP)) + 1)
    return np.column_stack([np.interp(wanted, along, axis) for axis in corners.T])
