"""``brickpose record``: records a running program into a file on this machine."""

from __future__ import annotations

import struct
import sys
import time
from collections.abc import Callable, Sequence
from contextlib import closing, suppress
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path

from app.console import say
from app.features.recordings.attachments import Contents
from app.features.recordings.files.recording_file import RecordingFile, free_folder
from app.features.recordings.periods import recorded_every
from app.features.recordings.remote_robot import Received, RemoteRobot, RemoteRobotError
from app.features.ros.message_types import MessageError, message_class
from app.features.ros.topics import Quality, topics
from app.interruption import Interrupted, deferred
from app.settings.groups import RecordingSettings
from robot.settings import SettingError

LOOK_S = 0.2
"""Interval of checking whether to end, while nothing comes [s]."""

PROGRESS_S = 0.5


@dataclass(frozen=True, slots=True)
class Kind:
    """How a topic is recorded."""

    name: str
    """Its name in the recording; without the robot's namespace if it is a topic of BrickPose."""
    type: str
    quality: Quality
    period: float
    """Least time between two messages [s]."""


Kinds = dict[str, Kind]
"""By the topic's name at the robot."""


def record(
    address: str, out: Path, seconds: float | None = None, names: Sequence[str] = ()
) -> Path:
    """Record until Ctrl-C or for a time; return the recording's folder.

    Args:
        out: the folder in which the recording's folder is made.
        seconds: how long to record [s]; None means until Ctrl-C.
        names: the topics' names; empty for all topics.

    Raises:
        RemoteRobotError: the robot does not answer, or the connection is lost; what was received
            before is kept.
        SettingError: the address is invalid, or a topic does not exist; lists those that do.
        OSError: the file cannot be written; what was written before remains.
    """
    with closing(RemoteRobot(address)) as robot:
        kinds = _chosen(robot.topics(), names)
        contents = robot.contents()
        folder = _new_folder(out)
        # A signal raises nothing: the file must not be left in the middle of a message.
        with suppress(Interrupted), deferred() as asked:
            _record_to(folder, robot, contents, kinds, _Until(asked, seconds))
    return folder


def _record_to(
    folder: Path, robot: RemoteRobot, contents: Contents, kinds: Kinds, until: _Until
) -> None:
    """Record to a new folder until it is over."""
    file = RecordingFile(folder, contents.facts)
    try:
        for attachment in contents.attachments:
            file.attach(attachment.name, attachment.data, attachment.media_type)
        say(f"Recording {robot.place} to {folder} (Ctrl-C ends it)")
        _record(robot, file, kinds, until)
    except RemoteRobotError as error:
        file.close()
        raise RemoteRobotError(f"{error}; {_kept(file)}") from error
    except BaseException:
        file.abandon()
        raise
    file.close()
    say(f"{_kept(file)[0].upper()}{_kept(file)[1:]}")


def _record(robot: RemoteRobot, file: RecordingFile, kinds: Kinds, until: _Until) -> None:
    for name, kind in kinds.items():
        robot.follow(name, kind.type, kind.period)
    progress = _Progress(file)
    while not until.over():
        received = robot.receive(LOOK_S)
        if received is not None and received.topic in kinds:
            kind = kinds[received.topic]
            current, when = received.log_time_ns, stamp_ns(received, kind.type)
            file.write(kind.name, kind.type, kind.quality, current, when, received.cdr)
        progress.show()
    progress.end()


def _chosen(types: dict[str, str], names: Sequence[str]) -> Kinds:
    """Return the topics to record: the requested ones (all by default) of known types."""
    wanted = [name if name.startswith("/") else f"/{name}" for name in names]
    for name in wanted:
        if name not in types:
            raise SettingError(f"{name} is no topic there; valid are {', '.join(types)}")
    kinds: Kinds = {}
    for name in wanted or types:
        try:
            message_class(types[name])
        except MessageError as error:
            say(f"{name} is not recorded: {error}")
            continue
        kinds[name] = _kind(name, types[name])
    return kinds


def _kind(name: str, type_name: str) -> Kind:
    for ours in topics():
        if ours.type == type_name and name.endswith(f"/{ours.name}"):
            period = recorded_every(ours, RecordingSettings())
            return Kind(f"/{ours.name}", type_name, ours.quality, period)
    return Kind(name, type_name, Quality(), 0.0)


def stamp_ns(received: Received, type_name: str) -> int:
    """Return the time of a message's content: its header's stamp, or when it was sent."""
    fields = message_class(type_name).__annotations__
    first = next(iter(fields.values()), "")
    if str(first).endswith("std_msgs__msg__Header") and len(received.cdr) >= 12:
        sec, nanosec = struct.unpack_from("<iI", received.cdr, 4)
        if sec > 0:
            return int(sec * 1_000_000_000 + nanosec)
    return received.log_time_ns


def _new_folder(out: Path) -> Path:
    try:
        out.mkdir(parents=True, exist_ok=True)
        return free_folder(out, f"brickpose_{datetime.now():%Y_%m_%d-%H_%M_%S}")
    except OSError as error:
        raise type(error)(
            f"nothing can be recorded to {out}: {error.strerror}; valid is a folder"
        ) from error


def _kept(file: RecordingFile) -> str:
    return f"{file.duration:.1f} s, {file.size / 1e6:.1f} MB are in {file.folder}"


class _Until:
    def __init__(self, asked: Callable[[], bool], seconds: float | None) -> None:
        self._asked = asked
        self._end = None if seconds is None else time.monotonic() + seconds

    def over(self) -> bool:
        return self._asked() or (self._end is not None and time.monotonic() >= self._end)


class _Progress:
    """Shows on a terminal how much is recorded."""

    def __init__(self, file: RecordingFile) -> None:
        self._file = file
        self._next = time.monotonic()
        self._shown = sys.stderr.isatty()

    def show(self) -> None:
        clock = time.monotonic()
        if self._shown and clock >= self._next:
            self._next = clock + PROGRESS_S
            given = f"\r{self._file.duration:7.1f} s  {self._file.size / 1e6:8.1f} MB"
            sys.stderr.write(given)
            sys.stderr.flush()

    def end(self) -> None:
        if self._shown:
            sys.stderr.write("\n")
