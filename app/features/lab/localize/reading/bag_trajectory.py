"""Read the poses of a bag as a trajectory: those of a topic, or of a chain of transforms."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from app.features.lab.localize.reading.bag import Bag
from app.features.lab.localize.reading.bag_files import is_bag_file
from app.features.lab.localize.reading.clocks import longest_rising
from app.features.lab.localize.reading.layout import ODOMETRY, TRANSFORMS
from app.features.lab.localize.reading.transforms import Rigid3, TransformTree, frame_name
from app.features.lab.trajectories.reading import read_trajectory
from app.trajectories.trajectory import FARTHEST, LATEST, LEFT_OUT, Trajectory, TrajectoryError
from robot.settings import SettingError

TF = "tf:"
"""Start of the name of a chain of transforms, as ``tf:odom.base_link``; evo has the same form."""
STATIC = "static"
"""Topics with this in their name hold transforms that do not change."""

Stamped = tuple[float, Rigid3 | None]


def _pose(pose: Any) -> Rigid3 | None:
    return Rigid3.of(pose.position, pose.orientation)


POSES: dict[str, Callable[[Any], Rigid3 | None]] = {
    ODOMETRY: lambda message: _pose(message.pose.pose),
    "geometry_msgs/msg/PoseWithCovarianceStamped": lambda message: _pose(message.pose.pose),
    "geometry_msgs/msg/PoseStamped": lambda message: _pose(message.pose),
    "geometry_msgs/msg/TransformStamped": lambda message: Rigid3.of(
        message.transform.translation, message.transform.rotation
    ),
}
"""The types of messages that are a stamped pose."""


def is_bag(path: Path) -> bool:
    """Whether a path is a bag by its name: a file of ROS, or a folder."""
    return path.is_dir() or is_bag_file(path)


def read_any(path: Path, body: str | None = None, topic: str | None = None) -> Trajectory:
    """Read a trajectory from a file of text or from a bag.

    Args:
        body: which rigid body of a motion capture's file.
        topic: which topic or chain of transforms of a bag; None if it has one only.

    Raises:
        TrajectoryError, BagError: it cannot be read, or is no trajectory.
        SettingError: the topic is missing, or there are several; lists what is there.
    """
    if is_bag(path):
        return read_bag_trajectory(path, topic)
    if topic is not None:
        raise SettingError(f"{path} is no bag, so it has no topic {topic}; valid is none")
    return read_trajectory(path, body)


def read_bag_trajectory(path: Path, topic: str | None = None) -> Trajectory:
    """Read the poses of a topic of a bag, or of a chain of transforms; as `read_any`."""
    with Bag(path) as bag:
        on_offer = {item.name: item.type for item in bag.topics if item.type in POSES}
        links = _links(bag)
        chosen = _chosen(path, topic, on_offer, links)
        if chosen.startswith(TF):
            poses = _chain(bag, chosen, links)
        else:
            pose_of = POSES[on_offer[chosen]]
            poses = [
                (_stamp(message.content.header, message.logged), pose_of(message.content))
                for message in bag.messages([chosen])
            ]
    return _trajectory(poses, f"{path}, {chosen}")


def _links(bag: Bag) -> Counter[tuple[str, str]]:
    """Return how often each pair of parent and child moves."""
    links: Counter[tuple[str, str]] = Counter()
    moving = [item.name for item in bag.of_type(TRANSFORMS) if STATIC not in item.name]
    for message in bag.messages(moving) if moving else ():
        links.update(_ends(transform) for transform in message.content.transforms)
    return links


def _ends(transform: Any) -> tuple[str, str]:
    return frame_name(transform.header.frame_id), frame_name(transform.child_frame_id)


def _chosen(
    path: Path, topic: str | None, on_offer: dict[str, str], links: Counter[tuple[str, str]]
) -> str:
    """Return the topic or chain that was asked for, or the only one."""
    chains = [f"{TF}{parent}.{child}" for parent, child in sorted(links)]
    valid = ", ".join([*sorted(on_offer), *chains]) or f"none, as it has no {' or '.join(POSES)}"
    if topic is None:
        only = list(on_offer) or chains
        if len(only) != 1:
            raise SettingError(
                f"{path} has {len(only) or 'no'} trajectories; choose by --recording-topic or "
                f"--truth-topic: {valid}"
            )
        return only[0]
    if topic.startswith(TF):
        return topic
    name = topic if topic in on_offer else f"/{topic.lstrip('/')}"
    if name not in on_offer:
        raise SettingError(f"{path} has no poses on {topic}; valid are {valid}")
    return name


def _chain(bag: Bag, name: str, links: Counter[tuple[str, str]]) -> list[Stamped]:
    """Return the poses of a frame in another one, at the stamps of its link that moves most."""
    base, _, frame = (frame_name(part) for part in name.removeprefix(TF).partition("."))
    frames = TransformTree()
    names = [item.name for item in bag.of_type(TRANSFORMS)]
    for message in bag.messages(names):
        frames.add(message.content)
    line = [part for part, _ in frames.lineage(frame)]
    steps = [(parent, child) for child, parent in pairwise(line)]
    steps = steps[: line.index(base)] if base in line else []
    fastest = max(steps, key=lambda step: links[step], default=None)
    if fastest is None or not links[fastest]:
        valid = ", ".join(f"{TF}{parent}.{child}" for parent, child in sorted(links))
        raise SettingError(
            f"{bag.path}: no transforms that move lead from {frame or 'nothing'} to "
            f"{base or 'nothing'}; valid is {TF}PARENT.CHILD, as {valid or 'none here'}"
        )
    return list(_followed(bag, names, base, frame, fastest))


def _followed(
    bag: Bag, names: list[str], base: str, frame: str, fastest: tuple[str, str]
) -> Iterator[Stamped]:
    frames = TransformTree()
    for message in bag.messages(names):
        frames.add(message.content)
        for transform in message.content.transforms:
            if _ends(transform) == fastest and base in dict(frames.lineage(frame)):
                yield _stamp(transform.header, message.logged), frames.between(base, frame)


def _stamp(header: Any, logged: float) -> float:
    """Return the stamp of a header; if it has none, the time of recording."""
    stamp: float = header.stamp.sec + 1e-9 * header.stamp.nanosec
    return stamp if stamp > 0 else logged


def _trajectory(poses: list[Stamped], source: str) -> Trajectory:
    """Return the poses that can be used, in order; a note counts the others."""
    usable = [
        (stamp, pose)
        for stamp, pose in poses
        if pose is not None and abs(stamp) <= LATEST and np.abs(pose.translation).max() <= FARTHEST
    ]
    kept = [usable[index] for index in longest_rising([stamp for stamp, _ in usable])]
    if len(kept) < 2:
        raise TrajectoryError(
            f"{source} has {len(kept)} usable of {len(poses)} poses; valid are 2 and more"
        )
    lost = len(poses) - len(kept)
    return Trajectory(
        np.array([stamp for stamp, _ in kept]),
        np.array([pose.translation for _, pose in kept]),
        Rotation.from_matrix(np.array([pose.rotation for _, pose in kept])).as_quat(),
        source,
        (f"{LEFT_OUT} {lost} of {len(poses)} poses of {source}",) if lost else (),
    )
