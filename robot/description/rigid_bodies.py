"""A robot as a physics engine sees it: rigid bodies, their inertia, and joints between them."""

from __future__ import annotations

from dataclasses import dataclass, field
from xml.etree import ElementTree

import numpy as np

from robot.description.robot_model import MOMENTS, Inertial, Joint, Link, RobotModel, read_model
from robot.description.urdf import (
    Solid,
    SpecError,
    child,
    origin_of,
    parse_xml,
    positive,
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
    collisions: tuple[tuple[Solid, Array], ...] = field(repr=False)
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
    groups: dict[str, list[Link]] = {}
    for link in model.links:
        groups.setdefault(_topmost(link.name, model.holders), []).append(link)
    order = sorted(groups, key=lambda top: _depth(top, model.holders))
    return [_body(model, top, groups[top], order) for top in order]


def _topmost(link: str, holders: dict[str, Joint]) -> str:
    while link in holders and holders[link].type == "fixed":
        link = holders[link].parent
    return link


def _depth(link: str, holders: dict[str, Joint]) -> int:
    return 1 + _depth(holders[link].parent, holders) if link in holders else 0


def _body(model: RobotModel, top: str, links: list[Link], order: list[str]) -> RigidBody:
    placed = [(link, model.transform(link.name, top)) for link in links]
    parts = [(link.inertial, pose) for link, pose in placed if link.inertial is not None]
    mass, centre, inertia = _lump(top, parts)
    collisions = tuple(
        (shape, body_from_link @ link_from_shape)
        for link, body_from_link in placed
        for shape, link_from_shape in link.collisions
    )
    joint = model.holders.get(top)
    if joint is None:
        return RigidBody(
            top, mass, centre, inertia, collisions, None, -1, np.eye(4), np.array([0.0, 0.0, 1.0])
        )
    holder = _topmost(joint.parent, model.holders)
    return RigidBody(
        top, mass, centre, inertia, collisions, joint.name, order.index(holder),
        model.transform(top, holder), joint.axis / np.linalg.norm(joint.axis),
    )  # fmt: skip


def _lump(top: str, links: list[tuple[Inertial, Array]]) -> tuple[float, Array, Array]:
    """Return the total mass, centre (3,) and inertia (3, 3), by the parallel axis theorem."""
    parts = [
        (inertial.mass, inertial.inertia, body_from_link @ inertial.origin)
        for inertial, body_from_link in links
    ]
    mass = float(sum(part_mass for part_mass, _, _ in parts))
    if mass <= 0:
        raise SpecError(f"the body of link {top!r} can move, so it needs mass")
    centre = np.sum([m * place[:3, 3] for m, _, place in parts], axis=0) / mass
    inertia = np.zeros((3, 3))
    for part_mass, tensor, place in parts:
        away = place[:3, 3] - centre
        shift = away @ away * np.eye(3) - np.outer(away, away)
        inertia += place[:3, :3] @ tensor @ place[:3, :3].T + part_mass * shift
    return mass, centre, inertia


def principal_moments(shape: Solid, mass: float) -> Array:
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
    entries = {name: repr(float(tensor[place])) for name, place in MOMENTS.items()}
    ElementTree.SubElement(inertial, "inertia", entries)
