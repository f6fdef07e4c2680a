"""The messages of a recording, tick by tick."""

from __future__ import annotations

from collections.abc import Generator, Iterable
from dataclasses import dataclass, field

from app.recordings.files.recorded import RecordedMessage
from app.recordings.replay.recorded.topics import RecordedTopics


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
        topics: of the recording.
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
