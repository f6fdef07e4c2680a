"""A recording on a disk that fills up: what is whole remains, and everybody reads it."""

import errno
import os
import resource
import subprocess
import sys

import numpy as np
import pytest
from mcap.writer import MCAP0_MAGIC as MAGIC
from recordings import BEGIN_NS, FACTS, TEXT, TICK_NS, metadata_of, text_cdr, write_ticks
from rosbags.highlevel import AnyReader

from app.features.recordings.files.mcap_reader import open_recording
from app.features.recordings.files.recording_file import RecordingFile
from app.features.recordings.library import listed
from app.features.ros.topics import Quality
from app.settings.config import ROOT


def full_at(path, size):
    """Write a recording in a process that may write no more than so many bytes to a file."""
    script = """
import sys
sys.path.insert(0, "tests/helpers")
from pathlib import Path
from recordings import write_ticks
from app.features.recordings.files.recording_file import RecordingFile
file = RecordingFile(Path(sys.argv[1]))
try:
    write_ticks(file, 10**6)
except OSError as error:
    file.abandon()
    print(type(error).__name__, file.size)
"""
    return subprocess.run(
        [sys.executable, "-c", script, str(path)],
        cwd=ROOT,
        stdout=subprocess.PIPE,
        text=True,
        check=True,
        preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (size, size)),
    ).stdout.split()


def test_a_full_disk_leaves_what_was_whole(tmp_path):
    name, size = full_at(tmp_path / "drive", 20_000)
    path = tmp_path / "drive" / "drive_0.mcap"
    assert name == "OSError"
    assert path.stat().st_size == int(size) <= 20_000
    reader = open_recording(path)
    assert reader.unfinished
    assert not reader.damages, "the last whole record is the file's end"
    assert reader.duration > 3
    assert len(list(reader.messages({"/command"}))) * TICK_NS >= reader.duration * 1e9
    facts = metadata_of(path.parent)
    assert facts["duration"]["nanoseconds"] == reader.end_ns - reader.start_ns
    assert facts["message_count"] == len(list(reader.messages()))


@pytest.mark.parametrize("beside", [0, 200_000, 1_500_000])
def test_on_a_full_disk_the_file_is_finished_and_everybody_reads_it(small_disk, beside):
    """Noise cannot be compressed: the disk is full after some seconds."""
    (small_disk / "other").write_bytes(bytes(beside))
    noise = np.random.default_rng(0)
    file = RecordingFile(small_disk / "drive", FACTS)
    tick = 0
    with pytest.raises(OSError, match="No space left"):
        while True:
            now = BEGIN_NS + tick * TICK_NS
            file.write("/noise", TEXT, Quality(), now, now, text_cdr("") + noise.bytes(4000))
            tick += 1
    file.abandon()
    reader = open_recording(file.path)
    assert (reader.unfinished, reader.damages) == (False, [])
    assert tick * TICK_NS / 1e9 - 0.9 < reader.duration <= tick * TICK_NS / 1e9
    (entry,) = listed(small_disk)
    assert (entry.duration_s, entry.unfinished) == (reader.duration, False)
    with AnyReader([file.folder]) as theirs:
        assert theirs.message_count == len(list(reader.messages()))
    assert sorted(path.name for path in file.folder.iterdir()) == ["drive_0.mcap", "metadata.yaml"]


class FaultyDisk:
    """A file whose next write fails."""

    def __init__(self, file):
        self._file, self._works = file, False

    def write(self, data):
        if self._works:
            return self._file.write(data)
        self._works = True
        raise OSError(errno.EIO, os.strerror(errno.EIO))

    def __getattr__(self, name):
        return getattr(self._file, name)


def test_messages_that_are_lost_at_the_end_are_told_and_in_no_index(tmp_path):
    file = RecordingFile(tmp_path / "drive", FACTS)
    write_ticks(file, 210)
    file._stream._file = FaultyDisk(file._stream._file)
    with pytest.raises(OSError, match="Input/output"):
        file.close()
    file.abandon()
    reader = open_recording(file.path)
    assert (reader.unfinished, reader.damages) == (True, [])
    kept = len(list(reader.messages()))
    assert 150 < kept < 210
    assert metadata_of(file.folder)["message_count"] == kept


def test_a_disk_that_is_full_when_only_the_metadata_are_missing_leaves_a_whole_file(
    tmp_path, monkeypatch
):
    file = RecordingFile(tmp_path / "drive", FACTS)
    write_ticks(file, 210)

    def full(path):
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr("app.features.recordings.files.recording_file.atomic_file", full)
    with pytest.raises(OSError, match="No space"):
        file.close()
    file.abandon()
    reader = open_recording(file.path)
    assert (reader.unfinished, reader.damages) == (False, [])
    assert reader.count("/command") == 210
    assert file.path.read_bytes().count(MAGIC) == 2, "at its beginning and at its end"
