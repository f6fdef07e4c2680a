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
    told: list[tuple[str, bytes]] = []
    tick: RecordedTick | None = None
    for one in messages:
        if tick is not None and (one.log_time_ns > tick.log_ns or one.topic == topics.joint_states):
            yield tick
            newest, told, tick = {}, [], None
        if one.topic == topics.joint_states:
            tick = RecordedTick(one.log_time_ns, one.cdr, newest, told)
        elif one.topic in (topics.command, topics.initialpose):
            told.append((one.topic, one.cdr))
        else:
            newest[one.topic] = one.cdr
    if tick is not None:
        yield tick


def joined(before: list[RecordedTick], tick: RecordedTick) -> RecordedTick:
    """A tick with what came in those before it that could not be used."""
    if not before:
        return tick
    newest: dict[str, bytes] = {}
    told: list[tuple[str, bytes]] = []
    for one in (*before, tick):
        newest |= one.newest
        told += one.told
    return RecordedTick(tick.log_ns, tick.joints, newest, told)
