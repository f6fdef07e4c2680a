"""The size of a drawing, and how long its units are.

A size in px, pt, pc, mm, cm or in is what the standard says: with a viewBox, that is scaled to it;
without, a unit is 1/96 inch. A size without any unit is in millimetres, by this program's own rule.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from robot.fields.drawing.selectors import Element
from robot.fields.drawing.style_sheets import ATTRIBUTE_ONLY
from robot.fields.drawing.styles import Style
from robot.fields.drawing.svg_values import (
    INCH_MM,
    PIXELS_PER_INCH,
    Length,
    SvgError,
    compose,
    length,
    numbers,
    shown,
)
from robot.geometry import Array

_SIDES = {"left": "0%", "right": "100%", "top": "0%", "bottom": "100%", "center": "50%"}

SIZE_MM = (10.0, 100_000.0)
"""Smallest and largest side of a drawing [mm]."""
_ALIGNED = {"min": 0.0, "mid": 0.5, "max": 1.0}


@dataclass(frozen=True, slots=True, eq=False)
class Viewport:
    """What the lengths of an element are measured in."""

    matrix: Array
    """(2, 3) from its units to the page [mm]: from the top left, y down."""
    width: float
    """[units]"""
    height: float
    """[units]"""
    per_inch: float
    """How many units without a name are an inch."""

    def units(self, name: str, written: Length) -> float:
        """Return a length in units; a percentage is of what the name of the length is along."""
        if name in ("x", "width", "cx", "rx", "x1", "x2"):
            return written.units(self.width, self.per_inch)
        if name in ("y", "height", "cy", "ry", "y1", "y2"):
            return written.units(self.height, self.per_inch)
        diagonal = math.hypot(self.width, self.height) / math.sqrt(2)
        return written.units(diagonal, self.per_inch)

    def dimension(self, style: Style, name: str) -> float | None:
        """Return a length of an element's geometry; None if it is automatic or not given."""
        written: Length | str | None = style[name] if style.has(name) else None
        if written is None or isinstance(written, str):
            return None
        return self.units(name, written)

    def transformed(self, style: Style) -> Viewport:
        """Return the same for an element with a transform of its own."""
        written = [name for name in ("transform", ATTRIBUTE_ONLY["transform"]) if style.has(name)]
        if not written:
            return self
        matrix: Array = style[written[0]]
        if style["transform-origin"]:
            x, y = self._transform_origin(style)
            moved = [np.array([[1.0, 0.0, sign * x], [0.0, 1.0, sign * y]]) for sign in (1, -1)]
            matrix = compose(moved[0], compose(matrix, moved[1]))
        return self.within(matrix)

    def _transform_origin(self, style: Style) -> tuple[float, float]:
        text = style["transform-origin"]
        if style["transform-box"] != "view-box":
            raise SvgError("transform-box is 'fill-box'; valid is view-box, with x and y")
        words = [_SIDES.get(word, word) for word in text.split()[:2]]
        if text.split()[0] in ("top", "bottom") or text.split()[1:2] in (["left"], ["right"]):
            words = [*words[1:], "50%", words[0]][-2 if len(words) == 1 else 0 :][:2]
        places = [length(word) for word in [*words, "50%"][:2]]
        x, y = places
        if x is None or y is None:
            raise SvgError(f"transform-origin is {shown(text)}; valid are x and y")
        return self.units("x", x), self.units("y", y)

    def within(self, inner: Array) -> Viewport:
        """Return the same for an element that is moved by an affine transform."""
        return replace(self, matrix=compose(self.matrix, inner))


@dataclass(frozen=True, slots=True, eq=False)
class PageSize:
    """The size of a drawing."""

    width: float
    """[mm]"""
    height: float
    """[mm]"""
    box: tuple[float, float]
    """Width and height of its viewBox, or its size in pixels where there is none."""
    has_box: bool
    has_unit: bool
    """Whether its size has a unit."""
    pixel: float
    """Length of the pixel that other lengths are counted in [mm]."""
    viewport: Viewport


def page_size(root: Element, style: Style) -> PageSize:
    """Return the size of a drawing.

    Raises:
        SvgError: it has none, or an absurd one.
    """
    written = [_length(style, name) for name in ("width", "height")]
    has_unit = any(side is not None and side.unit for side in written)
    pixel = INCH_MM / PIXELS_PER_INCH if has_unit else 1.0
    sides = [None if side is None else side.units(0) * pixel for side in written]
    box = view_box(root)
    width, height = _sides(sides[0], sides[1], (box or (0, 0, 0, 0))[2:])
    if width is None or height is None:
        raise SvgError("the drawing has no size; give width and height in mm, or a viewBox")
    if not all(SIZE_MM[0] <= side <= SIZE_MM[1] for side in (width, height)):
        low, high = SIZE_MM
        raise SvgError(f"the drawing is {width:g} x {height:g} mm; valid is {low:g} to {high:g}")
    units = box if box is not None else (0.0, 0.0, width / pixel, height / pixel)
    matrix = fitted(units, (width, height), root.get("preserveAspectRatio", ""))
    return PageSize(
        width, height, units[2:], box is not None, has_unit, pixel,
        Viewport(matrix, *units[2:], INCH_MM / pixel),
    )  # fmt: skip


def _length(style: Style, name: str) -> Length | None:
    """Return a side as it is written; None if it follows from the viewBox."""
    written: Length | str | None = style[name] if style.has(name) else None
    if written is None or isinstance(written, str) or written.unit == "%":
        return None
    return written


def _sides(
    width: float | None, height: float | None, box: tuple[float, ...]
) -> tuple[float | None, float | None]:
    """Return width and height [mm]; a missing one follows from the viewBox."""
    if any(box):
        if width is None and height is None:
            return box[0], box[1]
        width = box[0] * height / box[1] if width is None and height is not None else width
        height = box[1] * width / box[0] if height is None and width is not None else height
    return width, height


def view_box(element: Element) -> tuple[float, float, float, float] | None:
    """Return an element's viewBox: x, y, width, height; None if it has none.

    Raises:
        SvgError: it is absurd.
    """
    text = element.get("viewBox")
    if text is None:
        return None
    box = numbers(text)
    if box is None or len(box) != 4 or min(box[2:]) < 1e-3 or max(map(abs, box)) > 1e7:
        raise SvgError(f"viewBox is {shown(text)}; valid are x, y and a positive width and height")
    return box[0], box[1], box[2], box[3]


def fitted(box: tuple[float, float, float, float], size: tuple[float, float], aspect: str) -> Array:
    """Return the transform (2, 3) that fits a viewBox into a size, by ``preserveAspectRatio``."""
    words = [word for word in aspect.split() if word != "defer"]
    x_scale, y_scale = size[0] / box[2], size[1] / box[3]
    along_x, along_y = 0.5, 0.5
    if words[:1] == ["none"]:
        return np.array([[x_scale, 0, -box[0] * x_scale], [0, y_scale, -box[1] * y_scale]])
    if words and len(words[0]) == 8:
        along_x = _ALIGNED.get(words[0][1:4].lower(), 0.5)
        along_y = _ALIGNED.get(words[0][5:].lower(), 0.5)
    scale = max(x_scale, y_scale) if "slice" in words[1:] else min(x_scale, y_scale)
    x = (size[0] - box[2] * scale) * along_x - box[0] * scale
    y = (size[1] - box[3] * scale) * along_y - box[1] * scale
    return np.array([[scale, 0, x], [0, scale, y]])
