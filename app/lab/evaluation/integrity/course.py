"""Where a figure-eight is driven on a field: as large as fits, with tape in sight."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import cv2
import numpy as np
from numpy.typing import NDArray

from app.lab.evaluation.drives import on_eight
from app.settings.config import Config
from robot.description.spec import RobotSpec
from robot.driving.figure_eight import FigureEight
from robot.fields.field import Field
from robot.geometry import Array, Pose2

CELL = 0.02
"""Of the raster of distances from tape [m]."""
LOOKS = tuple((x, slope * x) for x in (0.2, 0.35, 0.5) for slope in (-0.4, 0.0, 0.4))
NEAR = 0.08
"""Tape is in sight if it is so near [m] to one of these points, seen from the robot [m]."""
RADII = (0.10, 0.30)
"""Least and largest radius of a circle [m]."""
BY_SIDE = 0.19
"""Radius by the shorter side of the field: on a square of 1 m the paper's."""
REACH = 1.6
"""A path reaches two radii from its middle; the rest may lie beyond the tape."""
STEP = 0.1
"""Between middles that are compared [m]; more on floors as large as a building."""
MOST_STEPS = 12
"""From the field's middle to its sides."""
AS_GOOD = 0.05
"""The field's middle is preferred to a place that shows tape on so much more of the way."""
TURNS, MOMENTS = 8, 32
"""Paths and moments on each by which a middle is judged."""
MARGIN = 0.98
"""Share of what the wheels can do that is driven with."""


@dataclass(frozen=True, slots=True)
class Course:
    """A figure-eight on a field."""

    middle: Pose2
    """Where the two circles touch, in the map."""
    eight: FigureEight

    def pose(self, rng: np.random.Generator, elapsed: float) -> Pose2:
        """Where a robot may be a time [s] after the start, on a path that is turned at random."""
        return self.middle @ on_eight(rng, elapsed, self.eight)


def course_on(field: Field, config: Config) -> Course:
    """The course on a field: the same for all seeds, at the speed that is set, if it can be."""
    xmin, ymin, xmax, ymax = field.roamed
    side = min(xmax - xmin, ymax - ymin)
    eight = _drivable(float(np.clip(BY_SIDE * side, *RADII)), config)
    middles = _middles(field, eight.radius)
    shown = _share_in_sight(field, eight, middles)
    best = int(np.argmax(shown))
    # The field's own middle is the first.
    chosen = middles[0] if shown[0] >= shown[best] - AS_GOOD else middles[best]
    return Course(Pose2(*chosen.tolist()), eight)


def _drivable(radius: float, config: Config) -> FigureEight:
    """Circles of a radius [m], no faster than wheels and limits allow."""
    spec, drive = RobotSpec.load(), config.drive
    fastest = min(
        MARGIN * spec.max_v / (1 + spec.track / 2 / radius),
        MARGIN * drive.max_angular_velocity * radius,
        drive.max_velocity,
    )
    eight = config.figure_eight
    return replace(eight, radius=radius, speed=min(eight.speed, fastest))


def _middles(field: Field, radius: float) -> Array:
    """Middles (n, 2) [m] from which the circles stay in or near the tape's box, its own first."""
    box = np.reshape(field.roamed, (2, 2))
    middle = box.mean(axis=0)
    room = np.maximum(np.ptp(box, axis=0) / 2 - REACH * radius, 0)
    step = max(STEP, float(room.max()) / MOST_STEPS)
    x, y = (step * np.arange(-n, n + 1) for n in np.floor(room / step).astype(int))
    around = np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2)
    order = np.argsort(np.hypot(*around.T), kind="stable")
    middles: Array = middle + around[order]
    return middles


def _share_in_sight(field: Field, eight: FigureEight, middles: Array) -> Array:
    """Share of the way (n,) on which tape is in sight, by where its middle is (n, 2)."""
    points = middles[:, None, None] + _points_ahead(eight)
    xmin, ymin, _, _ = field.extent
    distances = _distances(field)
    cells = np.floor((points - (xmin, ymin)) / CELL).astype(int)
    rows = np.clip(cells[..., 1], 0, distances.shape[0] - 1)
    columns = np.clip(cells[..., 0], 0, distances.shape[1] - 1)
    share: Array = (distances[rows, columns] < NEAR).any(axis=2).mean(axis=1)
    return share


def _points_ahead(eight: FigureEight) -> Array:
    """What the camera looks at (m, k, 2) [m], on paths of all turns about (0, 0)."""
    way, looks = [], np.array(LOOKS)
    for moment in np.arange(MOMENTS) / MOMENTS * eight.lap:
        left = min(float(moment), eight.lap / 2)
        right = float(moment) - left
        pose = eight.twist(0.0).integrate(left) @ eight.twist(eight.lap / 2).integrate(right)
        way.append(pose.apply(looks))
    turns = np.arange(TURNS) * 2 * math.pi / TURNS
    points = np.concatenate(way)
    turned = [Pose2(theta=float(turn)).apply(points) for turn in turns]
    return np.concatenate(turned).reshape(-1, len(looks), 2)


def _distances(field: Field) -> NDArray[np.float64]:
    """Distance from tape (h, w) [m] of the floor's cells; row 0 at the bottom."""
    free = (field.occupancy(CELL).data < 50).astype(np.uint8)
    return CELL * np.asarray(cv2.distanceTransform(free, cv2.DIST_L2, 5), dtype=np.float64)
