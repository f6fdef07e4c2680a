"""Which elements of a drawing a browser paints, and which of them are understood."""

from __future__ import annotations

from typing import NoReturn

from robot.fields.drawing import outlines
from robot.fields.drawing.selectors import Element
from robot.fields.drawing.styles import Style
from robot.fields.drawing.svg_document import link_of
from robot.fields.drawing.svg_values import SvgError, shown

UNDRAWN = (
    "clipPath", "color-profile", "cursor", "defs", "desc", "filter", "flowRoot", "font",
    "font-face", "hatch", "linearGradient", "marker", "mask", "mesh", "meshgradient", "metadata",
    "pattern", "radialGradient", "script", "solidColor", "solidcolor", "stop", "style", "symbol",
    "title", "view",
)  # fmt: skip
"""What browsers never draw where it stands, or do not know at all."""

_DRAWN = ("g", "svg", "a", "switch", "use", *outlines.SHAPES)
_CURES = {
    "image": "trace it, or hide it",
    "foreignObject": "turn what is in it into paths, or hide it",
}


_EXTENSIONS = {"http://www.w3.org/1999/xhtml", "http://www.w3.org/1998/Math/MathML"}


def is_meant(element: Element) -> bool:
    """Return whether an element's conditions hold: for a browser, in English."""
    extensions = element.get("requiredExtensions")
    if extensions is not None and not set(extensions.split()) & _EXTENSIONS:
        return False
    languages = element.get("systemLanguage")
    if languages is None:
        return True
    return any(language.strip().lower().split("-")[0] == "en" for language in languages.split(","))


def shows_nothing(element: Element, name: str, style: Style) -> bool:
    """Return whether a browser shows nothing of an element that is not understood."""
    if name == "image" and not link_of(element):
        return True
    return style["visibility"] != "visible" and not len(element)


def refuse(name: str) -> NoReturn:
    """Refuse an element that a browser would paint.

    Raises:
        SvgError: always.
    """
    cure = f" ({_CURES[name]})" if name in _CURES else ""
    valid = ", ".join(_DRAWN)
    raise SvgError(f"the element {shown(name)} is not understood{cure}; valid are {valid}")
