"""Finds what was recorded at a time, without the filter."""

from __future__ import annotations

import contextlib
from dataclasses import dataclass

from app.features.recordings.files.mcap_reader import RecordingReader
from app.features.recordings.files.recorded import RecordingError
from app.features.recordings.replay.decoding import (
    ContentError,
    picture_of,
    pose_and_covariance_of,
    truth_of,
)
from app.features.recordings.replay.ticks import RecordedTick, RecordedTopics, ticks
from app.features.ros.message_types import MessageError
from robot.geometry import Pose2
from robot.interface import Frame

SEARCH_BACK_NS = (2_000_000_000, 20_000_000_000)
"""How far back the last picture is searched [ns], before the whole recording is searched."""


@dataclass(frozen=True, slots=True)
class Preview:
    """The last recorded values up to a time."""

    log_ns: int
    """Time of the tick [ns since 1970]."""
    picture_log_ns: int | None
    """Time of the tick with the last picture [ns since 1970]; None if there is none."""
    frame: Frame | None
    """That picture, with its stamp as recorded [s]."""
    recorded_estimate: Pose2 | None
    """The recorded estimate."""
    truth: Pose2 | None


def preview(
    reader: RecordingReader, topics: RecordedTopics, log_ns: int, size: tuple[int, int]
) -> Preview | None:
    """Return what was recorded last up to a time; None if there is nothing.

    Args:
        log_ns: the time [ns since 1970].
        size: height and width of the pictures.
    """
    result = None
    for back in (*SEARCH_BACK_NS, log_ns):
        result = _search(reader, topics, max(log_ns - back, 0), log_ns, size) or result
        if (result and result.picture_log_ns is not None) or log_ns - back <= reader.start_ns:
            break
    return result


def picture_before(
    reader: RecordingReader, topics: RecordedTopics, log_ns: int, count: int, start_ns: int
) -> int:
    """Return the time of the tick with the picture that is ``count`` before the one at a time.

    If there are fewer pictures, it is the start.

    Args:
        log_ns: time of a tick with a picture [ns since 1970].
        count: how many pictures to go back.
        start_ns: time of the first tick.
    """
    names = topics.joint_states, topics.picture
    for back in (*SEARCH_BACK_NS, max(log_ns, 0)):
        result: list[int] = []
        with contextlib.suppress(RecordingError):
            for tick in ticks(reader.messages(names, max(log_ns - back, 0)), topics):
                if tick.log_ns >= log_ns:
                    break
                if topics.picture in tick.newest:
                    result.append(tick.log_ns)
        if len(result) >= count:
            return result[-count]
        if log_ns - back <= start_ns:
            break
    return start_ns


def _search(
    reader: RecordingReader,
    topics: RecordedTopics,
    start_ns: int,
    log_ns: int,
    size: tuple[int, int],
) -> Preview | None:
    newest: dict[str, bytes] = {}
    tick: RecordedTick | None = None
    picture_log_ns = None
    # A damaged recording ends at the damage.
    with contextlib.suppress(RecordingError):
        for item in ticks(reader.messages(topics.names, start_ns), topics):
            if item.log_ns > log_ns:
                break
            tick = item
            newest |= item.newest
            if topics.picture in item.newest:
                picture_log_ns = item.log_ns
    if tick is None:
        return None
    return Preview(
        tick.log_ns,
        picture_log_ns,
        _frame(newest.get(topics.picture), size),
        _decode_estimate(newest.get(topics.amcl_pose)),
        _truth(newest.get(topics.truth)),
    )


def _frame(cdr: bytes | None, size: tuple[int, int]) -> Frame | None:
    if cdr is None:
        return None
    with contextlib.suppress(MessageError, ContentError):
        stamp, image = picture_of(cdr, size)
        return Frame(stamp / 1e9, image)
    return None


def _decode_estimate(cdr: bytes | None) -> Pose2 | None:
    if cdr is None:
        return None
    with contextlib.suppress(MessageError, ContentError):
        return pose_and_covariance_of(cdr)[1]
    return None


def _truth(cdr: bytes | None) -> Pose2 | None:
    if cdr is None:
        return None
    with contextlib.suppress(MessageError, ContentError):
        return truth_of(cdr)[1]
    return None
