"""A recording on the disk is what ROS 2's tools expect, at any moment of its making."""

import errno
import os
import resource
import signal
import subprocess
import sys

import numpy as np
import pytest
import yaml
from mcap.reader import NonSeekingReader
from mcap.writer import MCAP0_MAGIC as MAGIC
from recordings import BEGIN_NS, FACTS, TEXT, TICK_NS, make, text_cdr, write_ticks
from rosbags.highlevel import AnyReader
from rosbags.interfaces import (
    Qos,
    QosDurability,
    QosHistory,
    QosLiveliness,
    QosReliability,
    QosTime,
)
from rosbags.rosbag2 import StoragePlugin, Writer

from app.recordings.files.mcap_reader import open_recording
from app.recordings.files.recorded import RecordingError
from app.recordings.files.recording_file import METADATA_FILE, RecordingFile, free_folder
from app.recordings.routes import listed
from app.ros2.message_types import MessageError, typestore
from app.ros2.topic import LATCHED, Quality
from app.settings.config import ROOT


def metadata_of(folder):
    return yaml.safe_load((folder / METADATA_FILE).read_text(encoding="utf-8"))[
        "rosbag2_bagfile_information"
    ]


def in_messages(reader):
    return [(m.topic, m.log_time_ns, m.cdr) for m in reader.messages()]


def test_rosbags_reads_the_folder_as_a_rosbag2(tmp_path):
    make(tmp_path / "drive", ticks=120)
    with AnyReader([tmp_path / "drive"]) as reader:
        assert {c.topic: c.msgtype for c in reader.connections} == {
            "/command": TEXT,
            "/robot_description": TEXT,
        }
        found = [(c.topic, t, reader.deserialize(d, c.msgtype)) for c, t, d in reader.messages()]
        assert reader.message_count == len(found) == 122
        assert reader.duration == 119 * TICK_NS + 1  # rosbags' end lies behind the last message
    assert [m.data for topic, _, m in found if topic == "/command"] == [
        f"tick {n}" for n in range(120)
    ]
    assert [t for topic, t, _ in found if topic == "/robot_description"] == [
        BEGIN_NS,
        BEGIN_NS + 100 * TICK_NS,
    ]


def test_rosbags_reads_the_bare_file_too(tmp_path):
    with AnyReader([make(tmp_path / "drive", ticks=30)]) as reader:
        assert reader.message_count == 31


def test_the_metadata_is_what_the_writer_of_rosbags_would_have_written(tmp_path):
    path = make(tmp_path / "drive", ticks=120)
    forever = QosTime(9223372036, 854775807)
    with Writer(tmp_path / "theirs", version=9, storage_plugin=StoragePlugin.MCAP) as writer:
        writer.set_custom_data("robot", FACTS["robot"])
        known = {}
        for message in open_recording(path).messages():
            if message.topic not in known:
                latched = message.topic == "/robot_description"
                durability = QosDurability.TRANSIENT_LOCAL if latched else QosDurability.VOLATILE
                quality = Qos(
                    QosHistory.KEEP_LAST, 1 if latched else 10, QosReliability.RELIABLE, durability,
                    forever, forever, QosLiveliness.AUTOMATIC, forever, False,
                )  # fmt: skip
                known[message.topic] = writer.add_connection(
                    message.topic,
                    message.type,
                    typestore=typestore(),
                    offered_qos_profiles=[quality],
                )
            writer.write(known[message.topic], message.log_time_ns, message.cdr)
    ours, theirs = metadata_of(path.parent), metadata_of(tmp_path / "theirs")
    assert ours.pop("custom_data") == FACTS
    assert theirs.pop("custom_data") == {"robot": FACTS["robot"]}
    assert (ours.pop("ros_distro"), theirs.pop("ros_distro")) == ("jazzy", "rosbags")
    for one in (ours, theirs):
        assert one.pop("relative_file_paths") == [one["files"][0].pop("path")]
    assert ours == theirs


def test_while_it_is_written_all_but_the_last_half_second_can_be_read(tmp_path):
    file = RecordingFile(tmp_path / "drive", FACTS)
    for tick in range(0, 1000, 10):
        write_ticks(file, 10, first=tick)
        now = (tick + 9) * TICK_NS
        if now > 0.5e9:
            reader = open_recording(file.path)
            assert reader.unfinished
            assert reader.end_ns >= BEGIN_NS + now - 500_000_000
    file.close()
    assert not open_recording(file.path).unfinished


def test_metadata_is_there_from_the_start_and_follows(tmp_path):
    file = RecordingFile(tmp_path / "drive", FACTS)
    assert metadata_of(file.folder)["message_count"] == 0
    write_ticks(file, 500)
    assert metadata_of(file.folder)["message_count"] >= 200
    file.abandon()
    assert len(metadata_of(file.folder)["topics_with_message_count"]) == 2


def test_an_existing_folder_is_not_written_over(tmp_path):
    path = make(tmp_path / "drive")
    before = path.read_bytes()
    with pytest.raises(RecordingError, match="valid is a new folder"):
        RecordingFile(tmp_path / "drive")
    assert path.read_bytes() == before
    assert free_folder(tmp_path, "drive") == tmp_path / "drive-2"
    assert free_folder(tmp_path, "other") == tmp_path / "other"


def test_an_unknown_type_is_refused_and_the_rest_goes_on(tmp_path):
    file = RecordingFile(tmp_path / "drive")
    with pytest.raises(MessageError, match="unknown type"):
        file.write("/odd", "odd_msgs/msg/Odd", Quality(), BEGIN_NS, BEGIN_NS, b"")
    write_ticks(file, 10)
    file.close()
    assert len(in_messages(open_recording(file.path))) == 11


def test_facts_attachments_and_what_is_noted_later_are_kept(tmp_path):
    file = RecordingFile(tmp_path / "drive", FACTS)
    write_ticks(file, 60)
    file.attach("map/square.svg", b"<svg/>", "image/svg+xml", BEGIN_NS)
    file.note("end", {"lost": "3"})
    file.close()
    reader = open_recording(tmp_path / "drive")
    assert reader.metadata["brickpose"] == FACTS
    assert reader.metadata["end"] == {"lost": "3"}
    assert dict(reader.attachments) == {"map/square.svg": b"<svg/>"}
    with file.path.open("rb") as stream:
        assert [one.data for one in NonSeekingReader(stream).iter_attachments()] == [b"<svg/>"]


def test_qualities_are_those_of_the_topics(tmp_path):
    file = RecordingFile(tmp_path / "drive")
    file.write("/map", TEXT, LATCHED, BEGIN_NS, BEGIN_NS, text_cdr("map"))
    file.write("/scan", TEXT, Quality(reliable=False, depth=5), BEGIN_NS, BEGIN_NS, text_cdr("s"))
    file.close()
    with AnyReader([file.folder]) as reader:
        found = {c.topic: c.ext.offered_qos_profiles[0] for c in reader.connections}
    assert found["/map"].durability == QosDurability.TRANSIENT_LOCAL
    assert found["/map"].depth == 1
    assert found["/scan"].reliability == QosReliability.BEST_EFFORT
    assert found["/scan"].depth == 5


ENDLESS = """
import sys
sys.path.insert(0, "tests")
from pathlib import Path
from recordings import write_ticks
from app.recordings.files.recording_file import RecordingFile
file = RecordingFile(Path(sys.argv[1]))
for first in range(0, 10**9, 10):
    write_ticks(file, 10, first)
    print(first + 10, flush=True)
"""


def test_after_kill_9_all_but_the_last_second_can_be_read(tmp_path):
    command = [sys.executable, "-c", ENDLESS, str(tmp_path / "drive")]
    with subprocess.Popen(command, cwd=ROOT, stdout=subprocess.PIPE, text=True) as writing:
        for line in writing.stdout:
            if int(line) >= 400:
                writing.send_signal(signal.SIGKILL)
                break
        rest = writing.stdout.readlines()
    written = int(rest[-1]) if rest and rest[-1].endswith("\n") else 400
    path = tmp_path / "drive" / "drive_0.mcap"
    reader = open_recording(path)
    assert reader.unfinished
    commands = list(reader.messages({"/command"}))
    assert len(commands) * TICK_NS >= written * TICK_NS - 1_000_000_000
    assert [m.cdr for m in commands] == [text_cdr(f"tick {n}") for n in range(len(commands))]
    assert metadata_of(path.parent)["storage_identifier"] == "mcap"


def test_another_reader_gets_the_same_from_an_unfinished_file(tmp_path):
    path = make(tmp_path / "drive", ticks=500, close=False)
    with path.open("rb") as stream:
        found = []
        try:
            for _, channel, message in NonSeekingReader(stream).iter_messages(log_time_order=False):
                found.append((channel.topic, message.log_time, message.data))
        except Exception as error:
            assert type(error).__name__ == "EndOfFile"
    assert found == in_messages(open_recording(path))


def full_at(path, size):
    """Write a recording in a process that may write no more than so many bytes to a file."""
    script = """
import sys
sys.path.insert(0, "tests")
from pathlib import Path
from recordings import write_ticks
from app.recordings.files.recording_file import RecordingFile
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


@pytest.fixture
def small_disk(tmp_path):
    """A folder on a disk of 3 MB."""
    folder = tmp_path / "disk"
    folder.mkdir()
    mounted = ["mount", "-t", "tmpfs", "-o", "size=3M", "tmpfs", str(folder)]
    if subprocess.run(mounted, capture_output=True, check=False).returncode:
        pytest.skip("only root may mount a small disk")
    yield folder
    subprocess.run(["umount", str(folder)], check=True)


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

    monkeypatch.setattr("app.recordings.files.recording_file.atomic_file", full)
    with pytest.raises(OSError, match="No space"):
        file.close()
    file.abandon()
    reader = open_recording(file.path)
    assert (reader.unfinished, reader.damages) == (False, [])
    assert reader.count("/command") == 210
    assert file.path.read_bytes().count(MAGIC) == 2, "at its beginning and at its end"
