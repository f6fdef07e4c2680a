"""Reads a file that should be an SVG drawing, but may be anything.

Nothing is drawn here. The document is checked and cut down to what can be drawn, and its size is
computed. So the reader of the shapes gets a small and harmless document.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import NoReturn
from xml.etree import ElementTree
from xml.parsers import expat

from robot.errors import BrickPoseError

MAX_BYTES = 2 << 20
MAX_ELEMENTS = 10_000
MAX_DEPTH = 64
MAX_STYLE = 16 << 10
SIZE_MM = (10.0, 100_000.0)
"""Smallest and largest side of a drawing [mm]."""

_SVG = "http://www.w3.org/2000/svg"
_SHAPES = ("path", "rect", "circle", "ellipse", "line", "polyline", "polygon")
_DRAWN = ("svg", "g", "defs", "use", "style", "title", "desc", *_SHAPES)
_NUMBER = r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?"
_MM = {"": 1.0, "mm": 1.0, "cm": 10.0, "in": 25.4}


class SvgError(BrickPoseError, ValueError):
    """A drawing that cannot be used; the message says what is valid."""


@dataclass(frozen=True, slots=True)
class SvgFile:
    """A checked drawing."""

    content: bytes = field(repr=False)
    """The document; its width and height are in millimetres, without a unit."""
    width: float
    """[mm]"""
    height: float
    """[mm]"""
    start: str
    """Text of ``data-start``; empty if there is none."""


def read_svg(path: Path) -> SvgFile:
    """Read and check a drawing.

    Raises:
        SvgError: there is no such file, or it is not a usable drawing.
    """
    return check_svg(_read(path))


def check_svg(data: bytes) -> SvgFile:
    """Check a drawing that is already in memory.

    Raises:
        SvgError: the data is not a usable drawing.
    """
    root = _parse(data)
    if _local_name(root) != "svg":
        raise SvgError(f"the document is a {shown(root.tag)}; valid is an svg")
    _remove_foreign(root)
    _check_elements(root)
    width, height = _size(root)
    for name in ("x", "y"):
        root.attrib.pop(name, None)
    root.attrib.update(width=repr(width), height=repr(height))
    content = ElementTree.tostring(root, encoding="utf-8")
    return SvgFile(content, width, height, root.attrib.get("data-start", ""))


def numbers(text: str) -> list[float] | None:
    """Return numbers separated by spaces or commas; None if the text holds anything else."""
    parts = re.split(r"[\s,]+", text.strip())
    values = [float(part) for part in parts if re.fullmatch(_NUMBER, part)]
    return values if len(values) == len(parts) and all(map(math.isfinite, values)) else None


def shown(text: str) -> str:
    """Return a text of the drawing for error messages: quoted, on one line and not too long."""
    return repr(text if len(text) <= 40 else f"{text[:40]}...")


def _read(path: Path) -> bytes:
    try:
        if not path.is_file():
            raise SvgError("there is no such file")
        if path.stat().st_size > MAX_BYTES:
            raise SvgError(f"the file has {path.stat().st_size} bytes; valid are {MAX_BYTES}")
        return path.read_bytes()
    except OSError as error:
        raise SvgError(f"the file cannot be read: {error.strerror}") from error


def _parse(data: bytes) -> ElementTree.Element:
    try:
        _refuse_declarations(data)
        return ElementTree.fromstring(data)
    except (expat.ExpatError, ElementTree.ParseError, LookupError) as error:
        raise SvgError(f"the file is not well-formed XML: {error}") from error
    except SvgError:
        raise
    except ValueError as error:  # an encoding that the parser does not know
        raise SvgError(f"the file is not well-formed XML: {error}") from error


def _refuse_declarations(data: bytes) -> None:
    """Refuse a document with its own DTD: its entities can grow a few bytes into gigabytes."""
    parser = expat.ParserCreate()

    def on_doctype(_name: str, _system: object, _public: object, own: bool) -> None:
        if own:
            refuse()

    def refuse(*_: object) -> NoReturn:
        raise SvgError("the file declares XML entities or a DTD; valid is a plain SVG")

    parser.StartDoctypeDeclHandler = on_doctype
    parser.EntityDeclHandler = refuse
    parser.Parse(data, True)


def _local_name(element: ElementTree.Element) -> str:
    """Return the tag without SVG's namespace, which may be missing; a foreign one stays."""
    return element.tag.removeprefix(f"{{{_SVG}}}")


def _remove_foreign(root: ElementTree.Element) -> None:
    """Remove what editors store for themselves: other namespaces, and metadata."""
    for parent in list(root.iter()):
        for child in list(parent):
            name = _local_name(child)
            if "{" in name or name == "metadata":
                parent.remove(child)


def _check_elements(root: ElementTree.Element) -> None:
    style = sum(len(e.text or "") for e in root.iter() if _local_name(e) == "style")
    if style > MAX_STYLE:
        raise SvgError(f"the style sheet has {style} characters; valid are {MAX_STYLE}")
    by_id = {e.attrib["id"]: e for e in root.iter() if "id" in e.attrib}
    for count, (element, drawn) in enumerate(_walk(root, by_id)):
        if count >= MAX_ELEMENTS:
            raise SvgError(f"more than {MAX_ELEMENTS} elements, counting each use; use fewer")
        name = _local_name(element)
        if drawn and (name not in _DRAWN or (name == "svg" and element is not root)):
            cure = " (turn it into a path)" if name in ("text", "tspan") else ""
            valid = ", ".join(_DRAWN[1:])
            raise SvgError(f"the element {shown(name)} is not understood{cure}; valid are {valid}")


def _walk(
    element: ElementTree.Element,
    by_id: dict[str, ElementTree.Element],
    drawn: bool = True,
    depth: int = 0,
) -> Iterator[tuple[ElementTree.Element, bool]]:
    """Yield all elements in drawing order, each use again, and whether they are drawn."""
    if depth > MAX_DEPTH:
        raise SvgError(f"elements nested (or using each other) deeper than {MAX_DEPTH}")
    yield element, drawn
    inside = drawn and _local_name(element) != "defs"
    for child in element:
        yield from _walk(child, by_id, inside, depth + 1)
    if _local_name(element) == "use":
        link = element.get("href", element.get("{http://www.w3.org/1999/xlink}href", ""))
        if link[1:] not in by_id or not link.startswith("#"):
            raise SvgError(
                f"<use> of {shown(link)}; valid is # and the id of an element in the drawing"
            )
        yield from _walk(by_id[link[1:]], by_id, drawn, depth + 1)


def _size(root: ElementTree.Element) -> tuple[float, float]:
    """Return width and height [mm]; a missing one follows from the viewBox."""
    width, height = _length(root, "width"), _length(root, "height")
    box = _view_box(root)
    if box is not None:
        if width is None and height is None:
            width, height = box
        width = box[0] * height / box[1] if width is None and height is not None else width
        height = box[1] * width / box[0] if height is None and width is not None else height
    if width is None or height is None:
        raise SvgError("the drawing has no size; give width and height in mm, or a viewBox")
    if not all(SIZE_MM[0] <= side <= SIZE_MM[1] for side in (width, height)):
        low, high = SIZE_MM
        raise SvgError(f"the drawing is {width:g} x {height:g} mm; valid is {low:g} to {high:g}")
    return width, height


def _length(root: ElementTree.Element, name: str) -> float | None:
    text = root.attrib.get(name, "auto").strip()
    if text in ("auto", "100%"):
        return None
    match = re.fullmatch(rf"({_NUMBER})\s*({'|'.join(_MM)})", text)
    if match is None:
        raise SvgError(
            f"{name} is {shown(text)}; valid is a number in mm, cm, in or without unit (mm)"
        )
    return float(match[1]) * _MM[match[2]]


def _view_box(root: ElementTree.Element) -> tuple[float, float] | None:
    text = root.attrib.get("viewBox")
    if text is None:
        return None
    box = numbers(text)
    if box is None or len(box) != 4 or min(box[2:]) < 1e-3 or max(map(abs, box)) > 1e7:
        raise SvgError(f"viewBox is {shown(text)}; valid are x, y and a positive width and height")
    return box[2], box[3]
