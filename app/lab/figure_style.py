"""How figures look: readable in print and for colour-blind people."""

from __future__ import annotations

import io
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any, NamedTuple

import matplotlib as mpl
from matplotlib.figure import Figure


class Stroke(NamedTuple):
    """How a trajectory is drawn: its colour or its dashes alone are enough to recognize it."""

    label: str
    colour: str
    dashes: str
    width: float


STROKES = {
    "truth": Stroke("truth", "#000000", "-", 2.6),
    "odometry": Stroke("odometry", "#d55e00", "--", 1.2),
    "amcl": Stroke("AMCL", "#56b4e9", "-", 1.1),
}
"""Colours of Okabe and Ito, which colour-blind people can distinguish."""

STYLE: Any = {
    "font.size": 9,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "svg.hashsalt": "brickpose",  # equal figures give equal files
    "svg.fonttype": "none",
    "axes.titlesize": 9,
}


@contextmanager
def svg_figure(width: float, height: float, svgs: list[str]) -> Iterator[Figure]:
    """Give a figure [inch] to draw on; its SVG is appended to ``svgs`` at the end."""
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(width, height), layout="constrained")
        yield figure
        text = io.StringIO()
        figure.savefig(text, format="svg", metadata={"Date": None})
    svgs.append(text.getvalue())
