"""A recording on the disk is what ROS 2's tools expect, at any moment of its making."""

import signal
import subprocess
import sys

import pytest
from mcap.reader import NonSeekingReader
from recordings import BEGIN_NS, FACTS, TEXT, TICK_NS, make, metadata_of, text_cdr, write_ticks
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

from app.features.recordings.files.mcap_reader import open_recording
from app.features.recordings.files.recorded import RecordingError
from app.features.recordings.files.recording_file import RecordingFile, free_folder
from app.features.ros.message_types import MessageError, typestore
from app.features.ros.topics import LATCHED, Quality
from app.settings.config import ROOT


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
sys.path.insert(0, "tests/helpers")
from pathlib import Path
from recordings import write_ticks
from app.features.recordings.files.recording_file import RecordingFile
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
