"""The camera's mounting by the tape of a field, with the robot at a known place.

The pixels in which tape begins and ends do not depend on the mounting. The mounting is the one that
lays them on the field's edges.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from robot.calibration.drive_log import LOOSE
from robot.calibration.lens.sighting import Grey
from robot.calibration.misses import nearest_edges
from robot.calibration.mounting.mounting import (
    UNITS,
    Mounting,
    MountingError,
    derivatives,
    moved,
    vague,
)
from robot.calibration.tape_edges import TapeEdges
from robot.camera import FloorView, Lens
from robot.description.unknowns import PRIORS, ROTATION, SHIFT
from robot.estimation.fit_quality import FitQuality, correlation_of, overruns, robust_sd
from robot.fields.field import Field
from robot.geometry import Array, Pose2
from robot.scanning.line_scanner import LineScanner, LineScannerSettings

GATES = (0.10, 0.06, 0.03, 0.015, 0.008)
"""Edges that are seen farther from the field's do not count, one adjustment after the other [m]."""
EDGE_SD = 0.1
"""Standard deviation of an edge in the picture [px]; neighbours err together."""
LEAST_EDGES = 30
"""With fewer edges, nothing is told."""
LEAST_SHARE = 0.7
"""Share of the edges that must lie on the field's; else it is another place or field."""
FAR_OFF_PX = 3.0
"""Edges that lie farther off [px] are not those of the field."""
MOST_SD = 4.0
"""A camera that is farther from its description, in standard deviations of a robot that was built
by hand, is none: the robot stands elsewhere."""
PLACED_SD = np.array([0.002, 0.002, math.radians(0.5)])
"""How well a robot is put by hand where it is said to stand [m, m, rad]."""


Places = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class _Edges:
    """Where rays meet edges in the picture, and the field that they may be of."""

    lens: Lens
    pixels: Array
    leaving: Array
    taped: Field
    placed: Pose2

    def on_map(self, robot_from_camera: Array) -> Array:
        """Return where the edges lie on the map (n, 2) [m]."""
        floor = FloorView(self.lens, robot_from_camera).floor_points(self.pixels)
        return self.placed.apply(floor)

    def matched(self, robot_from_camera: Array, gate: float) -> Places:
        """Return the field's edge of each (n,); -1 without one."""
        points = self.on_map(robot_from_camera)
        toward = points - (self.placed.x, self.placed.y)
        toward /= np.linalg.norm(toward, axis=1)[:, None]
        toward[self.leaving] *= -1
        tape = TapeEdges.of(self.taped.edges)
        toward = np.ascontiguousarray(toward)
        return nearest_edges(points, toward, tape.edges, tape.normals, tape.margins, gate)

    def errors(self, robot_from_camera: Array, edge: Places) -> Array:
        """Return how far edges lie off the field's in the picture (n,) [px]."""
        view = FloorView(self.lens, robot_from_camera)
        points = self.on_map(robot_from_camera)
        normal = self.taped.normals[edge]
        off_m = (normal * (points - self.taped.edges[edge, :2])).sum(axis=1)
        foot = self.placed.inverse().apply(points - off_m[:, None] * normal)
        across = np.linalg.norm(view.pixels(foot) - self.pixels, axis=1)
        result: Array = np.nan_to_num(np.copysign(across, off_m), nan=100.0)
        return result


def mounting_by_tape(
    lens: Lens,
    picture: Grey,
    taped: Field,
    placed: Pose2,
    described: Array,
    settings: LineScannerSettings,
) -> Mounting:
    """Return the mounting by a picture of the field's tape.

    Args:
        lens: the camera's.
        picture: grey (h, w), of the lens's size.
        taped: the field as drawn.
        placed: where the robot stands in the map.
        described: (4, 4) pose of the camera in the robot's description.
        settings: how tape is searched for.

    Raises:
        MountingError: too little tape is in sight, or it is not where the field has it.
    """
    seen = _search(lens, picture, taped, placed, described, settings)
    prior = np.concatenate([PRIORS[ROTATION], PRIORS[SHIFT]])
    shares = np.zeros(6)
    for gate in GATES:
        edge = seen.matched(moved(described, shares * prior), gate)
        near = np.flatnonzero(edge >= 0)
        if len(near) < LEAST_EDGES:
            raise MountingError(_elsewhere(len(near), len(edge)))
        some, edge = _part(seen, near), edge[near]

        def errors(shares: Array, some: _Edges = some, edge: Places = edge) -> Array:
            return some.errors(moved(described, shares * prior), edge)

        def weighted(shares: Array) -> Array:
            return np.concatenate([errors(shares) / EDGE_SD, shares])

        fitted = least_squares(weighted, shares, loss="soft_l1", f_scale=10)
        shares = np.asarray(fitted.x)
    last = errors(shares)
    rms = float(np.sqrt(np.mean(last**2)))
    lost = len(near) < LEAST_SHARE * len(seen.pixels)
    if lost or rms > FAR_OFF_PX or np.abs(shares).max() > MOST_SD:
        raise MountingError(_elsewhere(len(near), len(seen.pixels)))
    slopes = derivatives(weighted, shares, 1e-4)
    scatter = max(1.0, rms / EDGE_SD)
    covariance = np.outer(prior, prior) * np.asarray(np.linalg.inv(slopes.T @ slopes), float)
    covariance *= scatter**2
    result = moved(described, shares * prior)
    covariance += _of_place(result)
    quality = FitQuality(
        robust_sd(last / EDGE_SD),
        bool(fitted.success),
        correlation_of(last),
        overruns(shares, np.ones(6), tuple(UNITS)),
        vague(covariance),
    )
    return Mounting(result, covariance, last, quality)


def _search(
    lens: Lens,
    picture: Grey,
    taped: Field,
    placed: Pose2,
    described: Array,
    settings: LineScannerSettings,
) -> _Edges:
    scanner = LineScanner(FloorView(lens, described), replace(settings, **LOOSE), taped.tape)
    pairs = scanner.tape_and_first_edges(picture)[0]
    pixels = np.concatenate([scanner.pixels(side) for side in pairs.T])
    leaving = np.arange(len(pixels)) >= len(pairs)
    seen = np.isfinite(pixels[:, 0])
    if seen.sum() < LEAST_EDGES:
        raise MountingError(
            f"{seen.sum()} edges of tape in sight; valid are {LEAST_EDGES} or more: tape of "
            f"{1e3 * scanner.main_width:.0f} mm within a metre before the robot"
        )
    return _Edges(lens, pixels[seen], leaving[seen], taped, placed)


def _part(seen: _Edges, places: Places) -> _Edges:
    return replace(seen, pixels=seen.pixels[places], leaving=seen.leaving[places])


def _elsewhere(near: int, count: int) -> str:
    return (
        f"{near} of {count} edges of tape lie where the field has them: the robot does not stand "
        "where --start says, or this is another field"
    )


def _of_place(robot_from_camera: Array) -> Array:
    """Return the covariance (6, 6) by the robot's place, which was told."""
    # The camera is where it is: what the robot's place is off, its mounting is off the other way.
    x, y = robot_from_camera[:2, 3]
    by_place = np.zeros((6, 3))
    by_place[3:5, :2] = np.eye(2)
    by_place[2, 2] = 1
    by_place[3:5, 2] = -y, x
    result: Array = by_place @ np.diag(PLACED_SD**2) @ by_place.T
    return result
