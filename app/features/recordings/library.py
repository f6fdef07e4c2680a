"""The recordings in a folder: found by name, described, renamed, deleted and taken in."""

from __future__ import annotations

import filecmp
import re
import shutil
import time
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

import yaml
from mcap.writer import MCAP0_MAGIC as MAGIC

from app.features.recordings.files.mcap_reader import open_recording
from app.features.recordings.files.recorded import RecordingError
from app.features.recordings.files.recording_file import METADATA_FILE
from app.features.recordings.messages import LONGEST_NOTES
from app.features.recordings.replay.ticks import RecordedTopics
from app.features.ros.message_types import from_cdr
from app.files import atomic_file
from app.foreign_files import read_apart
from app.result_files import is_portable
from robot.yaml_file import parse_yaml

NOTES_FILE = "notes.txt"
WRITTEN_S = 10.0
"""An unfinished recording that was written to within this time [s] is being recorded."""
NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9._-]{0,199}")
"""Valid names of recordings: none of them can lead out of the folder."""

LARGEST_METADATA = 1_000_000
"""Largest ``metadata.yaml`` [bytes]; BrickPose writes no larger one."""

UPLOADS = ".new-"
"""Begins the names of folders into which files are uploaded."""
LEFT_S = 86400.0
"""One that is older than this was left when the program was killed [s]."""

_Loader: Any = getattr(yaml, "CSafeLoader", yaml.SafeLoader)


@dataclass(frozen=True, slots=True)
class Listed:
    """One recording."""

    name: str
    file: Path
    size_bytes: int
    duration_s: float | None
    """Duration in ``metadata.yaml``; None if it is unknown."""
    unfinished: bool
    """Whether it is still being recorded, or was cut off."""
    changed: float
    """When it was last written [s since 1970]."""
    notes: str = ""
    """What somebody wrote about it."""


def listed(parent: Path) -> list[Listed]:
    """Return all recordings in a folder, newest first; none if there is no such folder."""
    if not parent.is_dir():
        return []
    result = [_look(folder) for folder in parent.iterdir() if NAME.fullmatch(folder.name)]
    return sorted((each for each in result if each), key=lambda item: -item.changed)


def find(parent: Path, name: str) -> Listed:
    """Return a recording by its name.

    Raises:
        RecordingError: there is no such recording; lists some that exist.
    """
    result = _look(parent / name) if NAME.fullmatch(name) else None
    if result is None:
        some = ", ".join(item.name for item in listed(parent)[:5]) or "none yet"
        raise RecordingError(f"there is no recording {name!r}; valid are {some}")
    return result


def _look(folder: Path) -> Listed | None:
    """Return the recording in a folder; None for a link, which could lead anywhere."""
    path = folder / f"{folder.name}_0.mcap"
    try:
        if folder.is_symlink() or path.is_symlink() or not path.is_file():
            return None
        status = path.stat()
        with path.open("rb") as file:
            file.seek(max(0, status.st_size - len(MAGIC)))
            unfinished = status.st_size <= len(MAGIC) or file.read() != MAGIC
    except OSError:
        return None  # it was deleted meanwhile, or belongs to another user
    duration = _duration(folder / METADATA_FILE)
    if duration is None and not unfinished:
        duration = _duration_in(path, status.st_mtime_ns)
    notes = _notes(folder / NOTES_FILE)
    return Listed(folder.name, path, status.st_size, duration, unfinished, status.st_mtime, notes)


def _duration(path: Path) -> float | None:
    try:
        if path.stat().st_size > LARGEST_METADATA:
            return None
        content = parse_yaml(path.read_bytes(), _Loader)
        nanoseconds = content["rosbag2_bagfile_information"]["duration"]["nanoseconds"]
        return int(nanoseconds) / 1e9
    except (OSError, yaml.YAMLError, LookupError, TypeError, ValueError):
        return None


@lru_cache(maxsize=256)
def _duration_in(path: Path, _changed_ns: int) -> float | None:
    try:
        return open_recording(path).duration
    except (RecordingError, OSError):
        return None


def _notes(path: Path) -> str:
    try:
        with path.open(encoding="utf-8", errors="replace") as file:
            return file.read(LONGEST_NOTES)
    except OSError:
        return ""


def annotate(parent: Path, name: str, notes: str) -> None:
    """Write notes about a recording; an empty text removes them.

    Raises:
        RecordingError: there is no such recording, or nothing can be written there.
    """
    path = find(parent, name).file.parent / NOTES_FILE
    try:
        if notes.strip():
            with atomic_file(path) as new:
                new.write_text(notes, encoding="utf-8")
        else:
            path.unlink(missing_ok=True)
    except OSError as error:
        raise RecordingError(f"{path} cannot be written: {error.strerror}") from error


def rename(parent: Path, name: str, new: str) -> None:
    """Give a finished recording another name: its folder, its file, and what tells of them.

    Raises:
        RecordingError: a name is not valid or taken, the recording is not finished, or nothing can
            be written there; it keeps its name then.
    """
    folder = _finished(parent, name).file.parent
    _require_free(parent, new)
    before, after = folder / f"{name}_0.mcap", folder / f"{new}_0.mcap"
    metadata = folder / METADATA_FILE
    try:
        text = metadata.read_text(encoding="utf-8") if metadata.is_file() else None
        before.rename(after)
        try:
            if text is not None:
                with atomic_file(metadata) as changed:
                    changed.write_text(text.replace(before.name, after.name), encoding="utf-8")
            folder.rename(parent / new)
        except OSError:
            after.rename(before)  # a folder and a file of different names are no recording
            raise
    except (OSError, ValueError) as error:  # ValueError: the metadata are no UTF-8
        why = getattr(error, "strerror", None) or error
        raise RecordingError(f"{folder} cannot be renamed: {why}") from error


def delete(parent: Path, name: str) -> None:
    """Delete a finished recording.

    Raises:
        RecordingError: there is no such recording, it is not finished, or cannot be deleted.
    """
    folder = _finished(parent, name).file.parent
    try:
        shutil.rmtree(folder)
    except OSError as error:
        raise RecordingError(f"{folder} cannot be deleted: {error.strerror}") from error


def add(parent: Path, name: str, file: Path) -> None:
    """Take a recording into a folder; ``file`` is moved there, unless it is there by that name.

    Raises:
        RecordingError: it is none, or its name is not valid or taken.
        CostlyFileError: it takes too much time or memory.
        OSError: it cannot be moved.
    """
    if _is_there(parent / name / f"{name}_0.mcap", file):
        return
    _require_free(parent, name)
    read_apart(open_recording, file)
    whole = file.parent / name
    whole.mkdir()
    file.rename(whole / f"{name}_0.mcap")
    whole.rename(parent / name)


def _is_there(known: Path, file: Path) -> bool:
    return known.is_file() and filecmp.cmp(known, file, shallow=False)


def remove_left(parent: Path) -> None:
    """Remove what is left of uploads that were cut off."""
    for folder in parent.glob(f"{UPLOADS}*"):
        if time.time() - folder.stat().st_mtime > LEFT_S:
            shutil.rmtree(folder, ignore_errors=True)


def _require_free(parent: Path, name: str) -> None:
    if not NAME.fullmatch(name):
        raise RecordingError(f"{name!r} is no name; valid are 200 letters, digits, ., - and _")
    if not is_portable(name):
        raise RecordingError(f"Windows takes no file of the name {name}; choose another name")
    if (parent / name).exists():
        raise RecordingError(f"there is a recording {name} already; choose another name")


def _finished(parent: Path, name: str) -> Listed:
    result = find(parent, name)
    if result.unfinished and time.time() - result.changed < WRITTEN_S:
        raise RecordingError(f"{name} is being recorded; stop it first")
    return result


def picture_in(item: Listed) -> bytes | None:
    """Return a picture of a recording, from its middle on, as JPEG; None if there is none.

    Raises:
        RecordingError: the file is damaged.
    """
    reader = open_recording(item.file)
    topic = RecordedTopics.of(reader.topics).picture
    middle = (reader.start_ns + reader.end_ns) // 2
    for start_ns in (middle, 0):
        for message in reader.messages([topic], start_ns):
            return bytes(from_cdr(message.cdr, "sensor_msgs/msg/CompressedImage").data)
    return None
