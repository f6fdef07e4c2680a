"""Reads a file that should be an SVG drawing, but may be anything, as a tree of harmless size."""

from __future__ import annotations

import re
from pathlib import Path
from typing import NoReturn
from xml.etree import ElementTree
from xml.parsers import expat

from robot.fields.drawing.selectors import Element, local_name
from robot.fields.drawing.style_sheets import SPACES
from robot.fields.drawing.svg_values import SvgError, shown
from robot.lfs_pointer import is_lfs_pointer

MAX_BYTES = 2 << 20
MAX_ELEMENTS = 10_000
MAX_DEPTH = 64
MAX_ENTITY = 256
"""Longest entity [characters]; drawing programs keep addresses and styles in them."""
MAX_ENTITIES = 64 << 10
"""Most characters that entities may make of a file."""


def read_bytes(path: Path) -> bytes:
    """Return the content of a drawing's file.

    Raises:
        SvgError: there is no such file, or it is too large to be a drawing.
    """
    try:
        if not path.is_file():
            raise SvgError("there is no such file")
        if path.stat().st_size > MAX_BYTES:
            raise SvgError(f"the file has {path.stat().st_size} bytes; valid are {MAX_BYTES}")
        data = path.read_bytes()
    except OSError as error:
        raise SvgError(f"the file cannot be read: {error.strerror}") from error
    if is_lfs_pointer(data):
        raise SvgError("it is where Git LFS keeps the file, not the file; git lfs pull gets it")
    return data


def parse(data: bytes) -> Element:
    """Return a drawing's outermost element.

    Raises:
        SvgError: the data is no SVG, or is made to grow.
    """
    try:
        _Guard(data)
        root = ElementTree.fromstring(data)
    except (expat.ExpatError, ElementTree.ParseError, LookupError) as error:
        raise SvgError(f"the file is not well-formed XML: {error}") from error
    except SvgError:
        raise
    except ValueError as error:  # an encoding that the parser does not know
        raise SvgError(f"the file is not well-formed XML: {error}") from error
    if not is_svg(root) or local_name(root)[1] != "svg":
        raise SvgError(f"the document is a {shown(root.tag)}; valid is an svg")
    return root


def is_svg(element: Element) -> bool:
    """Return whether an element is SVG's, and not what an editor stores for itself."""
    return local_name(element)[0] in SPACES


class _Guard:
    """Looks through a document for what could make a few bytes grow, before it is a tree."""

    def __init__(self, data: bytes) -> None:
        self._data = data
        self._depth = self._count = self._grown = 0
        parser = expat.ParserCreate()
        parser.EntityDeclHandler = self._on_entity
        parser.StartElementHandler = self._on_start
        parser.EndElementHandler = self._on_end
        parser.ProcessingInstructionHandler = self._on_instruction
        parser.Parse(data, True)

    def _on_entity(
        self, name: str, parameter: bool, value: str | None, *outside: str | None
    ) -> None:
        short = value is not None and len(value) <= MAX_ENTITY and not re.search("[&%<]", value)
        # In encodings of two bytes a use cannot be counted.
        if parameter or not short or value is None or b"\0" in self._data:
            self._refuse_entities()
        self._grown += len(value) * self._data.count(f"&{name};".encode())
        if self._grown > MAX_ENTITIES:
            self._refuse_entities()

    def _refuse_entities(self) -> NoReturn:
        raise SvgError(
            "the file declares XML entities that grow, or a DTD; valid is a plain SVG, with "
            f"entities of up to {MAX_ENTITY} characters"
        )

    def _on_start(self, _name: str, _attributes: object) -> None:
        self._depth += 1
        self._count += 1
        if self._depth > MAX_DEPTH:
            raise SvgError(f"elements nested deeper than {MAX_DEPTH}")
        if self._count > MAX_ELEMENTS:
            raise SvgError(f"more than {MAX_ELEMENTS} elements; use fewer")

    def _on_end(self, _name: str) -> None:
        self._depth -= 1

    def _on_instruction(self, target: str, _data: str) -> None:
        if target == "xml-stylesheet":
            raise SvgError("its style sheet is in another file; put it into a <style> element")
