"""Frames and the transforms between them (tf)."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from robot.geometry import Array, Pose2

MOST = 50
"""Largest number of frames from one to another; more mean a loop."""
SHORTEST = 1e-3
"""A quaternion shorter than this has no direction."""


def frame_name(name: str) -> str:
    """Return a frame's name without the leading slash that ROS 1 allowed."""
    return name.strip().lstrip("/")


@dataclass(frozen=True, eq=False)
class Rigid3:
    """A rigid transform in space: ``a_from_b``."""

    rotation: Array = field(repr=False)
    """(3, 3)"""
    translation: Array
    """(3,) [m]"""

    @classmethod
    def of(cls, translation: Any, rotation: Any) -> Rigid3 | None:
        """Make a transform from a message's vector and quaternion; None if they are invalid."""
        t = np.array([translation.x, translation.y, translation.z], dtype=np.float64)
        q = np.array([rotation.x, rotation.y, rotation.z, rotation.w], dtype=np.float64)
        length = float(np.linalg.norm(q))
        if not (np.isfinite(t).all() and SHORTEST < length < np.inf):
            return None
        return cls(Rotation.from_quat(q).as_matrix(), t)

    @classmethod
    def flat(cls, pose: Pose2) -> Rigid3:
        """Make a transform from a planar pose."""
        c, s = np.cos(pose.theta), np.sin(pose.theta)
        turn = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
        return cls(turn, np.array([pose.x, pose.y, 0.0]))

    def __matmul__(self, other: Rigid3) -> Rigid3:
        """``a_from_b @ b_from_c`` is ``a_from_c``."""
        moved = self.rotation @ other.translation + self.translation
        return Rigid3(self.rotation @ other.rotation, moved)

    def inverse(self) -> Rigid3:
        """Return ``b_from_a``."""
        return Rigid3(self.rotation.T, -self.rotation.T @ self.translation)

    def planar(self) -> Pose2:
        """Return the pose seen from above: the position, and the heading of the x axis."""
        x, y, _ = self.translation
        return Pose2(
            float(x), float(y), float(np.arctan2(self.rotation[1, 0], self.rotation[0, 0]))
        )


class TransformTree:
    """The newest transform from each frame to its parent."""

    def __init__(self) -> None:
        self._parents: dict[str, tuple[str, Rigid3]] = {}

    def add(self, message: Any) -> None:
        """Add the transforms of a TFMessage; invalid ones are left out."""
        for transform in message.transforms:
            rigid3 = Rigid3.of(transform.transform.translation, transform.transform.rotation)
            child, parent = (
                frame_name(transform.child_frame_id),
                frame_name(transform.header.frame_id),
            )
            if rigid3 is not None and child and parent and child != parent:
                self._parents[child] = parent, rigid3

    @property
    def links(self) -> list[tuple[str, str]]:
        """Each parent with its child, by name."""
        return sorted((parent, child) for child, (parent, _) in self._parents.items())

    def like(self, name: str, namespace: str = "") -> str:
        """Return the frame that is meant by a name: itself, or the only one that is like it.

        Drivers leave a namespace out; Gazebo writes ``model/link/sensor`` for a sensor on a link.
        """
        names = {frame for link in self.links for frame in link}
        if name in names or not name:
            return name
        if f"{namespace}/{name}" in names:
            return f"{namespace}/{name}"
        parts = name.split("/")
        for alike in (
            {frame for frame in names if frame.endswith(f"/{name}")},
            {frame for frame in names if frame.split("/")[-1] in parts[1:]},
        ):
            if len(alike) == 1:
                return alike.pop()
        return name

    def lineage(self, frame: str) -> list[tuple[str, Rigid3]]:
        """Return a frame, its parent and so on, each with ``it_from_frame``."""
        result = [(frame, Rigid3(np.eye(3), np.zeros(3)))]
        while result[-1][0] in self._parents and len(result) <= MOST:
            name, from_frame = result[-1]
            parent, parent_from_name = self._parents[name]
            result.append((parent, parent_from_name @ from_frame))
        return result

    def between(self, base: str, frame: str) -> Rigid3 | None:
        """Return ``base_from_frame``; None if no known transforms connect them."""
        ancestors = dict(self.lineage(base))
        for name, from_frame in self.lineage(frame):
            if name in ancestors:
                return ancestors[name].inverse() @ from_frame
        return None
