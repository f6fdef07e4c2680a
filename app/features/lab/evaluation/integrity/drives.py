"""Drives that integrity is judged by: laps of a figure-eight as large as fits, and a kidnapping."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import cv2
import numpy as np
from numpy.typing import NDArray

from app.engine.robots import robot_kind
from app.features.lab.evaluation.drives import Drive, Kidnap, random_pose_on_eight, record
from app.features.lab.evaluation.integrity.mishaps import MISHAP, LineCourse, Mishap
from app.settings.config import MAPS, Config
from robot.driving.figure_eight import FigureEight
from robot.fields.field import Field
from robot.fields.field_loading import load_field
from robot.geometry import Array, Pose2

CELL = 0.02
"""Cell size of the grid of distances from tape [m]."""
LOOKS = tuple((x, slope * x) for x in (0.2, 0.35, 0.5) for slope in (-0.4, 0.0, 0.4))
NEAR = 0.08
"""Tape is in sight if it is this near [m] to one of the points LOOKS in the robot's frame [m]."""
RADII = (0.10, 0.30)
"""Smallest and largest radius of a circle [m]."""
BY_SIDE = 0.19
"""Radius divided by the shorter side of the field: on a square of 1 m the paper's radius."""
REACH = 1.6
"""Radii around the middle that must lie within the tape's box; a path reaches two, and the rest
may lie beyond the tape."""
STEP = 0.1
"""Distance between the middles that are compared [m]; larger on floors as large as a building."""
MOST_STEPS = 12
"""Largest number of steps from the field's middle to its sides."""
AS_GOOD = 0.05
"""The field's middle is chosen unless another middle shows tape on more of the path, by more than
this share."""
TURNS, MOMENTS = 8, 32
"""Number of paths, and of moments on each path, that are used to judge a middle."""
MARGIN = 0.98
"""Share of the wheels' limits that a drive uses."""
CARRY_STAMP, CARRY_SECONDS = 11.0, 17.0
"""Stamp at which a robot is carried off, and duration of that drive [s]."""
PATH = 7
"""Number of the random stream, beside the seed, that the path is drawn from."""
LINE_SECONDS = 24.0
"""Duration of a drive along a line [s]."""
NONE = Mishap()
MOVED_SECONDS = 21.0
"""Duration of a drive in which the robot is moved while it stands [s]."""
MOVE = (0.05, 0.35)
"""Shortest and longest way that a robot is moved while it stands [m]."""
TURN_SD = 0.5
"""Standard deviation of its turn in half of the drives [rad]; in the others, it is any."""


@dataclass(frozen=True, slots=True)
class PlacedEight:
    """A figure-eight on a field."""

    middle: Pose2
    """Where the two circles touch, in the map."""
    eight: FigureEight

    def pose(self, rng: np.random.Generator, elapsed: float) -> Pose2:
        """Draw a pose some time [s] after the start, on a path that is turned at random."""
        return self.middle @ random_pose_on_eight(rng, elapsed, self.eight)


def course_on(field: Field, config: Config) -> PlacedEight:
    """Return the course on a field: the same for all seeds, at the set speed if it is drivable."""
    xmin, ymin, xmax, ymax = field.drive_area
    side = min(xmax - xmin, ymax - ymin)
    eight = _drivable(float(np.clip(BY_SIDE * side, *RADII)), config)
    middles = _middles(field, eight.radius)
    shown = _share_in_sight(field, eight, middles)
    best = int(np.argmax(shown))
    # The field's own middle is the first.
    chosen = middles[0] if shown[0] >= shown[best] - AS_GOOD else middles[best]
    return PlacedEight(Pose2(*chosen.tolist()), eight)


def _drivable(radius: float, config: Config) -> FigureEight:
    """Return circles of a radius [m], no faster than the wheels and the limits allow."""
    spec, drive = robot_kind(config).description(), config.drive
    fastest = min(
        MARGIN * spec.max_v / (1 + spec.track / 2 / radius),
        MARGIN * drive.max_angular_velocity * radius,
        drive.max_velocity,
    )
    eight = config.figure_eight
    return replace(eight, radius=radius, speed=min(eight.speed, fastest))


def _middles(field: Field, radius: float) -> Array:
    """Return middles (n, 2) [m] of circles in or near the tape's box; the box's own is first."""
    box = np.reshape(field.drive_area, (2, 2))
    middle = box.mean(axis=0)
    room = np.maximum(np.ptp(box, axis=0) / 2 - REACH * radius, 0)
    step = max(STEP, float(room.max()) / MOST_STEPS)
    x, y = (step * np.arange(-n, n + 1) for n in np.floor(room / step).astype(int))
    around = np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2)
    order = np.argsort(np.hypot(*around.T), kind="stable")
    middles: Array = middle + around[order]
    return middles


def _share_in_sight(field: Field, eight: FigureEight, middles: Array) -> Array:
    """Return the share of the path (n,) on which tape is in sight, for each middle (n, 2)."""
    points = middles[:, None, None] + _points_ahead(eight)
    xmin, ymin, _, _ = field.extent
    distances = _distances(field)
    cells = np.floor((points - (xmin, ymin)) / CELL).astype(int)
    rows = np.clip(cells[..., 1], 0, distances.shape[0] - 1)
    columns = np.clip(cells[..., 0], 0, distances.shape[1] - 1)
    share: Array = (distances[rows, columns] < NEAR).any(axis=2).mean(axis=1)
    return share


def _points_ahead(eight: FigureEight) -> Array:
    """Return the points that the camera looks at (m, k, 2) [m], on turned paths about (0, 0)."""
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
    """Return the distance from tape (h, w) [m] of each floor cell; row 0 is at the bottom."""
    free = (field.occupancy(CELL).data < 50).astype(np.uint8)
    return CELL * np.asarray(cv2.distanceTransform(free, cv2.DIST_L2, 5), dtype=np.float64)


@dataclass(frozen=True)
class TrialDrive:
    """A drive, and when the robot was carried off."""

    drive: Drive
    carry_stamp: float | None = None
    """The last stamp before the robot is carried off [s]; None if it never is."""


class _Path:
    """The path of a seed: the figure-eight that fits the field, begun at a random pose on it."""

    def __init__(self, config: Config, mishap: Mishap) -> None:
        field = load_field(config.map, MAPS)
        self._course = course_on(field, config)
        self._mishap = mishap
        for_mishap = np.random.default_rng([config.seed, MISHAP])
        self.line = LineCourse.beside_tape(field, for_mishap) if mishap.along_line else None
        self._floor = mishap.floor(field, for_mishap) if mishap.floor else None
        make = mishap.robot
        self._disturb = (lambda robot: make(robot, for_mishap)) if make else None
        self._config = replace(config, figure_eight=self._course.eight)
        self.lap = self._course.eight.lap
        """Duration of a lap [s]."""
        self.rng = np.random.default_rng([config.seed, PATH])
        self._elapsed = float(self.rng.uniform(0, self.lap))
        self._start = self._course.pose(self.rng, self._elapsed)

    def pose_after(self, seconds: float) -> Pose2:
        """Draw a pose at which the robot may be some time [s] after the start."""
        return self._course.pose(self.rng, self._elapsed + seconds)

    def drive(self, seconds: float, kidnap: Kidnap | None = None) -> TrialDrive:
        """Drive for some time [s]."""
        line = self.line
        drive = record(
            self._config,
            seconds,
            start=line.start if line else self._start,
            elapsed=self._elapsed,
            kidnap=kidnap,
            disturb=self._disturb,
            floor=self._floor,
            command=line.command if line else None,
        )
        return TrialDrive(drive, None if kidnap is None else kidnap.stamp)


def lap_drive(config: Config, laps: float = 1.0, mishap: Mishap = NONE) -> TrialDrive:
    """Drive the figure-eight that fits the field, from a random pose on it.

    Args:
        config: robot, map, seed and condition; the radius of its figure-eight is not used.
        laps: how many laps to drive; a drive along a line takes 24 s for each.
        mishap: what befalls the robot.
    """
    path = _Path(config, mishap)
    return path.drive(laps * (LINE_SECONDS if path.line else path.lap))


def carried_drive(config: Config, mishap: Mishap = NONE) -> TrialDrive:
    """Drive for 17 s; at 11 s the robot is carried off, unseen, to another path of the field."""
    path = _Path(config, mishap)
    elsewhere = path.pose_after(CARRY_STAMP)
    return path.drive(CARRY_SECONDS, Kidnap(CARRY_STAMP, lambda _: elsewhere))


def moved_drive(config: Config, mishap: Mishap = NONE) -> TrialDrive:
    """Drive for 21 s; it stands from 9.5 to 13 s, and at 11 s it is moved a little, unseen."""
    path = _Path(config, mishap)
    rng = path.rng
    way, bearing = rng.uniform(*MOVE), rng.uniform(-math.pi, math.pi)
    turn = rng.uniform(-math.pi, math.pi) if rng.random() < 0.5 else rng.normal(0, TURN_SD)
    moved = Pose2(way * math.cos(bearing), way * math.sin(bearing), float(turn))
    kidnap = Kidnap(CARRY_STAMP, lambda pose: pose @ moved, before=1.5, after=2.0)
    return path.drive(MOVED_SECONDS, kidnap)
