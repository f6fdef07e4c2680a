"""Chooses the topics of a recording that a replay reads."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

from app.recordings.files.recorded import RecordingError


@dataclass(frozen=True, slots=True)
class RecordedTopics:
    """Topic names in the recording, with slash and namespace; empty if a topic is missing."""

    joint_states: str
    picture: str
    cmd_vel: str = ""
    battery_state: str = ""
    diagnostics: str = ""
    truth: str = ""
    amcl_pose: str = ""
    command: str = ""
    initialpose: str = ""

    WANTED: ClassVar[dict[str, tuple[str, str]]] = {
        "joint_states": ("joint_states", "sensor_msgs/msg/JointState"),
        "picture": ("camera/image/compressed", "sensor_msgs/msg/CompressedImage"),
        "cmd_vel": ("cmd_vel", "geometry_msgs/msg/TwistStamped"),
        "battery_state": ("battery_state", "sensor_msgs/msg/BatteryState"),
        "diagnostics": ("diagnostics", "diagnostic_msgs/msg/DiagnosticArray"),
        "truth": ("truth", "geometry_msgs/msg/PoseStamped"),
        "amcl_pose": ("amcl_pose", "geometry_msgs/msg/PoseWithCovarianceStamped"),
        "command": ("command", "std_msgs/msg/String"),
        "initialpose": ("initialpose", "geometry_msgs/msg/PoseWithCovarianceStamped"),
    }

    @classmethod
    def of(cls, types: Mapping[str, str]) -> RecordedTopics:
        """Choose the topics of a recording from its types by topic.

        Raises:
            RecordingError: joint_states or pictures are missing; lists the topics that exist.
        """
        result = {role: _find(types, *wanted) for role, wanted in cls.WANTED.items()}
        missing = [
            "{} ({})".format(*cls.WANTED[role])
            for role in ("joint_states", "picture")
            if not result[role]
        ]
        if missing:
            has = ", ".join(f"{name} ({kind})" for name, kind in sorted(types.items()))
            raise RecordingError(
                f"the recording has no {' and no '.join(missing)}, which a replay needs; "
                f"it has {has or 'nothing'}"
            )
        if result["command"]:
            result["initialpose"] = ""  # the commands include it
        return cls(**result)

    @property
    def names(self) -> tuple[str, ...]:
        """The names of all chosen topics."""
        return tuple(name for role in self.WANTED if (name := getattr(self, role)))


def _find(types: Mapping[str, str], name: str, kind: str) -> str:
    """Find a topic by its name in any namespace; the shortest if there are several."""
    fitting = [
        item for item, its in types.items() if its == kind and f"/{item}".endswith(f"/{name}")
    ]
    return min(fitting, key=len, default="")
