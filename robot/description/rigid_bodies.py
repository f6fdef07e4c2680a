"""A robot as a physics engine sees it: rigid bodies, their inertia, and joints between them."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any
from xml.etree import ElementTree

import numpy as np

from robot.description.urdf import (
    Shape,
    SpecError,
    child,
    origin_of,
    parse_xml,
    positive,
    read_model,
    shape_of,
)
from robot.geometry import Array


@dataclass(frozen=True, eq=False)
class RigidBody:
    """Links that fixed joints hold together; coordinates are in the topmost link's frame."""

    name: str
    """The topmost link."""
    mass: float
    """[kg]"""
    centre: Array = field(repr=False)
    """Centre of mass (3,) [m]."""
    inertia: Array = field(repr=False)
    """(3, 3) about the centre of mass [kg m^2]."""
    collisions: tuple[tuple[Shape, Array], ...] = field(repr=False)
    """Collision shapes, each with ``body_from_shape`` (4, 4)."""
    joint: str | None
    """The joint that moves the body; None for the root."""
    parent: int
    """Index, in the list of bodies, of the body that the joint hangs on; -1 for the root."""
    parent_from_body: Array = field(repr=False)
    """Transform (4, 4) with the joint at zero."""
    axis: Array = field(repr=False)
    """The joint's axis (3,), a unit vector in this body's frame."""


def rigid_bodies(urdf: str) -> list[RigidBody]:
    """Return the bodies of a description that contains inertia; parents come before children.

    Raises:
        SpecError: a body that can move has no mass, or a collision shape is a mesh.
    """
    model = read_model(urdf)
    held_by = {joint.child: joint for joint in model.robot.joints}
    groups: dict[str, list[Any]] = {}
    for link in model.robot.links:
        groups.setdefault(_topmost(link.name, held_by), []).append(link)
    order = sorted(groups, key=lambda top: _depth(top, held_by))
    return [_body(model, top, groups[top], held_by, order) for top in order]


def _topmost(link: str, held_by: dict[str, Any]) -> str:
    while link in held_by and held_by[link].type == "fixed":
        link = held_by[link].parent
    return link


def _depth(link: str, held_by: dict[str, Any]) -> int:
    return 1 + _depth(held_by[link].parent, held_by) if link in held_by else 0


def _body(
    model: Any, top: str, links: list[Any], held_by: dict[str, Any], order: list[str]
) -> RigidBody:
    placed = [(link, np.asarray(model.get_transform(link.name, top))) for link in links]
    mass, centre, inertia = _lump(top, placed)
    collisions = tuple(
        (_shape(collision.geometry, link.name), body_from_link @ _transform(collision.origin))
        for link, body_from_link in placed
        for collision in link.collisions
    )
    joint = held_by.get(top)
    if joint is None:
        return RigidBody(
            top, mass, centre, inertia, collisions, None, -1, np.eye(4), np.array([0.0, 0.0, 1.0])
        )
    holder = _topmost(joint.parent, held_by)
    return RigidBody(
        top, mass, centre, inertia, collisions, joint.name, order.index(holder),
        np.asarray(model.get_transform(top, holder)), joint.axis / np.linalg.norm(joint.axis),
    )  # fmt: skip


def _lump(top: str, placed: list[tuple[Any, Array]]) -> tuple[float, Array, Array]:
    """Return the total mass, centre (3,) and inertia (3, 3), by the parallel axis theorem."""
    parts = [
        (
            link.inertial.mass,
            link.inertial.inertia,
            body_from_link @ _transform(link.inertial.origin),
        )
        for link, body_from_link in placed
        if link.inertial is not None
    ]
    mass = float(sum(part_mass for part_mass, _, _ in parts))
    if mass <= 0:
        raise SpecError(f"the body of link {top!r} can move, so it needs mass")
    centre: Array = sum(m * position[:3, 3] for m, _, position in parts) / mass
    inertia = np.zeros((3, 3))
    for part_mass, tensor, place in parts:
        away = place[:3, 3] - centre
        shift = away @ away * np.eye(3) - np.outer(away, away)
        inertia += place[:3, :3] @ tensor @ place[:3, :3].T + part_mass * shift
    return mass, centre, inertia


def _transform(origin: Array | None) -> Array:
    return np.eye(4) if origin is None else origin


def _shape(geometry: Any, link: str) -> Shape:
    if geometry.box is not None:
        return Shape("box", tuple(geometry.box.size.tolist()))
    if geometry.cylinder is not None:
        return Shape("cylinder", (geometry.cylinder.radius, geometry.cylinder.length))
    if geometry.sphere is not None:
        return Shape("sphere", (geometry.sphere.radius,))
    raise SpecError(f"link {link!r}: a collision shape is a mesh; valid are box, cylinder, sphere")


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
