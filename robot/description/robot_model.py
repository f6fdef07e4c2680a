"""The links and joints of a robot description, as a tree of frames.

Read here rather than by a library: those for URDF bring a library of meshes along, 43 MB in each
program, and a description of bricks has no meshes.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from xml.etree import ElementTree

import numpy as np
from scipy.spatial.transform import Rotation

from robot.description.urdf import (
    Solid,
    SpecError,
    child,
    numbers,
    origin_of,
    parse_xml,
    positive,
    shape_of,
)
from robot.geometry import Array

JOINT_TYPES = ("fixed", "continuous", "revolute", "prismatic", "floating", "planar")

MOMENTS = {"ixx": (0, 0), "ixy": (0, 1), "ixz": (0, 2), "iyy": (1, 1), "iyz": (1, 2), "izz": (2, 2)}
"""Attributes of <inertia>, by their place in the upper half of the tensor."""


@dataclass(frozen=True, eq=False)
class Inertial:
    """Mass of a link, and how it is spread."""

    mass: float
    """[kg]"""
    inertia: Array = field(repr=False)
    """(3, 3) about the centre of mass, in the axes of ``origin`` [kg m^2]."""
    origin: Array = field(repr=False)
    """The centre of mass in the link's frame, as a transform (4, 4)."""


@dataclass(frozen=True, eq=False)
class Link:
    """One part, with its own frame."""

    name: str
    inertial: Inertial | None
    collisions: tuple[tuple[Solid, Array], ...] = field(repr=False)
    """Shapes that touch others, each with ``link_from_shape`` (4, 4)."""


@dataclass(frozen=True, eq=False)
class Joint:
    """Holds one link at another."""

    name: str
    type: str
    parent: str
    child: str
    origin: Array = field(repr=False)
    """``parent_from_child`` (4, 4) with the joint at zero."""
    axis: Array = field(repr=False)
    """Direction (3,) of its movement in the child's frame."""


@dataclass(frozen=True, eq=False)
class RobotModel:
    """All links and joints; they form a tree."""

    links: tuple[Link, ...]
    joints: tuple[Joint, ...]

    @cached_property
    def holders(self) -> dict[str, Joint]:
        """The joint on which each link but the root hangs, by the link's name."""
        return {joint.child: joint for joint in self.joints}

    @cached_property
    def names(self) -> frozenset[str]:
        """The names of the links."""
        return frozenset(link.name for link in self.links)

    @cached_property
    def root(self) -> str:
        """The link that hangs on no other."""
        return next(link.name for link in self.links if link.name not in self.holders)

    def transform(self, link: str, frame: str) -> Array:
        """Return ``frame_from_link`` (4, 4), between two links, with all joints at zero."""
        root_from_frame = self._from_root(frame)
        result: Array = np.linalg.inv(root_from_frame) @ self._from_root(link)
        return result

    def _from_root(self, link: str) -> Array:
        transform = np.eye(4)
        while link in self.holders:
            joint = self.holders[link]
            transform, link = joint.origin @ transform, joint.parent
        return transform


def read_model(urdf: str) -> RobotModel:
    """Return the links and joints of a description.

    Raises:
        SpecError: the text is no URDF, its numbers are invalid, or the links do not form a tree.
    """
    root = parse_xml(urdf)
    _check_tree(root)
    return RobotModel(
        tuple(_link(link) for link in root.findall("link")),
        tuple(_joint(joint) for joint in root.findall("joint")),
    )


def _link(element: ElementTree.Element) -> Link:
    name = str(element.get("name"))
    where = f"link {name!r}"
    inertial = element.find("inertial")
    return Link(
        name,
        None if inertial is None else _inertial(inertial, where),
        tuple(
            (shape_of(collision, f"{where}: collision"), origin_of(collision, where))
            for collision in element.findall("collision")
        ),
    )


def _inertial(element: ElementTree.Element, where: str) -> Inertial:
    moments = child(element, "inertia", where)
    tensor = np.empty((3, 3))
    for name, (row, column) in MOMENTS.items():
        tensor[row, column] = tensor[column, row] = numbers(moments, name, 1, where)[0]
    mass = positive(child(element, "mass", where), "value", where)
    return Inertial(mass, tensor, origin_of(element, where))


def _joint(element: ElementTree.Element) -> Joint:
    name = str(element.get("name"))
    where = f"joint {name!r}"
    kind = str(element.get("type"))
    if kind not in JOINT_TYPES:
        raise SpecError(f"{where}: type is {kind!r}; valid are {', '.join(JOINT_TYPES)}")
    parent, held = (str(child(element, tag, where).get("link")) for tag in ("parent", "child"))
    return Joint(name, kind, parent, held, origin_of(element, where), _axis(element, where))


def _axis(joint: ElementTree.Element, where: str) -> Array:
    element = joint.find("axis")
    if element is None:
        return np.array([1.0, 0.0, 0.0])
    axis = numbers(element, "xyz", 3, where)
    if not axis.any():
        raise SpecError(f"{where}: the axis is 0 0 0; it must point somewhere")
    return axis


def _check_tree(root: ElementTree.Element) -> None:
    """Check that every link but the root has exactly one parent, and that there is one root."""
    links = [link.get("name") for link in root.findall("link")]
    holders: dict[str | None, str | None] = {}
    for joint in root.findall("joint"):
        where = f"joint {joint.get('name')!r}"
        held, holder = (child(joint, tag, where).get("link") for tag in ("child", "parent"))
        for link in (held, holder):
            if link not in links:
                raise SpecError(f"{where}: there is no link {link!r}")
        if held in holders:
            raise SpecError(f"{where}: link {held!r} hangs on another joint already")
        holders[held] = holder
    if None in links or len(set(links)) != len(links):
        raise SpecError("each link needs a name of its own")
    roots = [link for link in links if link not in holders]
    if len(roots) != 1:
        raise SpecError(f"{len(roots)} links hang on no other; expected one, the root")
    if any(_steps_up(link, holders) > len(links) for link in links):
        raise SpecError("some links hang on each other in a ring; expected a tree")


def _steps_up(link: str | None, holders: dict[str | None, str | None]) -> int:
    """Return the number of joints from a link to the root; in a ring, more than there are links."""
    steps = 0
    while link in holders and steps <= len(holders) + 1:
        link, steps = holders[link], steps + 1
    return steps


def place_link(
    root: ElementTree.Element, model: RobotModel, link: str, root_from_link: Array
) -> None:
    """Move a link to another pose, and the part to which it is fixed with it.

    Args:
        root: the description; the origin of one joint is changed in it.
        root_from_link: its pose (4, 4) in the frame of the root link.
    """
    joint, pose = model.holders[link], root_from_link
    if joint.type == "fixed" and joint.parent in model.holders:
        pose = pose @ np.linalg.inv(joint.origin)
        joint = model.holders[joint.parent]
    origin = model.transform(model.root, joint.parent) @ pose
    element = next(item for item in root.findall("joint") if item.get("name") == joint.name)
    for each in element.findall("origin"):
        element.remove(each)
    angles = Rotation.from_matrix(origin[:3, :3]).as_euler("xyz")
    texts = (" ".join(repr(float(part)) for part in parts) for parts in (origin[:3, 3], angles))
    ElementTree.SubElement(element, "origin", dict(zip(("xyz", "rpy"), texts, strict=True)))
