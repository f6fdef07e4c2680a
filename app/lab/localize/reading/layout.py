"""Chooses what is read of a bag: topics, the laser's mounting and the robot's frames."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np

from app.lab.localize.reading.bag import Bag, BagError, Topic
from app.lab.localize.reading.transforms import Frames, Rigid3, frame_name
from robot.geometry import Pose2
from robot.settings import SettingError

LASER_SCAN = "sensor_msgs/msg/LaserScan"
ODOMETRY = "nav_msgs/msg/Odometry"
TRANSFORMS = "tf2_msgs/msg/TFMessage"
USUAL = "/odom"
"""Usual topic of wheel odometry, preferred if a bag has several odometries."""


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


def choose(bag: Bag, scan: str | None = None, odometry: str | None = None) -> Chosen:
    """Choose topics: the named ones, or the only ones of their type.

    Raises:
        SettingError: a named topic is missing or of another type, or there are several to choose
            from; lists them.
        BagError: there is no topic of a type; lists what the bag has.
    """
    transforms = tuple(topic.name for topic in bag.of_type(TRANSFORMS))
    laser = _choose_topic(bag, LASER_SCAN, scan, "--scan-topic")
    if laser is None:
        raise BagError(f"{bag.path} has no {LASER_SCAN}; {_held(bag)}")
    result = bag.of_type(ODOMETRY)
    if odometry is None and len(result) > 1 and USUAL in [topic.name for topic in result]:
        odometry = USUAL
    wheels = _choose_topic(bag, ODOMETRY, odometry, "--odom-topic")
    if wheels is None and not transforms:
        raise BagError(f"{bag.path} has no {ODOMETRY} and no {TRANSFORMS}; {_held(bag)}")
    return Chosen(laser, wheels, transforms)


def _choose_topic(bag: Bag, kind: str, wanted: str | None, option: str) -> str | None:
    result = [topic.name for topic in bag.of_type(kind)]
    if wanted is not None:
        name = wanted if wanted in result else f"/{wanted.lstrip('/')}"
        if name not in result:
            valid = ", ".join(result) or f"none, as it has no {kind}"
            raise SettingError(f"{option} {wanted} is not in {bag.path}; valid are {valid}")
        return name
    if len(result) > 1:
        raise SettingError(
            f"{bag.path} has {len(result)} topics of {kind}; "
            f"choose by {option}: {', '.join(result)}"
        )
    return result[0] if result else None


def _held(bag: Bag) -> str:
    if not bag.topics:
        return "it has no topics at all"
    return "it has " + ", ".join(_shown(topic) for topic in bag.topics)


def _shown(topic: Topic) -> str:
    return f"{topic.name} ({topic.type}, {topic.count})"


ROBOT_FRAMES = ("base_footprint", "base_link")
"""Usual names of the robot's own frame (REP-105, REP-120)."""
ODOM = "odom"


@dataclass(frozen=True)
class Layout:
    """The laser's mounting and the frames of the robot."""

    base_from_laser: Rigid3
    told_by: str
    """Where the mounting comes from, in words."""
    base_frame: str
    odom_frame: str
    """The frame whose transform to the base is the odometry, if there is no odometry topic."""
    assumed: bool = False
    """Whether the mounting is assumed, because nothing gives it."""


def find_layout(bag: Bag, chosen: Chosen, laser_pose: Pose2 | None) -> Layout:
    """Find the laser's mounting: as given, else by the bag's transforms.

    If neither gives it, the laser is assumed to sit at the robot's middle and to look ahead.

    Raises:
        BagError: odometry must come from the transforms, and they have none.
    """
    laser = frame_name(_first(bag, chosen.scan).header.frame_id)
    if chosen.odometry is None:
        layout = _by_transforms(bag, chosen, laser)
    else:
        base = frame_name(_first(bag, chosen.odometry).child_frame_id)
        layout = _on_base(bag, chosen, base, laser, search=laser_pose is None)
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
        raise BagError(
            f"{bag.path} should have messages on {topic}, by its metadata, and has none; valid is "
            "a whole bag"
        )
    return first.content


def _frames_over_time(bag: Bag, chosen: Chosen) -> Iterator[Frames]:
    """Yield the frames known so far, after each message."""
    frames = Frames()
    yield frames
    if chosen.transforms:
        for message in bag.messages(chosen.transforms):
            frames.add(message.content)
            yield frames


def _on_base(bag: Bag, chosen: Chosen, base: str, laser: str, *, search: bool) -> Layout:
    bases = [base, *(name for name in ROBOT_FRAMES if name != base)] if base else ROBOT_FRAMES
    if laser == bases[0]:
        return Layout(_identity(), f"the laser's frame is the robot's, {laser}", laser, ODOM)
    frames = Frames()
    for frames in _frames_over_time(bag, chosen) if search else ():
        result = frames.between(bases[0], laser)
        if result is not None:
            return Layout(result, f"the transform {bases[0]} to {laser}", bases[0], ODOM)
    for other in bases[1:]:  # the robot's frame may have another name
        result = frames.between(other, laser) if other != laser else _identity()
        if result is not None:
            return Layout(result, f"the transform {other} to {laser}", bases[0], ODOM)
    given = f"nothing: no transform leads from {bases[0]} to {laser or 'the laser'}"
    return Layout(_identity(), given, bases[0], ODOM, assumed=True)


def _by_transforms(bag: Bag, chosen: Chosen, laser: str) -> Layout:
    """Find the robot's frame: the ancestor of the laser's frame whose parent is the odom frame."""
    seen: list[str] = []
    for frames in _frames_over_time(bag, chosen):
        line = frames.lineage(laser)
        seen = [name for name, _ in line]
        for (base, base_from_laser), (parent, _) in pairwise(line):
            if parent.split("/")[-1] == ODOM:
                given = f"the transform {base} to {laser}"
                return Layout(base_from_laser, given, base, parent)
    raise BagError(
        f"{bag.path} has no nav_msgs/msg/Odometry, and its {TRANSFORMS} do not lead from "
        f"{laser or 'the laser'} to {ODOM}; they lead to {' - '.join(seen)}"
    )


def _identity() -> Rigid3:
    return Rigid3(np.eye(3), np.zeros(3))
