"""Numbers, lengths, transforms and colours as SVG and CSS write them; all take linear time."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from tinycss2.color4 import parse_color

from robot.errors import BrickPoseError
from robot.geometry import Array

NUMBER = r"[+-]?(?:\d+(?:\.\d*)?|\.\d+)(?:[eE][+-]?\d+)?"
"""No text can be read by it in two ways: so it never takes more than linear time."""

INCH_MM = 25.4
PIXELS_PER_INCH = 96
"""The standard's: a unit of a drawing without a viewBox is 1/96 inch."""

INCHES = {
    "": 1 / 96, "px": 1 / 96, "pt": 1 / 72, "pc": 1 / 6, "in": 1.0,
    "mm": 1 / 25.4, "cm": 10 / 25.4, "q": 0.25 / 25.4,
}  # fmt: skip
"""Units of length [inch]."""

MAX_TRANSFORMS = 100

_LENGTH = re.compile(rf"({NUMBER})(%|[a-zA-Z]*)")
_FUNCTION = re.compile(r"[\s,]*([a-zA-Z]+)\s*\(([^()]*)\)")
_ANGLES = {"": 1.0, "deg": 1.0, "grad": 0.9, "rad": 180 / math.pi, "turn": 360.0}
"""Units of angles [degrees]."""

IDENTITY = np.array([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
IDENTITY.setflags(write=False)
_UNIT = re.compile(r"[0-9.][a-df-zA-DF-Z%]")
CURRENT = "currentcolor"


class SvgError(BrickPoseError, ValueError):
    """A drawing that cannot be used; the message says what is valid."""


@dataclass(frozen=True, slots=True)
class Length:
    """A length as it is written."""

    value: float
    unit: str
    """Lower case; empty if there is none."""

    def units(self, reference: float, per_inch: float = PIXELS_PER_INCH) -> float:
        """Return it in units of which an inch has so many; a percentage is of the reference."""
        if self.unit == "%":
            return self.value / 100 * reference
        return self.value * (1 if self.unit in ("", "px") else INCHES[self.unit] * per_inch)


def shown(text: str) -> str:
    """Return a text of the drawing for error messages: quoted, on one line and not too long."""
    return repr(text if len(text) <= 40 else f"{text[:40]}...")


def numbers(text: str) -> list[float] | None:
    """Return numbers separated by spaces or commas; None if the text holds anything else."""
    parts = re.split(r"[\s,]+", text.strip())
    values = [float(part) for part in parts if re.fullmatch(NUMBER, part)]
    return values if len(values) == len(parts) and all(map(math.isfinite, values)) else None


def number_or_percentage(text: str) -> float | None:
    """Return a number, a percentage as its share; None for anything else."""
    parsed = length(text)
    if parsed is None or parsed.unit not in ("", "%"):
        return None
    return parsed.value / 100 if parsed.unit == "%" else parsed.value


def length(text: str) -> Length | None:
    """Return a length in a unit that does not depend on a font; None for anything else."""
    match = _LENGTH.fullmatch(text.strip())
    if match is None:
        return None
    value, unit = float(match[1]), match[2].lower()
    return Length(value, unit) if math.isfinite(value) and unit in {*INCHES, "%"} else None


def lengths(text: str) -> list[Length] | None:
    """Return lengths separated by spaces or commas; None if the text holds anything else."""
    parsed = [length(part) for part in re.split(r"[\s,]+", text.strip())]
    whole = [part for part in parsed if part is not None]
    return whole if len(whole) == len(parsed) else None


def compose(outer: Array, inner: Array) -> Array:
    """Return the affine transform (2, 3) that applies the inner one first."""
    product: Array = outer[:, :2] @ inner
    product[:, 2] += outer[:, 2]
    return product


def css_transform(text: str) -> Array | None:
    """Return the transform (2, 3) of a style sheet; None if it is not valid there.

    Lengths and angles have units, and values have commas between them.
    """
    for match in _FUNCTION.finditer(text):
        values = [value.strip() for value in match[2].split(",")]
        bare = [value for value in values if re.fullmatch(NUMBER, value) and float(value) != 0]
        if bare and not match[1].startswith(("matrix", "scale")):
            return None
    return _transform(text)


def transform(text: str) -> Array | None:
    """Return the transform (2, 3) of an attribute; None if it is not valid there."""
    return None if _UNIT.search(text) else _transform(text)


@lru_cache(maxsize=1024)
def _transform(text: str) -> Array | None:
    """Return the affine transform (2, 3) of a list of functions; None if it is not valid."""
    if text.strip() in ("", "none"):
        return IDENTITY
    result, offset, count = IDENTITY, 0, 0
    text = text.rstrip()
    while offset < len(text):
        match = _FUNCTION.match(text, offset)
        single = _single(match[1], match[2]) if match else None
        count += 1
        if match is None or single is None or count > MAX_TRANSFORMS:
            return None
        result = compose(result, single)
        offset = match.end()
    result.setflags(write=False)
    return result


def _single(name: str, text: str) -> Array | None:
    """Return the matrix of one function."""
    parts = [_LENGTH.fullmatch(part) for part in re.split(r"[\s,]+", text.strip())]
    written = [(float(part[1]), part[2].lower()) for part in parts if part]
    if len(written) != len(parts) or not all(math.isfinite(value) for value, _ in written):
        return None
    try:
        if name in ("rotate", "skewX", "skewY", "skew"):
            return _turning(name, written)
        if name in ("matrix", "scale", "scaleX", "scaleY"):
            return _scaling(name, written)
        return _moving(name, written)
    except (KeyError, TypeError):  # a unit of another kind, or another number of values
        return None


def _moving(name: str, written: list[tuple[float, str]]) -> Array | None:
    steps = [value * INCHES[unit] * PIXELS_PER_INCH for value, unit in written]
    if name == "translate" and len(steps) in (1, 2):
        return _matrix(1, 0, 0, 1, steps[0], steps[1] if len(steps) == 2 else 0)
    if name == "translateX" and len(steps) == 1:
        return _matrix(1, 0, 0, 1, steps[0], 0)
    if name == "translateY" and len(steps) == 1:
        return _matrix(1, 0, 0, 1, 0, steps[0])
    return None


def _scaling(name: str, written: list[tuple[float, str]]) -> Array | None:
    values = [value * {"": 1.0, "%": 0.01}[unit] for value, unit in written]
    if name == "matrix":
        return _matrix(*values)
    if name == "scale" and len(values) in (1, 2):
        return _matrix(values[0], 0, 0, values[-1], 0, 0)
    if name == "scaleX" and len(values) == 1:
        return _matrix(values[0], 0, 0, 1, 0, 0)
    return _matrix(1, 0, 0, values[0], 0, 0) if name == "scaleY" and len(values) == 1 else None


def _turning(name: str, written: list[tuple[float, str]]) -> Array | None:
    angles = [
        math.radians(value * _ANGLES[unit]) for value, unit in written[: 1 + (name == "skew")]
    ]
    if name == "rotate" and len(written) in (1, 3):
        x, y = [value * {"": 1.0}[unit] for value, unit in written[1:]] or (0.0, 0.0)
        c, s = math.cos(angles[0]), math.sin(angles[0])
        return _matrix(c, s, -s, c, x - c * x + s * y, y - s * x - c * y)
    if name == "skewX" and len(written) == 1:
        return _matrix(1, 0, math.tan(angles[0]), 1, 0, 0)
    if name == "skewY" and len(written) == 1:
        return _matrix(1, math.tan(angles[0]), 0, 1, 0, 0)
    if name == "skew" and len(written) in (1, 2):
        second = math.tan(angles[1]) if len(angles) == 2 else 0.0
        return _matrix(1, second, math.tan(angles[0]), 1, 0, 0)
    return None


def _matrix(a: float, b: float, c: float, d: float, e: float, f: float) -> Array:
    return np.array([[a, c, e], [b, d, f]], dtype=np.float64)


@dataclass(frozen=True, slots=True)
class Ink:
    """Paint of a fill or a stroke."""

    grey: float
    """Brightness 0 to 255: 0.299 R + 0.587 G + 0.114 B, as OpenCV converts colours to grey."""
    alpha: float
    """Opacity, 0 to 1."""


@lru_cache(maxsize=1024)
def colour(text: str) -> Ink | str | None:
    """Return the paint of a colour of CSS, ``CURRENT`` for its word, and None for anything else."""
    try:
        parsed = parse_color(text)
        if parsed is None or isinstance(parsed, str):
            return parsed
        # The greys of wide gamuts are those of the usual one; other colours are a little duller.
        rgb = parsed if parsed.space in ("display-p3", "a98-rgb") else parsed.to("srgb")
    except Exception:  # it raises anything on a strange text
        return None
    red, green, blue = (float(np.clip(channel, 0, 1)) for channel in rgb.coordinates)
    # Rounded, for a colour is the same in each way in which it can be written.
    grey = round(255 * (0.299 * red + 0.587 * green + 0.114 * blue), 6)
    return Ink(grey, float(np.clip(rgb.alpha, 0, 1)))
