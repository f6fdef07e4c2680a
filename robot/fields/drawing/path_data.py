"""Reads the data of a path: SVG 2, chapter 9.3. One scan, so the time is linear in the length."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from typing import NoReturn

import numpy as np

from robot.fields.drawing.svg_values import NUMBER, SvgError, shown
from robot.geometry import Array

FARTHEST = 1e9
"""In units of the drawing; larger coordinates are a mistake."""

Curve = Callable[[Array], Array]
"""Points (n, 2) for parameters (n,) from 0 to 1."""
_COMMAND = re.compile(r"[\s,]*([MmZzLlHhVvCcSsQqTtAa])")
_VALUE = re.compile(rf"[\s,]*({NUMBER})")
_FLAG = re.compile(r"[\s,]*([01])")
_COUNTS = {"m": 2, "l": 2, "h": 1, "v": 1, "c": 6, "s": 4, "q": 4, "t": 2, "a": 7, "z": 0}


@dataclass(eq=False, frozen=True, slots=True)
class Segment:
    """A part of a path between two points."""

    start: complex
    end: complex
    curve: Curve | None = None
    """None of a straight line."""


@dataclass(slots=True)
class Subpath:
    """What is drawn without lifting the pen."""

    start: complex
    segments: list[Segment] = field(default_factory=list)
    closed: bool = False

    @property
    def end(self) -> complex:
        """Where the pen is."""
        return self.segments[-1].end if self.segments else self.start

    def line_to(self, end: complex) -> None:
        """Draw a straight line."""
        self.segments.append(Segment(self.end, end))

    def curve_to(self, *controls: complex) -> None:
        """Draw a Bezier curve by its control points, the last of which is its end."""
        self.segments.append(Segment(self.end, controls[-1], bezier(self.end, *controls)))


def bezier(*controls: complex) -> Curve:
    """Return the Bezier curve of 3 or 4 control points."""
    points = _points(*controls)
    degree = len(controls) - 1
    binomial = np.array([math.comb(degree, k) for k in range(degree + 1)], dtype=np.float64)
    power = np.arange(degree + 1)

    def curve(t: Array) -> Array:
        weights = binomial * t[:, None] ** power * (1 - t[:, None]) ** (degree - power)
        places: Array = weights @ points
        return places

    return curve


def ellipse_arc(centre: complex, radii: complex, turn: float, first: float, sweep: float) -> Curve:
    """Return an arc of an ellipse that is turned [rad], from an angle through another [rad]."""
    middle = _points(centre)
    axes = _points(radii.real * np.exp(1j * turn), 1j * radii.imag * np.exp(1j * turn))

    def curve(t: Array) -> Array:
        angle = first + sweep * t
        places: Array = np.column_stack([np.cos(angle), np.sin(angle)]) @ axes + middle
        return places

    return curve


def _points(*places: complex) -> Array:
    return np.array([(place.real, place.imag) for place in places], dtype=np.float64)


def arc_to(
    path: Subpath, radii: complex, degrees: float, flags: tuple[bool, bool], end: complex
) -> None:
    """Draw an elliptical arc as SVG's command A asks for it: appendix B.2 of SVG 2.

    The flags are large-arc and sweep.
    """
    start, (large, sweep) = path.end, flags
    rx, ry = abs(radii.real), abs(radii.imag)
    if start == end:
        return
    if not min(rx, ry) > 0:
        path.line_to(end)
        return
    turn = math.radians(degrees % 360)
    around = complex(math.cos(turn), math.sin(turn))
    half = (start - end) / 2 * around.conjugate()
    x, y = half.real / rx, half.imag / ry
    square = x * x + y * y
    if not square > 0:  # the ends are too close to each other to be told apart
        path.line_to(end)
        return
    if square > 1:  # radii that are too small are enlarged
        rx, ry = rx * math.sqrt(square), ry * math.sqrt(square)
        x, y, square = x / math.sqrt(square), y / math.sqrt(square), 1.0
    away = math.sqrt(max(0.0, 1 / square - 1)) * (1 if large != sweep else -1)
    off_x, off_y = away * y, -away * x
    centre = complex(off_x * rx, off_y * ry) * around + (start + end) / 2
    first = math.atan2(y - off_y, x - off_x)
    last = math.atan2(-y - off_y, -x - off_x)
    angle = (last - first) % (2 * math.pi)
    if not sweep:
        angle -= 2 * math.pi
    curve = ellipse_arc(centre, complex(rx, ry), turn, first, angle)
    path.segments.append(Segment(start, end, curve))


class PathReader:
    """Reads the data of one path."""

    def __init__(self, text: str) -> None:
        self._text = text.rstrip()
        self._place = 0
        self._path: Subpath | None = None
        self._before: tuple[str, complex] = ("", 0j)
        """The last command, and the control point that a smooth curve mirrors."""

    def subpaths(self) -> Iterator[Subpath]:
        """Yield all parts that are drawn without lifting the pen.

        Raises:
            SvgError: it is no path; the message shows where.
        """
        while self._place < len(self._text):
            match = _COMMAND.match(self._text, self._place)
            if match is None or (self._path is None and match[1] not in "Mm"):
                self._refuse()
            self._place = match.end()
            letter = match[1]
            while True:
                yield from self._apply(letter)
                if letter in "Zz" or _VALUE.match(self._text, self._place) is None:
                    break
                letter = {"M": "L", "m": "l"}.get(letter, letter)
        if self._path is not None:
            yield self._path

    def _apply(self, letter: str) -> Iterator[Subpath]:
        kind = letter.lower()
        values = [self._value(kind == "a" and index in (3, 4)) for index in range(_COUNTS[kind])]
        pen = self._path.end if self._path is not None else 0j
        if kind == "m":
            if self._path is not None:
                yield self._path
            self._path = Subpath(complex(*values) + (pen if letter == "m" else 0))
        elif self._path is not None and kind == "z":
            self._path.closed = True
            yield self._path
            self._path = Subpath(self._path.start)
        elif self._path is not None:
            self._draw(self._path, kind, values, pen if letter.islower() else 0j)
        if kind not in "csqt":
            self._before = (kind, 0j)

    def _draw(self, path: Subpath, kind: str, values: list[float], origin: complex) -> None:
        if kind == "h":
            path.line_to(complex(values[0] + origin.real, path.end.imag))
        elif kind == "v":
            path.line_to(complex(path.end.real, values[0] + origin.imag))
        elif kind == "a":
            end = complex(*values[5:]) + origin
            flags = bool(values[3]), bool(values[4])
            arc_to(path, complex(*values[:2]), values[2], flags, end)
        else:
            pairs = zip(values[::2], values[1::2], strict=True)
            controls = [complex(x, y) + origin for x, y in pairs]
            if kind in "st":
                controls.insert(0, self._mirrored(path.end, "cs" if kind == "s" else "qt"))
            if kind == "l":
                path.line_to(controls[0])
            else:
                path.curve_to(*controls)
                self._before = (kind, controls[-2])

    def _mirrored(self, pen: complex, kinds: str) -> complex:
        kind, control = self._before
        return 2 * pen - control if kind and kind in kinds else pen

    def _value(self, flag: bool) -> float:
        match = (_FLAG if flag else _VALUE).match(self._text, self._place)
        if match is None:
            self._refuse()
        self._place = match.end()
        value = float(match[1])
        if not abs(value) <= FARTHEST:
            raise SvgError(f"a coordinate is too large or no number: {shown(match[1])}")
        return value

    def _refuse(self) -> NoReturn:
        rest = self._text[self._place :].strip()
        where = f"at {shown(rest)}" if rest else "at its end: a number is missing"
        raise SvgError(
            f"a path's d={shown(self._text)} cannot be read {where}; "
            "valid are commands like M 0 0 L 100 0, C, A, Z with their numbers"
        )
