"""Chooses what is read of a bag: topics, the laser's mounting and the robot's frames."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any

import numpy as np

from app.features.lab.localize.reading.bag import Bag
from app.features.lab.localize.reading.sources import BagError, BagTopic
from app.features.lab.localize.reading.transforms import Rigid3, TransformTree, frame_name
from robot.geometry import Pose2
from robot.settings import SettingError

LASER_SCAN = "sensor_msgs/msg/LaserScan"
ODOMETRY = "nav_msgs/msg/Odometry"
TRANSFORMS = "tf2_msgs/msg/TFMessage"
USUAL = "/odom"
"""Usual topic of wheel odometry, preferred if a bag has several odometries."""
ODOM = "odom"
"""Usual name of its frame."""
ROBOT_FRAMES = ("base_footprint", "base_link")
"""Usual names of the robot's own frame (REP-105, REP-120)."""
MOST_LISTED = 30
"""Number of transforms that a message lists."""


@dataclass(frozen=True, slots=True)
class Chosen:
    """The topics that are read from a bag."""

    scan: str
    odometry: str | None
    """None if odometry comes from the transforms."""
    transforms: tuple[str, ...]

    @property
    def names(self) -> tuple[str, ...]:
        """The topics that are read while the robot is followed."""
        return (self.scan, self.odometry) if self.odometry else (self.scan, *self.transforms)


@dataclass(frozen=True, slots=True)
class BagNames:
    """How a robot's frames and topics are called, where they are not called as usual."""

    odom_frame: str = ""
    """Frame of odometry; if it is given, odometry comes from the transforms."""
    base_frame: str = ""
    namespace: str = ""
    """Of one robot of several, without slashes around it."""

    @classmethod
    def of(cls, odom: str | None, base: str | None, namespace: str | None) -> BagNames:
        """Take names as they are given on a command line, with or without slashes."""
        return cls(*((name or "").strip("/ ") for name in (odom, base, namespace)))

    def is_odom(self, frame: str) -> bool:
        """Whether a frame is that of odometry."""
        if self.odom_frame:
            return frame in (self.odom_frame, f"{self.namespace}/{self.odom_frame}")
        *space, last = frame.split("/")
        return last == ODOM and (not self.namespace or "/".join(space) in ("", self.namespace))

    def has(self, topic: str) -> bool:
        """Whether a topic is in the namespace."""
        return not self.namespace or topic.strip("/").startswith(f"{self.namespace}/")


USUAL_NAMES = BagNames()


def choose(
    bag: Bag, scan: str | None = None, odometry: str | None = None, names: BagNames = USUAL_NAMES
) -> Chosen:
    """Choose topics: the named ones, or the only ones of their type.

    Raises:
        SettingError: a named topic is missing or of another type, or there are several to choose
            from; lists them.
        BagError: there is no topic of a type; lists what the bag has.
    """
    everywhere = [topic.name for topic in bag.of_type(TRANSFORMS)]
    transforms = tuple([name for name in everywhere if names.has(name)] or everywhere)
    laser = _choose_topic(bag, LASER_SCAN, scan, "--scan-topic", names)
    if laser is None:
        raise BagError(f"{bag.path} has no {LASER_SCAN}{_within(names)}; {_held(bag)}")
    result = [topic.name for topic in bag.of_type(ODOMETRY)]
    usual = f"/{names.namespace}{USUAL}" if names.namespace else USUAL
    if odometry is None and len(result) > 1 and usual in result:
        odometry = usual
    by_frames = bool(names.odom_frame) and odometry is None
    wheels = None if by_frames else _choose_topic(bag, ODOMETRY, odometry, "--odom-topic", names)
    if wheels is None and not transforms:
        raise BagError(f"{bag.path} has no {ODOMETRY} and no {TRANSFORMS}; {_held(bag)}")
    return Chosen(laser, wheels, transforms)


def _within(names: BagNames) -> str:
    return f" in the namespace {names.namespace}" if names.namespace else ""


def _choose_topic(
    bag: Bag, kind: str, wanted: str | None, option: str, names: BagNames
) -> str | None:
    result = [topic.name for topic in bag.of_type(kind)]
    if wanted is None:
        result = [name for name in result if names.has(name)]
    else:
        name = wanted if wanted in result else f"/{wanted.lstrip('/')}"
        if name not in result:
            valid = ", ".join(result) or f"none, as it has no {kind}"
            raise SettingError(f"{option} {wanted} is not in {bag.path}; valid are {valid}")
        return name
    if len(result) > 1:
        several = ", several times if they are one robot's lasers" if kind == LASER_SCAN else ""
        raise SettingError(
            f"{bag.path} has {len(result)} topics of {kind}; "
            f"choose by {option}{several}: {', '.join(result)}; or by --namespace"
        )
    return result[0] if result else None


def _held(bag: Bag) -> str:
    if not bag.topics:
        return "it has no topics at all"
    return "it has " + ", ".join(_shown(topic) for topic in bag.topics)


def _shown(topic: BagTopic) -> str:
    return f"{topic.name} ({topic.type}, {topic.count})"


@dataclass(frozen=True)
class Layout:
    """The laser's mounting and the frames of the robot."""

    base_from_laser: Rigid3
    pose_from: str
    """Where the mounting comes from, in words."""
    base_frame: str
    odom_frame: str
    """The frame whose transform to the base is the odometry, if there is no odometry topic."""
    assumed: bool = False
    """Whether the mounting is assumed, because nothing gives it."""


def find_layout(
    bag: Bag, chosen: Chosen, laser_pose: Pose2 | None, names: BagNames = USUAL_NAMES
) -> Layout:
    """Find the laser's mounting: as given, else by the bag's transforms.

    If neither gives it, the laser is assumed to sit at the robot's middle and to look ahead.

    Raises:
        BagError: odometry must come from the transforms, and they have none.
    """
    laser = frame_name(_first(bag, chosen.scan).header.frame_id)
    if chosen.odometry is None:
        layout = _by_transforms(bag, chosen, laser, names, search=laser_pose is None)
    else:
        base = names.base_frame or frame_name(_first(bag, chosen.odometry).child_frame_id)
        layout = _on_base(bag, chosen, base, laser, names, search=laser_pose is None)
    if laser_pose is None:
        return layout
    given = Rigid3.flat(laser_pose)
    return Layout(given, "--laser-pose", layout.base_frame, layout.odom_frame)


def _first(bag: Bag, topic: str) -> Any:
    messages = bag.messages([topic])
    try:
        first = next(messages, None)
    finally:
        messages.close()  # type: ignore[attr-defined]
    if first is None:
        why = "; ".join(["", *bag.damages])
        raise BagError(
            f"no message on {topic} in {bag.path} can be read{why}; valid is a whole bag"
        )
    return first.content


def _frames_over_time(bag: Bag, chosen: Chosen) -> Iterator[TransformTree]:
    """Yield the frames known so far, after each message."""
    frames = TransformTree()
    yield frames
    if chosen.transforms:
        for message in bag.messages(chosen.transforms):
            frames.add(message.content)
            yield frames


def _on_base(
    bag: Bag, chosen: Chosen, base: str, laser: str, names: BagNames, *, search: bool
) -> Layout:
    bases = [base, *(name for name in ROBOT_FRAMES if name != base)] if base else ROBOT_FRAMES
    if laser == bases[0]:
        return Layout(_identity(), f"the laser's frame is the robot's, {laser}", laser, ODOM)
    frames = TransformTree()
    for frames in _frames_over_time(bag, chosen) if search else ():
        layout = _mounted(frames, bases[0], laser, bases[0], names)
        if layout is not None:
            return layout
    for other in bases[1:]:  # the robot's frame may have another name
        layout = _mounted(frames, other, laser, bases[0], names)
        if layout is not None:
            return layout
    given = f"nothing: no transform leads from {bases[0]} to {laser or 'the laser'}"
    if search and frames.links:
        given += f" among {_listed(frames)}"
    return Layout(_identity(), given, bases[0], ODOM, assumed=True)


def _mounted(
    frames: TransformTree, base: str, laser: str, reported: str, names: BagNames
) -> Layout | None:
    """Return the layout if transforms lead from a base to the laser, or to frames like them."""
    start, end = (frames.like(name, names.namespace) for name in (base, laser))
    result = frames.between(start, end) if start != end else _identity()
    if result is None:
        return None
    given = f"the transform {start} to {end}"
    given += f", taken for {laser}" if end != laser else ""
    return Layout(result, given, reported, ODOM)


def _by_transforms(
    bag: Bag, chosen: Chosen, laser: str, names: BagNames, *, search: bool
) -> Layout:
    """Find the robot's frame: the ancestor of the laser's frame whose parent is the odom frame."""
    frames, base = TransformTree(), None
    for frames in _frames_over_time(bag, chosen):
        base = _base_and_odom(frames, laser, names)
        layout = _mounted(frames, base[0], laser, base[0], names) if base else None
        if base and layout:
            return replace(layout, odom_frame=base[1])
    if base is not None and not search:
        return Layout(_identity(), "--laser-pose", *base)
    lacks = f"from {laser or 'the laser'} to {names.odom_frame or ODOM}"
    if base is not None:
        lacks = f"from {base[0]} to {laser or 'the laser'}; --laser-pose says where it sits"
    raise BagError(
        f"{bag.path}: odometry has to come from its {TRANSFORMS}, and they do not lead {lacks}; "
        f"there are {_listed(frames)}; --odom-frame, --base-frame and --namespace choose among them"
    )


def _base_and_odom(frames: TransformTree, laser: str, names: BagNames) -> tuple[str, str] | None:
    """Return the robot's frame and that of odometry: above the laser, or the only such pair."""
    start = frames.like(names.base_frame or laser, names.namespace)
    for (base, _), (parent, _) in pairwise(frames.lineage(start)):
        if names.is_odom(parent):
            return base, parent
    below = [(child, parent) for parent, child in frames.links if names.is_odom(parent)]
    return below[0] if len(below) == 1 and not names.base_frame else None


def _listed(frames: TransformTree) -> str:
    """Return all transforms by name, of many the first."""
    words = [f"{parent} - {child}" for parent, child in frames.links]
    more = f" and {len(words) - MOST_LISTED} more" if len(words) > MOST_LISTED else ""
    return (", ".join(words[:MOST_LISTED]) or "none") + more


def _identity() -> Rigid3:
    return Rigid3(np.eye(3), np.zeros(3))
