"""Reports: figures for print and colour-blind people, and one page that opens anywhere.

A report's template extends ``report_page.html.jinja``, which has the page around it and what it was
made with, and writes its tables and figures by the macros of ``report_parts.html.jinja``.
"""

from __future__ import annotations

import base64
import io
import math
from collections.abc import Callable
from functools import wraps
from pathlib import Path
from typing import Any, Concatenate, NamedTuple, ParamSpec

import matplotlib as mpl
from jinja2 import Environment, FileSystemLoader, StrictUndefined
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from robot.camera import Lens
from robot.geometry import Array

STYLE: Any = {
    "font.size": 9,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "svg.hashsalt": "brickpose",  # equal figures give equal files
    "svg.fonttype": "none",
    "axes.titlesize": 9,
}
LAB = Path(__file__).parent
ROOMS = (
    "", "evaluation", "evaluation/integrity", "evaluation/navigation", "model_fits", "calibrate",
    "mapping",
)  # fmt: skip
"""Folders that hold templates."""
NOTHING = 1e-6
"""A smaller value, in millimetres or milliradians, is a rounding error."""
OKABE_ITO = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#000000")
"""Colours that colour-blind people can distinguish."""
BLUE, RED, GREEN, PURPLE, ORANGE, SKY, BLACK = OKABE_ITO
GREY = "#999999"
Given = ParamSpec("Given")


class LineStyle(NamedTuple):
    """How a trajectory is drawn: its colour or its dashes alone are enough to recognize it."""

    label: str
    colour: str
    dashes: str
    width: float

    def draw(self, axes: Axes, way: Array) -> None:
        """Draw a path (n, 2 or more) [m] from above."""
        x, y = way[:, :2].T
        axes.plot(x, y, self.dashes, color=self.colour, lw=self.width, label=self.label)


STROKES = {
    "truth": LineStyle("truth", BLACK, "-", 2.6),
    "odometry": LineStyle("odometry", RED, "--", 1.2),
    "amcl": LineStyle("AMCL", SKY, "-", 1.1),
}


def svg_figure(
    width: float = 6.4, height: float = 4.8
) -> Callable[[Callable[Concatenate[Figure, Given], None]], Callable[Given, str]]:
    """Decorate a function that draws on a figure of a size [inch]: it then returns an SVG.

    It may set another size.
    """

    def decorated(draw: Callable[Concatenate[Figure, Given], None]) -> Callable[Given, str]:
        @wraps(draw)
        def drawn(*args: Given.args, **kwargs: Given.kwargs) -> str:
            with mpl.rc_context(STYLE):
                figure = Figure(figsize=(width, height), layout="constrained")
                draw(figure, *args, **kwargs)
                text = io.StringIO()
                figure.savefig(text, format="svg", metadata={"Date": None})
            return text.getvalue()

        return drawn

    return decorated


def picture_frame(figure: Figure, lens: Lens) -> Axes:
    """Return axes over a camera's picture."""
    axes = figure.add_subplot()
    axes.set(xlim=(0, lens.width), ylim=(lens.height, 0), aspect="equal", xlabel="px")
    axes.spines[["top", "right"]].set_visible(True)
    return axes


def page(template: str, **values: Any) -> str:
    """Render the page of a template; figures are given as SVG."""
    environment = Environment(
        loader=FileSystemLoader([LAB / room for room in ROOMS]),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters |= {"mm": millimetres, "mrad": milliradians, "s": seconds, "share": share}
    environment.filters["embedded"] = _embedded
    return environment.get_template(template).render(**values)


def _embedded(svg: str) -> str:
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
