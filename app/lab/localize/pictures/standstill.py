"""Tells pictures that are stale: a later stamp, but what they show has hardly moved.

Corners of the picture are tracked from one picture to the next. Those on the floor should move as
odometry says. If the robot moved far, and most of them moved much less, then the second picture was
exposed soon after the first, and stamped late.
"""

from __future__ import annotations

from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from robot.camera import FloorView
from robot.cameras.camera import Picture
from robot.geometry import Array, Pose2

CORNERS, QUALITY, APART_PX = 300, 0.05, 6.0
"""At most so many corners are tracked, of this quality relative to the best, this far apart."""
WINDOW_PX, LEVELS = 21, 4
"""Side of the patches that are compared, and how often the picture is halved before."""
RETURN_PX = 0.7
"""A corner that was tracked there and back must come out this close to where it began."""
FARTHEST = 1.5
"""Corners on the floor beyond this are not used [m]."""
FEWEST = 15
"""At least so many corners must be tracked."""
LEAST_PX = 60.0
"""Motion of the floor in the picture that odometry must tell, to be compared."""
SHARE = 0.25
"""A picture is stale if its corners moved by less than this share of what odometry says."""
ALIKE = 0.5
"""Without motion to compare, a picture is stale if its grey levels differ by less on average."""


def is_stale(before: Picture, picture: Picture, moved: Pose2 | None, view: FloorView) -> bool:
    """Return whether a picture shows what an earlier one showed, although the robot has moved.

    Args:
        before: (h, w, 3) the picture before.
        picture: (h, w, 3) the one to be judged.
        moved: motion between their stamps by odometry; without it only a repeated picture is told.
        view: the camera above the floor.
    """
    first, second = (cv2.cvtColor(image, cv2.COLOR_BGR2GRAY) for image in (before, picture))
    if moved is None:
        return bool(np.abs(first.astype(np.int16) - second).mean() < ALIKE)
    start, end = _tracked(first, second)
    on_floor = view.floor_points(start)
    near = np.hypot(*(on_floor - view.robot_from_camera[:2, 3]).T) < FARTHEST
    if near.sum() < FEWEST:
        return False
    expected = view.pixels(moved.inverse().apply(on_floor[near])) - start[near]
    # A corner that should have left what the lens can show has moved by more than any that did not.
    claimed = float(np.median(np.nan_to_num(np.hypot(*expected.T), nan=np.inf)))
    seen = float(np.median(np.hypot(*(end - start)[near].T)))
    return claimed >= LEAST_PX and seen < SHARE * claimed


def _tracked(first: NDArray[Any], second: NDArray[Any]) -> tuple[Array, Array]:
    """Return where corners are in a picture (n, 2) and where they are in the next [px]."""
    corners: NDArray[Any] | None = cv2.goodFeaturesToTrack(first, CORNERS, QUALITY, APART_PX)
    if corners is None:
        return np.empty((0, 2)), np.empty((0, 2))
    ahead, sure = _flow(corners, first, second)
    back, sure_back = _flow(ahead, second, first)
    kept = sure & sure_back & (np.hypot(*(back - corners)[:, 0].T) < RETURN_PX)
    return corners[kept, 0].astype(np.float64), ahead[kept, 0].astype(np.float64)


def _flow(
    start: NDArray[Any], image: NDArray[Any], other: NDArray[Any]
) -> tuple[NDArray[Any], NDArray[np.bool_]]:
    """Return where points (n, 1, 2) of an image are in another, and which were found (n,)."""
    end, status, _ = cv2.calcOpticalFlowPyrLK(
        image, other, start, np.empty(0), winSize=(WINDOW_PX, WINDOW_PX), maxLevel=LEVELS
    )
    return end, np.asarray(status[:, 0] > 0)
