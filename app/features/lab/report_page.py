"""Reports: figures for print and colour-blind people, and one page that opens anywhere."""

from __future__ import annotations

import base64
import io
import math
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, NamedTuple

import matplotlib as mpl
from jinja2 import Environment, FileSystemLoader, StrictUndefined
from matplotlib.figure import Figure

STYLE: Any = {
    "font.size": 9,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "svg.hashsalt": "brickpose",  # equal figures give equal files
    "svg.fonttype": "none",
    "axes.titlesize": 9,
}
LAB = Path(__file__).parent
ROOMS = ("evaluation", "evaluation/integrity", "model_fits", "calibrate", "mapping")
FOLDERS = [LAB / room for room in ROOMS]
"""Folders that hold templates."""
NOTHING = 1e-6
"""A smaller value, in millimetres or milliradians, is a rounding error."""


class LineStyle(NamedTuple):
    """How a trajectory is drawn: its colour or its dashes alone are enough to recognize it."""

    label: str
    colour: str
    dashes: str
    width: float


STROKES = {
    "truth": LineStyle("truth", "#000000", "-", 2.6),
    "odometry": LineStyle("odometry", "#d55e00", "--", 1.2),
    "amcl": LineStyle("AMCL", "#56b4e9", "-", 1.1),
}
"""Colours of Okabe and Ito, which colour-blind people can distinguish."""


@contextmanager
def svg_figure(width: float, height: float, svgs: list[str]) -> Iterator[Figure]:
    """Give a figure [inch] to draw on; its SVG is appended to ``svgs`` at the end."""
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(width, height), layout="constrained")
        yield figure
        text = io.StringIO()
        figure.savefig(text, format="svg", metadata={"Date": None})
    svgs.append(text.getvalue())


def page(template: str, **values: Any) -> str:
    """Render the page of a template."""
    environment = Environment(
        loader=FileSystemLoader(FOLDERS),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters |= {"mm": millimetres, "mrad": milliradians, "s": seconds, "share": share}
    return environment.get_template(template).render(**values)


def embedded(svg: str) -> str:
    """Return an SVG as a data URL, so that its ids do not collide with those of another SVG."""
    return "data:image/svg+xml;base64," + base64.b64encode(svg.encode()).decode()


def millimetres(value: float | None) -> str:
    """Format a length [m] in millimetres, with three digits."""
    return "-" if value is None else f"{_digits(1e3 * value)} mm"


def milliradians(value: float | None) -> str:
    """Format an angle [rad] in milliradians, with three digits."""
    return "-" if value is None else f"{_digits(1e3 * value)} mrad"


def seconds(value: float | None) -> str:
    """Format a time [s] with two decimals."""
    return "-" if value is None else f"{value:.2f} s"


def share(value: float) -> str:
    """Format a share (0 to 1) as a percentage."""
    return f"{100 * value:.0f} %"


def _digits(value: float) -> str:
    if abs(value) < NOTHING or not math.isfinite(value):
        return f"{value:.0f}"
    return f"{value:.{max(2 - math.floor(math.log10(abs(value))), 0)}f}"
