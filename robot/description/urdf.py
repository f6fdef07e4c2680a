"""Reader of those parts of a URDF file that BrickPose parses itself: numbers, shapes, origins.

The XML comes from outside. Document types are refused, because entities make XML dangerous and a
robot description needs none.
"""

from __future__ import annotations

from dataclasses import dataclass
from xml.etree import ElementTree

import numpy as np
from scipy.spatial.transform import Rotation

from robot.errors import BrickPoseError
from robot.geometry import Array

SHAPES = {"box": ("size",), "cylinder": ("radius", "length"), "sphere": ("radius",)}
"""The allowed shapes with their dimensions [m]; a mesh has no dimensions to compute with."""

LARGEST = 1e6
"""Largest number in a description, in any unit; far larger ones overflow when they are squared."""


class SpecError(BrickPoseError, ValueError):
    """A robot description that cannot be used; the message says what is wrong, and where."""


@dataclass(frozen=True, slots=True)
class Solid:
    """A solid of uniform density, centred on its origin; a cylinder's axis is z."""

    kind: str
    """box, cylinder or sphere."""
    size: tuple[float, ...]
    """Edges x, y, z of a box; radius and length of a cylinder; radius of a sphere [m]."""

    def corners(self) -> Array:
        """Return points (n, 3) [m] whose convex hull is the shape (32 points around round ones)."""
        if self.kind == "box":
            signs = np.stack(np.meshgrid([-1, 1], [-1, 1], [-1, 1]), axis=-1).reshape(-1, 3)
            edges: Array = signs * np.array(self.size) / 2
            return edges
        around = np.linspace(0, 2 * np.pi, 32, endpoint=False)
        circle = self.size[0] * np.column_stack([np.cos(around), np.sin(around), 0 * around])
        if self.kind == "sphere":
            return np.vstack([np.roll(circle, turn, axis=1) for turn in range(3)])
        half = np.array([0, 0, self.size[1] / 2])
        return np.vstack([circle - half, circle + half])


def parse_xml(text: str) -> ElementTree.Element:
    """Return the root element of a robot description.

    Raises:
        SpecError: the text is not XML, has a document type or entity, or is not a robot.
    """
    if "<!DOCTYPE" in text or "<!ENTITY" in text:
        raise SpecError("a document type or entity stands in it; a plain URDF has neither")
    try:
        root = ElementTree.fromstring(text)
    except (ElementTree.ParseError, ValueError) as error:
        raise SpecError(f"no readable XML: {error}") from error
    if root.tag != "robot":
        raise SpecError(f"the root element is <{root.tag}>; expected <robot>")
    return root


def child(element: ElementTree.Element, tag: str, where: str) -> ElementTree.Element:
    """Return the first child element with that tag.

    Raises:
        SpecError: there is no such child.
    """
    result = element.find(tag)
    if result is None:
        raise SpecError(f"{where}: <{tag}> is missing")
    return result


def numbers(element: ElementTree.Element, attribute: str, count: int, where: str) -> Array:
    """Return the finite numbers (count,) of an attribute; none is larger than ``LARGEST``.

    Raises:
        SpecError: the attribute is missing, or does not hold ``count`` such numbers.
    """
    text = element.get(attribute)
    if text is None:
        raise SpecError(f"{where}: <{element.tag}> lacks {attribute}")
    try:
        values = np.array([float(word) for word in text.split()])
    except ValueError:
        values = np.empty(0)
    if values.shape != (count,) or not (np.abs(values) <= LARGEST).all():
        wanted = "one finite number" if count == 1 else f"{count} finite numbers"
        raise SpecError(f"{where}: {attribute} is {text!r}; expected {wanted} up to {LARGEST:g}")
    return values


def positive(element: ElementTree.Element, attribute: str, where: str) -> float:
    """Return the number of an attribute that must be above zero.

    Raises:
        SpecError: the attribute is missing, not a number, or not positive.
    """
    value = float(numbers(element, attribute, 1, where)[0])
    if value <= 0:
        raise SpecError(f"{where}: {attribute} is {value:g}; it must be above zero")
    return value


def shape_of(element: ElementTree.Element, where: str) -> Solid:
    """Return the shape of a visual or collision.

    Raises:
        SpecError: the geometry is missing, of another kind, or has invalid dimensions.
    """
    geometry = child(element, "geometry", where)
    solid = next((part for part in geometry if part.tag in SHAPES), None)
    if solid is None:
        result = ", ".join(f"<{part.tag}>" for part in geometry) or "nothing"
        raise SpecError(f"{where}: geometry is {result}; valid are {', '.join(SHAPES)}")
    if solid.tag != "box":
        names = SHAPES[solid.tag]
        return Solid(solid.tag, tuple(positive(solid, name, where) for name in names))
    size = numbers(solid, "size", 3, where)
    if (size <= 0).any():
        raise SpecError(f"{where}: size is {solid.get('size')!r}; all three must be above zero")
    return Solid("box", tuple(size.tolist()))


def origin_of(element: ElementTree.Element, where: str) -> Array:
    """Return the transform (4, 4) of an element's <origin>; the identity if it has none.

    rpy turns about the fixed axes x, then y, then z.

    Raises:
        SpecError: the numbers are invalid.
    """
    transform = np.eye(4)
    origin = element.find("origin")
    if origin is not None and "xyz" in origin.attrib:
        transform[:3, 3] = numbers(origin, "xyz", 3, where)
    if origin is not None and "rpy" in origin.attrib:
        angles = numbers(origin, "rpy", 3, where)
        transform[:3, :3] = Rotation.from_euler("xyz", angles).as_matrix()
    return transform


def text_of(element: ElementTree.Element, name: str, where: str) -> str:
    """Return the text of the <param> with that name.

    Raises:
        SpecError: the <param> is missing or empty.
    """
    for param in element.findall("param"):
        if param.get("name") == name and param.text and param.text.strip():
            return param.text.strip()
    raise SpecError(f'{where}: <param name="{name}"> is missing')
