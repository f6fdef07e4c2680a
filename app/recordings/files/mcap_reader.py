"""Reads recordings: an MCAP file with ROS 2 messages or a folder of such, finished or not."""

from __future__ import annotations

import heapq
from collections.abc import Collection, Iterator, Mapping
from pathlib import Path

from app.recordings.files.mcap_file import McapFile
from app.recordings.files.recorded import RecordedMessage, RecordingError

__all__ = ["RecordedMessage", "RecordingError", "RecordingReader", "open_recording"]


def open_recording(path: Path) -> RecordingReader:
    """Look into an MCAP file, or into a folder with one or several of the same recording.

    A ``metadata.yaml`` is not needed. A recording that was not finished can be read up to where it
    is whole.

    Raises:
        RecordingError: there is no such file, it is something else, damaged from the beginning, or
            without any messages in CDR; says what it is and what would be valid.
    """
    reader = RecordingReader(path, [McapFile(one) for one in _files(path)])
    if not reader.topics:
        encodings = {name for file in reader.files for name in file.other_encodings}
        holds = f"has messages in {', '.join(sorted(encodings))}" if encodings else "has no message"
        raise RecordingError(f"{path} {holds}; valid are ROS 2 messages in cdr")
    return reader


class RecordingReader:
    """One recording; holds no file open, so that several threads may read at once."""

    def __init__(self, path: Path, files: list[McapFile]) -> None:
        self.path = path
        self.files = files
        self.topics: dict[str, str] = {}
        """Types by topic, of all that can be read as CDR, whether there are messages or not."""
        self.definitions: dict[str, str] = {}
        """Definitions by type, as the file has them (``ros2msg``)."""
        self.metadata: dict[str, dict[str, str]] = {}
        self.attachments: Mapping[str, bytes] = _Attachments(files)
        for file in files:
            self.topics |= file.topics
            self.definitions |= file.definitions
            self.metadata |= file.metadata
        times = [file.times_ns for file in files if file.times_ns]
        self.start_ns = min((start for start, _ in times), default=0)
        """Log time of the first message."""
        self.end_ns = max((end for _, end in times), default=0)
        self.unfinished = any(file.unfinished for file in files)
        """Whether it was cut off: the program was killed, or the disk was full."""
        self.damage = " ".join(file.damage for file in files if file.damage)
        """What is wrong where the readable part of an unfinished file ends."""

    @property
    def duration(self) -> float:
        """From the first to the last message [s]."""
        return (self.end_ns - self.start_ns) / 1e9

    def messages(
        self, topics: Collection[str] | None = None, start_ns: int = 0
    ) -> Iterator[RecordedMessage]:
        """Messages in the order of their log time; of the same time, as they were written.

        Args:
            topics: only these, named as in ``topics``; None for all.
            start_ns: only those logged then or later.

        Raises:
            RecordingError: the file is damaged in the middle or gone.
        """
        streams = [file.messages(topics, start_ns) for file in self.files]
        return heapq.merge(*streams, key=lambda one: one.log_time_ns)


class _Attachments(Mapping[str, bytes]):
    """Attachments by name, read when they are asked for; raises RecordingError on damage."""

    def __init__(self, files: list[McapFile]) -> None:
        self._files = {name: file for file in files for name in file.attachment_names}

    def __getitem__(self, name: str) -> bytes:
        return self._files[name].attachment(name)

    def __iter__(self) -> Iterator[str]:
        return iter(self._files)

    def __len__(self) -> int:
        return len(self._files)


def _files(path: Path) -> list[Path]:
    try:
        if not path.is_dir():
            return [path]
        found = sorted(path.glob("*.mcap"))
        others = sorted(one.name for one in path.iterdir())[:5]
    except (OSError, ValueError) as error:
        raise RecordingError(f"{path} cannot be read: {error}") from error
    if not found:
        holds = f"has {', '.join(others)}" if others else "is empty"
        raise RecordingError(f"{path} {holds}; valid is a folder with an .mcap file")
    return found
