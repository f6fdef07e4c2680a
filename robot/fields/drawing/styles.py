"""The values of an element's properties: parsed when they are asked for, and inherited.

What nobody asks for is never refused: a foreign word on something that is not drawn does no harm.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from robot.fields.drawing.style_sheets import ATTRIBUTE_ONLY, Declared
from robot.fields.drawing.svg_values import (
    CURRENT,
    IDENTITY,
    Ink,
    Length,
    SvgError,
    colour,
    css_transform,
    length,
    lengths,
    number_or_percentage,
    shown,
    transform,
)

MAX_EXPANDED = 1000
"""Longest value with ``var()`` [characters]."""
NOTHING = Ink(0.0, 0.0)
BLACK = Ink(0.0, 1.0)
_URL = re.compile(r"""url\(\s*["']?\s*#([^"')]*?)\s*["']?\s*\)\s*(.*)""", re.S | re.I)
_NONE = "none"
_LENGTHS = "a number, or one in px, pt, mm, cm, in or %"
_PAINTS = "none, #rrggbb, rgb(r, g, b) or a name"
_TRANSFORMS = (
    "up to 100 of matrix(a b c d e f), translate(x y), scale(x y), rotate(degrees), skewX(degrees)"
)
_CSS_TRANSFORMS = "up to 100 of translate(1px, 2px), rotate(3deg), scale(1, 2)"
_VARIABLE = re.compile(r"var\(\s*(--[^\s,()]+)\s*(?:,([^()]*))?\)")


@dataclass(frozen=True, slots=True)
class Reference:
    """A paint, a clip ... that is an element of the drawing."""

    id: str
    fallback: str = ""


@dataclass(frozen=True, slots=True)
class Property:
    """A property of SVG."""

    read: Callable[[str], Any]
    """Returns the value of a text; None if the text is not valid."""
    initial: Any
    valid: str
    """For error messages."""
    inherited: bool = True


def _words(*valid: str, initial: str = "", inherited: bool = True) -> Property:
    """Return a property of a few words."""
    return Property(
        lambda text: text.lower() if text.lower() in valid else None,
        initial or valid[0],
        ", ".join(valid),
        inherited,
    )


def _reference(text: str) -> Reference | None:
    match = _URL.fullmatch(text)
    return Reference(match[1], match[2].strip()) if match else None


def _none_or_reference(text: str) -> Reference | str | None:
    return "none" if text.lower() == "none" else _reference(text)


def _paint(text: str) -> Ink | Reference | str | None:
    return NOTHING if text.lower() == "none" else _reference(text) or colour(text)


def _opacity(text: str) -> float | None:
    value = number_or_percentage(text)
    return None if value is None else min(max(value, 0.0), 1.0)


def _not_negative(text: str) -> Length | None:
    value = length(text)
    return value if value is not None and value.value >= 0 else None


def _dashes(text: str) -> tuple[Length, ...] | None:
    if text.lower() == "none":
        return ()
    value = lengths(text)
    return tuple(value) if value and min(dash.value for dash in value) >= 0 else None


def _miter_limit(text: str) -> float | None:
    value = number_or_percentage(text)
    return value if value is not None and value >= 1 and "%" not in text else None


def _join(text: str) -> str | None:
    words = {"round": "round", "bevel": "bevel", "miter": "miter", "miter-clip": "miter",
             "arcs": "miter"}  # fmt: skip
    return words.get(text.lower())


def _stroke_first(text: str) -> bool | None:
    words = text.lower().split()
    if words == ["normal"]:
        return False
    order = [word for word in words if word != "markers"]
    return order[:1] == ["stroke"] if set(words) <= {"fill", "stroke", "markers"} else None


def _dimension(text: str) -> Length | str | None:
    return "auto" if text.lower() == "auto" else length(text)


def _data(text: str) -> str:
    match = re.fullmatch(r"""path\(\s*["'](.*)["']\s*\)""", text, re.S)
    return match[1] if match else text if text.lower() != "none" else ""


PROPERTIES: dict[str, Property] = {
    "clip-path": Property(_none_or_reference, "none", "none or url(#id)", inherited=False),
    "clip-rule": _words("nonzero", "evenodd"),
    "color": Property(colour, BLACK, _PAINTS),
    "display": Property(str.lower, "inline", "none or inline", inherited=False),
    "fill": Property(_paint, BLACK, _PAINTS),
    "fill-opacity": Property(_opacity, 1.0, "a number from 0 to 1"),
    "fill-rule": _words("nonzero", "evenodd"),
    "filter": Property(_none_or_reference, "none", _NONE, inherited=False),
    "marker-end": Property(_none_or_reference, "none", _NONE),
    "marker-mid": Property(_none_or_reference, "none", _NONE),
    "marker-start": Property(_none_or_reference, "none", _NONE),
    "mask": Property(_none_or_reference, "none", _NONE, inherited=False),
    "mix-blend-mode": _words("normal", inherited=False),
    "offset-path": _words("none", inherited=False),
    "opacity": Property(_opacity, 1.0, "a number from 0 to 1", inherited=False),
    "overflow": _words("visible", "auto", "hidden", "scroll", "clip", initial="-", inherited=False),
    "paint-order": Property(_stroke_first, False, "normal, fill, stroke"),
    "rotate": _words("none", "auto", "0", inherited=False),
    "scale": _words("none", inherited=False),
    "stop-color": Property(colour, BLACK, _PAINTS, inherited=False),
    "stop-opacity": Property(_opacity, 1.0, "a number from 0 to 1", inherited=False),
    "stroke": Property(_paint, NOTHING, _PAINTS),
    "stroke-dasharray": Property(_dashes, (), "none or lengths from 0"),
    "stroke-dashoffset": Property(length, Length(0.0, ""), _LENGTHS),
    "stroke-linecap": _words("butt", "round", "square"),
    "stroke-linejoin": Property(_join, "miter", "miter, round or bevel"),
    "stroke-miterlimit": Property(_miter_limit, 4.0, "a number from 1"),
    "stroke-opacity": Property(_opacity, 1.0, "a number from 0 to 1"),
    "stroke-width": Property(_not_negative, Length(1.0, ""), f"{_LENGTHS}, as wide as the tape"),
    "transform": Property(css_transform, IDENTITY, _CSS_TRANSFORMS, inherited=False),
    ATTRIBUTE_ONLY["transform"]: Property(transform, IDENTITY, _TRANSFORMS, inherited=False),
    "transform-box": _words("view-box", "fill-box", inherited=False),
    "transform-origin": Property(str.lower, "", "x and y", inherited=False),
    "translate": _words("none", inherited=False),
    "vector-effect": _words("none", "non-scaling-stroke", inherited=False),
    "visibility": _words("visible", "hidden", "collapse"),
    "zoom": _words("1", "normal", "100%", inherited=False),
    "d": Property(_data, "", "a path", inherited=False),
    **{
        name: Property(_dimension, Length(0.0, ""), _LENGTHS, inherited=False)
        for name in ("x", "y", "width", "height", "cx", "cy", "r", "rx", "ry")
    },
}

ATTRIBUTES = frozenset(PROPERTIES) - {
    "mix-blend-mode", "offset-path", "rotate", "scale", "transform-box", "translate", "zoom",
}  # fmt: skip
"""Properties that can be given as attributes, too."""


class Style:
    """The properties of one element, wherever it is drawn."""

    def __init__(self, declared: Declared, parent: Style | None = None) -> None:
        self._declared = declared
        self._parent = parent
        self._values: dict[str, Any] = {}

    def __getitem__(self, name: str) -> Any:
        """Return the value of a property.

        Raises:
            SvgError: no declaration of it is valid.
        """
        if name not in self._values:
            self._values[name] = self._value(name)
        return self._values[name]

    def has(self, name: str) -> bool:
        """Return whether a property is declared on the element itself."""
        return name in self._declared

    def raw(self, name: str) -> str:
        """Return the strongest text that is declared for a name on the element itself, or ""."""
        return self._expanded(self._declared.get(name, [""])[-1])

    def colour(self, name: str) -> Ink:
        """Return a property's colour; the word ``currentColor`` is that of ``color``."""
        value = self[name]
        if value != CURRENT:
            return value  # type: ignore[no-any-return]
        if name == "color":
            return self._parent.colour("color") if self._parent else BLACK
        return self.colour("color")

    def _value(self, name: str) -> Any:
        known = PROPERTIES[name]
        texts = self._declared.get(name, ())
        for text in reversed(texts):
            word = text.lower()
            if word in ("inherit", "initial", "unset", "revert", "revert-layer"):
                take = word == "inherit" or (known.inherited and word != "initial")
                return self._inherited(name) if take else known.initial
            value = known.read(self._expanded(text))
            if value is not None:
                return value
        if texts:
            written = name.removesuffix(" attribute")
            raise SvgError(f"{written} is {shown(texts[-1])}; valid are {known.valid}")
        return self._inherited(name) if known.inherited else known.initial

    def _inherited(self, name: str) -> Any:
        return self._parent[name] if self._parent is not None else PROPERTIES[name].initial

    def _expanded(self, text: str) -> str:
        """Return a value with its ``var(--name, fallback)`` replaced."""
        for _ in range(8):
            if "var(" not in text or len(text) > MAX_EXPANDED:
                break
            text = _VARIABLE.sub(self._variable, text)
        return text

    def _variable(self, match: re.Match[str]) -> str:
        style: Style | None = self
        while style is not None:
            if match[1] in style._declared:
                return style._declared[match[1]][-1]
            style = style._parent
        return (match[2] or "").strip()
