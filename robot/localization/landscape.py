"""The likelihood landscape: how well a scan fits all over the field, and at all headings."""

from __future__ import annotations

import math
import time
from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np

from robot.fields.floor_picture import Extent
from robot.geometry import Array
from robot.localization.weighing import Weighing

STEPS = (0.005, 0.01, 0.02, 0.04, 0.08, 0.16, 0.32, 0.64)
"""Sides of cells to choose from [m]."""
MOST_CELLS = 90_000
"""Most cells, whatever the time allows: the page draws 300 x 300 of them."""
BUDGET_S = 0.5
"""Longest time for a landscape [s]; if one would take longer, its cells are larger."""
PIECE = 4096
"""Poses weighed at the same time: a user's own model may need memory for each ray of each pose."""
HEADINGS = 360
"""Headings that are weighed at a place: one a degree."""


@dataclass(frozen=True, slots=True, eq=False)
class Landscape:
    """Log-weights of a scan in the cells of the field, at one heading."""

    origin: tuple[float, float]
    """x, y of the middle of the first cell [m]."""
    step: float
    """Side of a cell [m]."""
    theta: float
    logs: Array = field(repr=False)
    """(rows, columns), by y and x: the log of the weight that a particle there would get."""


def landscape(weighing: Weighing, extent: Extent, theta: float) -> Landscape:
    """Weigh an area at one heading, in cells as fine as ``BUDGET_S`` allows."""
    xmin, ymin, xmax, ymax = extent
    area = (xmax - xmin) * (ymax - ymin)
    most = min(MOST_CELLS, BUDGET_S / max(_seconds(weighing, extent, theta), 1e-9))
    step = next((step for step in STEPS if area / step**2 <= most), STEPS[-1])
    columns = max(1, math.floor((xmax - xmin) / step))
    rows = max(1, math.floor((ymax - ymin) / step))
    x, y = xmin + step * (0.5 + np.arange(columns)), ymin + step * (0.5 + np.arange(rows))
    poses = np.full((rows * columns, 3), theta)
    poses[:, 0], poses[:, 1] = np.tile(x, rows), np.repeat(y, columns)
    logs = weighing.power * np.concatenate(list(_asked(weighing, poses)))
    return Landscape((float(x[0]), float(y[0])), step, theta, logs.reshape(rows, columns))


def by_heading(weighing: Weighing, x: float, y: float) -> tuple[Array, Array]:
    """Return headings (k,) [rad] of a full turn at a place, and the log-weight (k,) at each."""
    thetas = np.linspace(-math.pi, math.pi, HEADINGS, endpoint=False)
    poses = np.column_stack([np.full(HEADINGS, x), np.full(HEADINGS, y), thetas])
    return thetas, weighing.power * weighing.log_likelihoods(poses)


def _seconds(weighing: Weighing, extent: Extent, theta: float) -> float:
    """Return the time that one pose takes [s], measured with a few poses."""
    xmin, ymin, xmax, ymax = extent
    tried = np.random.default_rng(0).uniform((xmin, ymin, theta), (xmax, ymax, theta), (256, 3))
    began = time.perf_counter()
    weighing.log_likelihoods(tried)
    return (time.perf_counter() - began) / len(tried)


def _asked(weighing: Weighing, poses: Array) -> Iterator[Array]:
    for start in range(0, len(poses), PIECE):
        yield weighing.log_likelihoods(poses[start : start + PIECE])
