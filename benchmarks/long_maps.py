"""Benchmark of maps of long drives: processor time, memory and accuracy, by the length of a drive.

Robots drive over all of a floor, lap after lap, and each map is drawn in a process of its own.
"""

from __future__ import annotations

import math
import multiprocessing
import resource
import tempfile
import time
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TypeVar

import numpy as np

from benchmarks.constant_maps import LoggedDrive, draw_map, driven, recorded
from benchmarks.result import Result
from robot.fields.field import Field
from robot.geometry import Pose2, Twist2, wrap_angle

DRIVES = (
    ("square", 9021, "default"),
    ("tee", 9024, "default"),
    ("generated-6604", 9022, "default"),
    ("stub", 9023, "hand-built"),
)
"""Floors, robots and how these were built; one that was built by hand is calibrated along."""
LAP_S, LAPS, LONGEST_S = 16.0, (1, 4, 16), 1800.0
"""A lap over one of these floors, how many of them, and half an hour [s]."""
ASIDE, LANE = 0.22, 0.45
"""Distance of the way from the edge of the floor, and of its lanes [m]."""
SPEED, REACHED = 0.15, 0.05
"""Of the robot [m/s], and how near it comes to a corner of its way [m]."""
WARM_S = 8.0
"""A short drive is mapped first, which loads compiled code [s]."""
T = TypeVar("T")


def measure() -> Result:
    """Measure all drives; the half hour on the first floor is the figure."""
    more: dict[str, float] = {}
    with tempfile.TemporaryDirectory() as folder:
        for name, seed, condition in DRIVES:
            kept = Path(folder) / name
            _alone(_record, name, seed, condition, LONGEST_S, kept)
            lengths = {f"{laps} laps": laps * LAP_S for laps in LAPS} | {"30 min": LONGEST_S}
            for words, seconds in lengths.items():
                figures = _alone(_mapped, kept, seconds, condition != "default")
                title = f"{name}, {condition}, {words}"
                more |= {f"{title} {unit}": figure for unit, figure in figures.items()}
    name, _, condition = DRIVES[0]
    figure = more[f"{name}, {condition}, 30 min [s]"]
    return Result("s of processor time for the map of half an hour", figure, more=more)


@dataclass
class Rounds:
    """Drives over all of a floor as a hand would: around it, and in lanes across, both ways."""

    field: Field

    def __post_init__(self) -> None:
        self._corners: list[tuple[float, float]] = []
        self._lap = 0

    def __call__(self, pose: Pose2) -> Twist2:
        """Return how to drive on from where the robot truly is."""
        while not self._corners or math.dist(self._corners[0], (pose.x, pose.y)) < REACHED:
            self._corners = self._corners[1:] or self._next_lap()
        x, y = self._corners[0]
        turn = wrap_angle(math.atan2(y - pose.y, x - pose.x) - pose.theta)
        v = SPEED * max(0.0, math.cos(turn)) if abs(turn) < 1 else 0.02
        return Twist2(v, min(max(-1.0, 2 * turn), 1.0))

    def _next_lap(self) -> list[tuple[float, float]]:
        xmin, ymin, xmax, ymax = self.field.drive_area
        xs, ys = _lanes(xmin, xmax), _lanes(ymin, ymax)
        ring = [(xs[0], ys[0]), (xs[-1], ys[0]), (xs[-1], ys[-1]), (xs[0], ys[-1])]
        way = ring[:: -1 if self._lap % 2 else 1]
        for lane, y in enumerate(ys[1:-1]):
            way += [(x, y) for x in (xs[::-1] if (lane + self._lap) % 2 == 0 else xs)]
        self._lap += 1
        return way


def _lanes(low: float, high: float) -> list[float]:
    low, high = low + ASIDE, high - ASIDE
    lanes: list[float] = np.linspace(low, high, max(2, 1 + round((high - low) / LANE))).tolist()
    return lanes


def _alone(work: Callable[..., T], *given: object) -> T:
    """Do work in a new process."""
    context = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(1, context) as pool:
        return pool.submit(work, *given).result()


def _record(name: str, seed: int, condition: str, seconds: float, kept: Path) -> None:
    recorded(kept, lambda: [driven(condition, name, seed, seconds, steer=Rounds)])


def _mapped(kept: Path, seconds: float, calibrate: bool) -> dict[str, float]:
    """Return processor time, memory and errors of the map of a drive's first seconds."""
    (drive,) = recorded(kept)
    draw_map(_beginning(drive, WARM_S))
    drive = _beginning(drive, seconds)
    memory = _peak()
    began = time.process_time()
    drawn = draw_map(drive, calibrate=calibrate)
    spent = time.process_time() - began
    mean, largest, missing = drawn.figures
    return {
        "[s]": spent,
        "memory, all [MB]": _peak(),
        "memory, of these before [MB]": memory,
        "edges off, mean [mm]": mean,
        "edges off, largest [mm]": largest,
        "not drawn [%]": missing,
    }


def _peak() -> float:
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024


def _beginning(drive: LoggedDrive, seconds: float) -> LoggedDrive:
    stamps = drive.log.stamps
    count = int(np.searchsorted(stamps, stamps[0] + seconds, side="right"))
    return replace(drive, log=drive.log.between(0, count), path=drive.path[:count])
