"""Write and read claims as CSV, so that others can compute measures of their own."""

from __future__ import annotations

import csv
import io
from pathlib import Path

import numpy as np

from app.lab.evaluation.integrity.claims import Claims
from robot.geometry import Array

COLUMNS = (
    "stamp", "true_x", "true_y", "true_theta", "x", "y", "theta",
    "state", "radius", "heading_bound", "weight",
)  # fmt: skip
"""Seconds, metres, radians; the pose is the estimate at the picture's stamp, nan without one; the
radius is inf without a bound."""
STATE = COLUMNS.index("state")


def claims_csv(claims: Claims) -> str:
    """Return the claims as CSV, one line for each picture."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(COLUMNS)
    numbers = np.column_stack([claims.stamps, claims.truth, claims.poses])
    bounds = np.column_stack([claims.radius, claims.heading_bound, claims.weights])
    for before, state, after in zip(numbers, claims.states, bounds, strict=True):
        writer.writerow([*map(_short, before), str(state), *map(_short, after)])
    return text.getvalue()


def read_numbers(path: Path) -> dict[str, Array]:
    """Read the numeric columns by name, each (n,)."""
    wanted = [place for place in range(len(COLUMNS)) if place != STATE]
    rows = np.loadtxt(path, delimiter=",", skiprows=1, usecols=wanted, ndmin=2)
    return {COLUMNS[place]: column for place, column in zip(wanted, rows.T, strict=True)}


def _short(value: float) -> str:
    """Format a value to a micrometre, a microradian or a microsecond."""
    return f"{value:.6f}"
