"""Choose the topics of the laser, the odometry and the transforms in a bag."""

from __future__ import annotations

from dataclasses import dataclass

from app.lab.localize.reading.bag import Bag, BagError, Topic
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
