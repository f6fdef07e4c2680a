"""Maps drawn by simulated robots, and how far they are from the floor."""

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from calibrations import SPEC, driven
from scipy.spatial import cKDTree

from robot.driving.figure_eight import FigureEight
from robot.fields.edges import sample
from robot.fields.field import Field
from robot.fields.svg_field import field_of_drawing
from robot.geometry import Array, Pose2, Twist2, wrap_angle
from robot.mapping.mapper import Mapper
from robot.mapping.tape_map import TapeMap

WIDTH = 0.05
EIGHT = FigureEight()
STEP = 0.004
"""Distance of the points at which edges are compared [m]."""
LARGEST = 0.2
"""No error counts as larger [m]."""
COVERED = 0.02
ASIDE, LANE = 0.22, 0.45
"""Distance of a tour from the edge of the field, and of its lanes [m]."""


def eight(elapsed: float) -> Twist2:
    return EIGHT.twist(elapsed)


class Tour:
    """Drives over all of a field as a hand would: around it, and in lanes across; so many laps."""

    def __init__(self, taped: Field, laps: int) -> None:
        xmin, ymin, xmax, ymax = taped.drive_area
        xs, ys = _lanes(xmin, xmax), _lanes(ymin, ymax)
        ring = [(xs[0], ys[0]), (xs[-1], ys[0]), (xs[-1], ys[-1]), (xs[0], ys[-1])]
        self._points = []
        for lap in range(laps):
            self._points += ring[:: -1 if lap % 2 else 1]
            for lane, y in enumerate(ys[1:-1], start=1):
                self._points += [(x, y) for x in (xs if (lane + lap) % 2 == 0 else xs[::-1])]

    def __call__(self, pose: Pose2) -> Twist2 | None:
        while self._points and math.dist(self._points[0], (pose.x, pose.y)) < LANE / 9:
            self._points.pop(0)
        if not self._points:
            return None
        x, y = self._points[0]
        turn = wrap_angle(math.atan2(y - pose.y, x - pose.x) - pose.theta)
        v = 0.15 * max(0.0, math.cos(turn)) if abs(turn) < 1 else 0.02
        return Twist2(v, min(max(-1.0, 2 * turn), 1.0))


def square_of(side: float) -> str:
    """A drawing of a square of tape with a side [m], for loops that are longer than in ``maps``."""
    half, floor = 500 * side, 500 * side + 250
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{2 * floor}mm" height="{2 * floor}mm" '
        f'viewBox="{-floor} {-floor} {2 * floor} {2 * floor}" '
        f'data-start="{200 - half} {200 - half} 0"><title>Square</title>'
        f'<rect x="{-half}" y="{-half}" width="{2 * half}" height="{2 * half}" fill="none" '
        'stroke="#202225" stroke-width="50"/></svg>'
    )


class Loop(Tour):
    """Drives along the tape of a square, 0.2 m inside it, and a metre farther than once around."""

    def __init__(self, side: float) -> None:
        far = side / 2 - 0.2
        corners = [(far, -far), (far, far), (-far, far), (-far, -far), (1 - far, -far)]
        self._points = corners


def _lanes(low: float, high: float) -> Array:
    low, high = low + ASIDE, high - ASIDE
    return np.linspace(low, high, max(2, 1 + round((high - low) / LANE)))


@dataclass(frozen=True)
class Errors:
    """How far a map is off after rigid alignment [m]."""

    path: float
    """Root mean square of the path's error, aligned by itself."""
    mean: float
    largest: float
    """Of the map's edges, from those of the floor."""
    covered: float
    """Share of the floor's edges that the map has."""


@lru_cache(maxsize=8)
def mapped(
    name: str,
    seed: int,
    world: str = "default",
    seconds: float = 16.5,
    motion: Callable[[float], Twist2] = eight,
    *,
    calibrate: bool = False,
    steer: Callable[[Pose2], Twist2 | None] | None = None,
) -> tuple[TapeMap, Array]:
    """The map of one drive, and the robot's true poses at the pictures that were used."""
    log, _, poses = driven(
        world, seed, seconds, motion, name, calibrated=not calibrate, steer=steer
    )
    drawn = Mapper(log, SPEC, WIDTH, calibrate=calibrate).run()
    return drawn, poses[np.searchsorted(log.stamps, drawn.stamps)]


def field_of(drawn: TapeMap) -> Field:
    return field_of_drawing(drawn.drawing("drawn"), "drawn")


def aligned(points: Array, others: Array) -> Pose2:
    """The rigid motion that lays points (n, 2) on others best."""
    middle, other = points.mean(axis=0), others.mean(axis=0)
    around, opposite = points - middle, others - other
    sine = (around[:, 0] * opposite[:, 1] - around[:, 1] * opposite[:, 0]).sum()
    theta = math.atan2(sine, (around * opposite).sum())
    turned = Pose2(0.0, 0.0, theta).apply(middle[None])[0]
    return Pose2(*(other - turned).tolist(), theta)


def laid_on(drawn: TapeMap, poses: Array, taped: Field) -> Pose2:
    """The rigid motion that lays a map on the floor, by its path first, then by its edges."""
    path = drawn.solution.state.poses[:, :2]
    floor_from_map = aligned(path, poses[:, :2])
    points, normals = sample(field_of(drawn).edges, STEP)
    truth, true_normals = sample(taped.edges, STEP / 8)
    for _ in range(5):
        moved = floor_from_map.apply(points)
        turned = normals @ _rotation(floor_from_map.theta).T
        distance, place = _nearest(moved, turned, truth, true_normals)
        close = distance < COVERED
        floor_from_map = aligned(moved[close], truth[place[close]]) @ floor_from_map
    return floor_from_map


def errors_of(drawn: TapeMap, poses: Array, taped: Field) -> Errors:
    path = drawn.solution.state.poses[:, :2]
    off = np.hypot(*(aligned(path, poses[:, :2]).apply(path) - poses[:, :2]).T)
    points, normals = sample(field_of(drawn).edges, STEP)
    truth, true_normals = sample(taped.edges, STEP / 8)
    floor_from_map = laid_on(drawn, poses, taped)
    moved = floor_from_map.apply(points)
    turned = normals @ _rotation(floor_from_map.theta).T
    distance, _ = _nearest(moved, turned, truth, true_normals)
    missing, _ = _nearest(truth, true_normals, moved, turned)
    return Errors(
        float(np.sqrt(np.mean(off**2))),
        float(distance.mean()),
        float(distance.max()),
        float((missing < COVERED).mean()),
    )


def held(drawn: TapeMap, poses: Array, taped: Field) -> Array:
    """Which of the map's edge points lie within their 95 % intervals of the true edges (n,).

    The map lies on the floor as its first picture does; points of tape that is none count not.
    """
    floor_from_map = (
        Pose2.from_array(poses[0]) @ Pose2.from_array(drawn.solution.state.poses[0]).inverse()
    )
    points, sides, sd = [], [], []
    for stroke in drawn.measured.each:
        across = stroke.across @ _rotation(floor_from_map.theta).T
        nodes = floor_from_map.apply(stroke.nodes)
        points += [nodes + WIDTH / 2 * across, nodes - WIDTH / 2 * across]
        sides += [across, -across]
    counts = np.cumsum([len(stroke.nodes) for stroke in drawn.measured.each])
    for own in np.split(drawn.node_sd, counts[:-1]):
        sd += [own, own]
    off = _beside(np.vstack(points), np.vstack(sides), taped)
    known = off < COVERED
    return off[known] < 1.96 * np.concatenate(sd)[known]


def _beside(points: Array, normals: Array, taped: Field) -> Array:
    """How far points (n, 2) lie beside the nearest true edge that faces the same side (n,) [m]."""
    start, way = taped.edges[:, :2], taped.edges[:, 2:] - taped.edges[:, :2]
    length = np.hypot(*way.T)
    away = points[:, None] - start
    along = (away * way).sum(axis=2) / length
    off = np.abs((away * taped.normals).sum(axis=2))
    beside = (normals @ taped.normals.T > 0.9) & (along > -0.005) & (along < length + 0.005)
    return np.where(beside, off, np.inf).min(axis=1)


def _rotation(theta: float) -> Array:
    return np.array([[math.cos(theta), -math.sin(theta)], [math.sin(theta), math.cos(theta)]])


def _nearest(points: Array, normals: Array, others: Array, other_normals: Array):
    """The distance to the nearest point that has its tape on about the same side, and which."""
    # A third coordinate keeps apart what faces elsewhere.
    scale = LARGEST
    tree = cKDTree(np.hstack([others, scale * other_normals]))
    _, place = tree.query(np.hstack([points, scale * normals]))
    distance = np.hypot(*(points - others[place]).T)
    return np.minimum(distance, LARGEST), place
