"""The messages of a recording, tick by tick."""

from __future__ import annotations

from collections.abc import Generator, Iterable
from dataclasses import dataclass, field

from app.recordings.files.recorded import RecordedMessage
from app.recordings.replay.recorded.topics import RecordedTopics


@dataclass(slots=True)
class RecordedTick:
    """What came after one message of the joints, up to and with the next one."""

    log_ns: int
    """When the joints were recorded: the tick's time [ns since 1970]."""
    joints: bytes
    newest: dict[str, bytes] = field(default_factory=dict)
    """By topic, of all others the newest message."""
    told: list[tuple[str, bytes]] = field(default_factory=list)
    """Commands and poses, in their order, with their topics."""


def ticks(
    messages: Iterable[RecordedMessage], topics: RecordedTopics
) -> Generator[RecordedTick, None, None]:
    """Group messages by tick: what was recorded at the very time of the joints belongs to them.

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
    """A tick with what came in those before it that could not be used."""
    if not before:
        return tick
    newest: dict[str, bytes] = {}
    given: list[tuple[str, bytes]] = []
    for item in (*before, tick):
        newest |= item.newest
        given += item.told
    return RecordedTick(tick.log_ns, tick.joints, newest, given)
