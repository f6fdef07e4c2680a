"""The messages of a recording that a replay reads, tick by tick."""

from __future__ import annotations

from collections.abc import Generator, Iterable, Mapping
from dataclasses import dataclass, field
from typing import ClassVar

from app.features.recordings.files.recorded import RecordedMessage, RecordingError


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


@dataclass(slots=True)
class RecordedTick:
    """The messages after one joint_states message, up to and including the next one."""

    log_ns: int
    """When the joints were recorded: the tick's time [ns since 1970]."""
    joints: bytes
    newest: dict[str, bytes] = field(default_factory=dict)
    """The newest message of each other topic, by topic."""
    commands: list[tuple[str, bytes]] = field(default_factory=list)
    """Topics and messages of commands and set poses, in their order."""


def ticks(
    messages: Iterable[RecordedMessage], topics: RecordedTopics
) -> Generator[RecordedTick, None, None]:
    """Group messages by tick; messages with the same log time as the joints belong to their tick.

    Args:
        messages: in the order of their log times.
    """
    newest: dict[str, bytes] = {}
    given: list[tuple[str, bytes]] = []
    tick: RecordedTick | None = None
    for message in messages:
        if tick is not None and (
            message.log_time_ns > tick.log_ns or message.topic == topics.joint_states
        ):
            yield tick
            newest, given, tick = {}, [], None
        if message.topic == topics.joint_states:
            tick = RecordedTick(message.log_time_ns, message.cdr, newest, given)
        elif message.topic in (topics.command, topics.initialpose):
            given.append((message.topic, message.cdr))
        else:
            newest[message.topic] = message.cdr
    if tick is not None:
        yield tick


def joined(before: list[RecordedTick], tick: RecordedTick) -> RecordedTick:
    """Return a tick with the messages of the unusable ticks before it."""
    if not before:
        return tick
    newest: dict[str, bytes] = {}
    given: list[tuple[str, bytes]] = []
    for item in (*before, tick):
        newest |= item.newest
        given += item.commands
    return RecordedTick(tick.log_ns, tick.joints, newest, given)
