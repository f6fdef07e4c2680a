"""Laps over tape that lies elsewhere, or is missing, seen by a perfect laser."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace

import numpy as np
from floor_scans import BEARINGS, CENTRE, NOISE, PERIOD

from robot.fields.field import Field
from robot.geometry import Array, Pose2
from robot.misplaced_tape.laid_tracker import LaidTracker
from robot.misplaced_tape.pieces import TapePiece
from robot.misplaced_tape.tracker import PlaceTracker
from robot.scan import Scan, rays_of
from sim.imperfections import Imperfections

REACH = 0.6
WHEELS = 1.01, 0.98
"""What odometry reports of ways and turns."""
NOTHING = rays_of(Scan(0.0, np.linspace(-1, 1, 61), np.full(61, np.inf), Pose2()), 61)
"""Rays (61, 9) that return nothing."""


def moved(field: Field, piece: TapePiece, shift: tuple[float, float] | None) -> Field:
    """Return a field with a piece moved [m], or without it."""
    edges = field.edges.copy()
    if shift is None:
        return replace(field, edges=np.delete(edges, piece.edges, axis=0))
    edges[piece.edges] += np.tile(shift, 2)
    return replace(field, edges=edges)


def laid_by_hand(field: Field, seed: int, sd: float = 0.008, scale: float = 1.0) -> Field:
    """Return a field whose tape is off by so much [m], smoothly, and which is larger."""
    rng = np.random.default_rng(seed)
    waves = rng.normal(0.0, 1 / 0.3, (6, 2))
    sizes, phases = rng.normal(0.0, sd * np.sqrt(2 / 6), (6, 2)), rng.uniform(0, 6.3, 6)
    points = _parts(field.edges).reshape(-1, 2)
    shifts = np.cos(points @ waves.T + phases) @ sizes
    return replace(field, edges=(scale * points + shifts).reshape(-1, 4))


def _parts(edges: Array) -> Array:
    """Return edges cut into tenths, which bend."""
    cuts = np.linspace(0, 1, 11)[:, None, None]
    points = edges[:, :2] + cuts * (edges[:, 2:] - edges[:, :2])
    return np.concatenate([points[:-1], points[1:]], axis=2).reshape(-1, 4)


def laps(
    floor: Field,
    seconds: float,
    start: Pose2 = Pose2(0.0, -0.2),
    *,
    seed: int = 4,
    reach: float = REACH,
    wheels: tuple[float, float] = WHEELS,
) -> Iterator[tuple[Scan, Pose2, Pose2]]:
    """Drive in circles to the left; scans, odometry that errs a little, and the truth."""
    rng, truth, odometry = np.random.default_rng(seed), start, Pose2()
    step = Pose2(0.15 * PERIOD, 0.0, 0.75 * PERIOD)
    reported = Pose2(wheels[0] * step.x, 0.0, wheels[1] * step.theta)
    for number in range(round(seconds / PERIOD)):
        seen: Array = floor.ranges((truth @ CENTRE).to_array()[None], BEARINGS, reach)[0]
        seen = seen + rng.normal(0.0, NOISE, len(seen))
        yield Scan(number * PERIOD, BEARINGS, seen, CENTRE), odometry, truth
        truth, odometry = truth @ step, odometry @ reported


def slip_surprises(begin: Callable[[], PlaceTracker | LaidTracker]) -> list[float]:
    """By what turns of slipping wheels surprise a tracker that sees nothing: squares of standard
    deviations."""
    squared = []
    for seed in range(60):
        tracker, turned = begin(), 0.0
        start, known = tracker.pose.theta, tracker.covariance[2, 2]
        for step, turn in _slipping(seed):
            tracker.step(step, NOTHING)
            turned += turn
        off = tracker.pose.theta - start - turned
        squared.append(off**2 / (tracker.covariance[2, 2] - known))
    return squared


def _slipping(
    seed: int, way: float = 0.3, step: float = 0.004, track: float = 0.112
) -> Iterator[tuple[Pose2, float]]:
    """Steps of odometry straight on, and the turns [rad] that slipping wheels add to the truth."""
    usual, rng = Imperfections(), np.random.default_rng(seed)
    kept = np.exp(-PERIOD / usual.slip_time)
    slip = usual.slip_sd * rng.standard_normal(2)
    for _ in range(round(way / step)):
        yield Pose2(step), step * (slip[1] - slip[0]) / track
        slip = kept * slip + usual.slip_sd * np.sqrt(1 - kept**2) * rng.standard_normal(2)
