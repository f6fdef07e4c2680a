"""Finds where tape ends: by rays that meet its end, that cross it just before and just beyond."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from robot.calibration.adjustment import DriveEstimate
from robot.calibration.drive_log import DriveLog
from robot.calibration.sightings import Sightings
from robot.calibration.wheel_motion import WheelMotion
from robot.description.spec import RobotSpec
from robot.geometry import Array
from robot.mapping.bare_floor import gaps
from robot.mapping.strokes import Stroke, Strokes

BEFORE, BEYOND = 0.12, 0.20
"""The end of tape is searched for this far before and beyond the end of its trace [m]."""
STEEP = math.sin(math.radians(25))
"""Sine of the least angle between tape and a ray that crosses it."""
ON_EDGE = 0.003
"""A ray enters tape by an edge if it does so within this distance of the edge [m]. Rays that meet
other tape near there hardly enter and leave it by both edges."""
OUTLIERS = 2
"""How many rays may be wrong."""
FACE = 0.006
"""Rays meet the end of tape farther than this from its corners [m]."""
LEAST_FACE, FACE_SD = 6, 0.004
"""The end is where rays met it, if at least this many did, and they scatter less than this [m]."""
BENT, BEND_OFF = 0.08, 0.005
"""Tape that bends over this length of its end [m] is assumed to go on bending. Its end is searched
straight ahead only while the bend is off that line by less than the second [m]."""


@dataclass(frozen=True, eq=False)
class RaysOnFloor:
    """All rays of a drive, on the floor; points (n, 2) in the map [m], nan where there is none."""

    begin: Array
    end: Array
    first: Array
    """Where a ray first met an edge of anything."""
    until: Array
    """Where it left that."""
    entry: Array
    """Where it entered tape."""
    leaving: Array
    """Where it left it."""
    picture: NDArray[np.intp]
    """(n,) of which picture."""
    light: NDArray[np.bool_] = field(default_factory=lambda: np.zeros(0, np.bool_))
    """(n,) whether the tape that it entered is lighter than the floor."""

    @classmethod
    def of(cls, log: DriveLog, spec: RobotSpec, state: DriveEstimate) -> RaysOnFloor:
        """Return the rays of a drive, from its adjusted path."""
        count, rays = len(log.stamps), len(log.rays)
        fan = np.broadcast_to(log.rays.transpose(1, 0, 2).reshape(-1, 2), (count, 2 * rays, 2))
        pixels = np.concatenate([fan, log.first, log.pixels], axis=1)
        seen = Sightings.of_edges(replace(log, pixels=pixels), spec, Strokes.of((), 0.0).edges)
        twists = WheelMotion.of(log, spec).twists(state.values, state.slip)
        local = seen.points(state.values, twists)
        c, s = np.cos(state.poses[:, 2])[:, None], np.sin(state.poses[:, 2])[:, None]
        x = state.poses[:, :1] + c * local[..., 0] - s * local[..., 1]
        y = state.poses[:, 1:2] + s * local[..., 0] + c * local[..., 1]
        points = np.stack([x, y], axis=-1).reshape(count, 6, rays, 2)
        picture = np.repeat(np.arange(count), rays)
        light = log.light.ravel() if log.light.size else np.zeros(len(picture), np.bool_)
        begin, end, first, until, entry, leaving = (
            points[:, part].reshape(-1, 2) for part in range(6)
        )
        return cls(begin, end, first, until, entry, leaving, picture, light)


@dataclass(frozen=True, eq=False)
class End:
    """One end of a stroke."""

    place: Array
    """(2,) where the centre line was traced to [m]."""
    outward: Array
    """(2,) unit vector along the tape, away from it."""
    lower: float
    """The tape goes at least this far beyond that place [m]."""
    upper: float
    """Beyond this there is bare floor [m]; inf if nobody saw it."""
    face: float
    """Where rays met the end of the tape [m]; nan if none did."""
    ahead: float = BEYOND
    """Farther than this, tape that bends would not lie straight ahead [m]."""

    @property
    def length(self) -> float:
        """How far the tape goes on beyond the place [m], if it ends freely."""
        if not math.isnan(self.face):
            return self.face
        return max(self.lower, 0.0) if math.isinf(self.upper) else (self.lower + self.upper) / 2

    @property
    def sd(self) -> float:
        """Standard deviation of that [m]; inf if nobody saw the end."""
        if not math.isnan(self.face):
            return FACE_SD / 4
        return max(abs(self.upper - self.lower) / 2, FACE_SD / 2)


def find_end(stroke: Stroke, last: bool, width: float, rays: RaysOnFloor) -> End:
    """Return how far tape of a width [m] goes on at one end of its stroke."""
    place, outward = stroke.end(last)
    ahead = straight_ahead(stroke, last)
    left = np.array([-outward[1], outward[0]])
    around = np.hypot(*(rays.begin - place).T) < 1.5
    axes = np.column_stack([outward, left])
    begin, end, first, entry, leaving = (
        (points[around] - place) @ axes
        for points in (rays.begin, rays.end, rays.first, rays.entry, rays.leaving)
    )
    way = end - begin
    length = np.hypot(way[:, 0], way[:, 1])
    with np.errstate(invalid="ignore", divide="ignore"):
        reached = (np.array([-width / 2, width / 2]) - begin[:, 1:]) / way[:, 1:]
        crosses = (reached > 0).all(axis=1) & (reached < 1).all(axis=1)
        crosses &= np.abs(way[:, 1]) > STEEP * length
        across = begin[:, :1] + reached * way[:, :1]
        inner, outer = across.max(axis=1), across.min(axis=1)
        near_side = np.where(way[:, 1] > 0, -width / 2, width / 2)
        near = np.where(way[:, 1] > 0, across[:, 0], across[:, 1])
        met = np.hypot(*(first - begin).T) / length
        on_edge = np.abs(entry[:, 1] - near_side) < ON_EDGE
        on_edge &= np.abs(leaving[:, 1] + near_side) < ON_EDGE
        on_edge &= np.abs(entry[:, 0] - near) < 4 * ON_EDGE
        bare = np.isnan(met) | (met > reached.max(axis=1) + 0.02 / length)
    window = crosses & (inner > -BEFORE) & (outer < ahead)
    middle = (inner + outer) / 2
    gap = next(gaps(middle[window & on_edge], middle[window & bare], -BEFORE, ahead), None)
    if gap is not None:
        # Tape beyond bare floor is another piece, such as the next dash.
        window &= middle < gap[1]
        on_edge &= middle < gap[0]
    lower = -_robust(-inner[window & on_edge], 0.0)
    upper = _robust(outer[window & bare], math.inf)
    on_face = (np.abs(first[:, 1]) < width / 2 - FACE) & (begin[:, 0] > first[:, 0] + 0.02)
    # Unless bare floor was seen beyond, what is farther may be other tape.
    farthest = lower + 0.04 if math.isinf(upper) else upper
    on_face &= (first[:, 0] > lower - 0.01) & (first[:, 0] < farthest + 0.01)
    return End(place, outward, lower, max(upper, lower), _face(first[on_face, 0]), ahead)


def straight_ahead(stroke: Stroke, last: bool) -> float:
    """Return how far ahead of an end its tape is looked for [m]: less, the more it bends."""
    if not stroke.curved or stroke.knots[-1] < BENT:
        return BEYOND
    end = stroke.knots[-1] if last else 0.0
    before, after = stroke.spline(stroke.nodes)([end, abs(end - BENT)], 1)
    sine = before[0] * after[1] - before[1] * after[0]
    curvature = abs(math.atan2(sine, before @ after)) / BENT
    return min(BEYOND, math.sqrt(2 * BEND_OFF / max(curvature, 1e-3)))


def _robust(values: Array, without: float) -> float:
    """Return the least value (n,), but for some outliers."""
    if len(values) <= 2 * OUTLIERS:
        return without
    return float(np.partition(values, OUTLIERS)[OUTLIERS])


def _face(places: NDArray[np.float64]) -> float:
    """Return where rays (n,) met the end of tape [m]; nan if they do not agree."""
    if len(places) < LEAST_FACE:
        return math.nan
    middle = float(np.median(places))
    scatter = float(np.median(np.abs(places - middle)))
    return middle if scatter < FACE_SD / 2 else math.nan
