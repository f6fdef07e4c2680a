"""Inertia of a robot whose links are simple solids of uniform density."""

from __future__ import annotations

from xml.etree import ElementTree

import numpy as np

from robot.description.urdf import Shape, SpecError, child, origin_of, parse_xml, positive, shape_of
from robot.geometry import Array

ENTRIES = {"ixx": (0, 0), "ixy": (0, 1), "ixz": (0, 2), "iyy": (1, 1), "iyz": (1, 2), "izz": (2, 2)}


def principal_moments(shape: Shape, mass: float) -> Array:
    """Return the moments (3,) [kg m^2] about the shape's own axes through its centre.

    Box ``m (b^2 + c^2) / 12``; cylinder about its axis ``m r^2 / 2`` and across
    ``m (3 r^2 + l^2) / 12``; sphere ``2 m r^2 / 5``.
    """
    if shape.kind == "box":
        squares = np.square(shape.size)
        box: Array = mass / 12 * (squares.sum() - squares)
        return box
    r = shape.size[0]
    if shape.kind == "sphere":
        return np.full(3, 0.4 * mass * r * r)
    across = mass / 12 * (3 * r * r + shape.size[1] ** 2)
    return np.array([across, across, mass / 2 * r * r])


def with_inertia(urdf_xml: str) -> str:
    """Return the description with every <inertia> computed from its link's one visual shape.

    The tensor is about the centre of mass, in the axes of <inertial>'s origin. A link without
    <inertial> is a frame or decoration and gets no inertia. An existing <inertia> is replaced.

    Raises:
        SpecError: a link with mass has no visual or several, or its shape has no dimensions.
    """
    root = parse_xml(urdf_xml)
    for link in root.iter("link"):
        inertial = link.find("inertial")
        if inertial is not None:
            _fill(inertial, link)
    return ElementTree.tostring(root, encoding="unicode")


def _fill(inertial: ElementTree.Element, link: ElementTree.Element) -> None:
    where = f"link {link.get('name')!r}"
    visuals = link.findall("visual")
    if len(visuals) != 1:
        raise SpecError(
            f"{where} has mass and {len(visuals)} visuals; its inertia needs exactly one, "
            "a box, cylinder or sphere"
        )
    mass = positive(child(inertial, "mass", where), "value", where)
    moments = principal_moments(shape_of(visuals[0], where), mass)
    turned = origin_of(inertial, where)[:3, :3].T @ origin_of(visuals[0], where)[:3, :3]
    tensor = turned @ np.diag(moments) @ turned.T
    for typed in inertial.findall("inertia"):
        inertial.remove(typed)
    entries = {name: repr(float(tensor[place])) for name, place in ENTRIES.items()}
    ElementTree.SubElement(inertial, "inertia", entries)
