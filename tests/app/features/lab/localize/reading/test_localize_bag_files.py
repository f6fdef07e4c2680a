"""Bags as other recorders leave them: compressed, killed, renamed, with other metadata."""

import shutil
import sqlite3
from contextlib import closing

import numpy as np
import pytest
import yaml
import zstandard
from mcap.writer import CompressionType, Writer
from paired_bags import paired
from rosbags.rosbag2 import CompressionFormat, CompressionMode, StoragePlugin
from rosbags.rosbag2 import Writer as Ros2Writer

from app.features.lab.localize.reading.bag import Bag
from app.features.lab.localize.reading.sources import BagError
from app.features.recordings.files.recorded import RecordingError
from benchmarks.lasers.laser_bags import LaserBag
from robot.geometry import Pose2

COUNT = 30


def fill(bag, start=0.0, count=COUNT):
    for tick in range(count):
        stamp = 1000.0 + start + 0.1 * tick
        bag.odometry(stamp, Pose2(0.1 * tick))
        bag.scan(stamp, [1.0, 1.0 + 0.01 * tick], first=0.0, step=0.1)


def write(path, kind, start=0.0):
    with LaserBag(path, kind) as bag:
        fill(bag, start)
    return path


def compressed(path, kind, mode):
    bag = LaserBag(path, kind)
    bag._writer = Ros2Writer(path, version=9, storage_plugin=StoragePlugin[kind.upper()])
    bag._writer.set_compression(CompressionMode[mode.upper()], CompressionFormat.ZSTD)
    with bag:
        fill(bag)
    return path


def require_whole(path, count=COUNT):
    found, left_out, remarks = paired(path)
    assert len(found) == count
    assert left_out.lines() == remarks == []
    assert found[-1].scan.ranges[1] == pytest.approx(1.0 + 0.01 * (COUNT - 1))


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["sqlite3", "mcap"])
@pytest.mark.parametrize("mode", ["message", "file"])
@pytest.mark.parametrize("given", ["folder", "folder without metadata", "file"])
def test_a_compressed_bag_is_read_in_every_form(tmp_path, kind, mode, given):
    path = compressed(tmp_path / "bag", kind, mode)
    if given != "folder":
        (path / "metadata.yaml").unlink()
    require_whole(next(path.iterdir()) if given == "file" else path)


@pytest.mark.parametrize("kind", ["sqlite3", "mcap"])
def test_a_file_that_zstd_made_is_read(tmp_path, kind):
    (whole,) = (item for item in write(tmp_path / "bag", kind).iterdir() if item.suffix != ".yaml")
    packed = tmp_path / f"{whole.name}.zstd"
    packed.write_bytes(zstandard.compress(whole.read_bytes()))
    require_whole(packed)


def test_of_a_compressed_file_that_is_cut_off_the_beginning_is_read_and_the_damage_told(tmp_path):
    noise = np.random.default_rng(0).uniform(1, 9, (COUNT, 10_000))
    with LaserBag(tmp_path / "bag", "mcap") as bag:
        for tick, ranges in enumerate(noise):
            bag.scan(1000 + 0.1 * tick, ranges, first=0.0, step=1e-4)
    content = (tmp_path / "bag" / "bag.mcap").read_bytes()
    packed = tmp_path / "bag.mcap.zstd"
    writer = zstandard.ZstdCompressor().compressobj()
    parts = [writer.compress(content), writer.flush(zstandard.COMPRESSOBJ_FLUSH_BLOCK)]
    packed.write_bytes(b"".join(parts) + b"damage that is no block of zstd")
    with Bag(packed) as bag:
        assert len(list(bag.messages(["/scan"]))) > COUNT / 2
        assert "bag.mcap.zstd is damaged or cut off" in bag.damages[0]
    packed.write_bytes(b"no zstd at all")
    with pytest.raises(BagError, match="cannot be decompressed"):
        Bag(packed)


def test_a_message_that_is_no_longer_what_it_was_is_left_out_and_told(tmp_path):
    with LaserBag(tmp_path / "bag", "sqlite3") as bag:
        fill(bag)
    with closing(sqlite3.connect(tmp_path / "bag" / "bag.db3")) as database, database:
        database.execute("UPDATE messages SET data = x'0001000001' WHERE id IN (8, 20)")
    with Bag(tmp_path / "bag") as bag:
        assert len(list(bag.messages(["/scan"]))) == COUNT - 2
        assert "2 messages on /scan cannot be decoded" in bag.damages[0]


@pytest.mark.parametrize("chunked", [True, False])
def test_messages_of_ros_1_in_mcap_are_read(tmp_path, chunked):
    with LaserBag(tmp_path / "drive.bag", "ros1") as bag:
        fill(bag)
    path = tmp_path / "drive.mcap"
    with Bag(tmp_path / "drive.bag") as bag, path.open("wb") as stream:
        writer = Writer(stream, compression=CompressionType.ZSTD, use_chunking=chunked)
        writer.start("ros1")
        channels = {}
        for raw in bag._sources[0].messages(["/odom", "/scan"], as_written=False):
            if raw.topic not in channels:
                name = raw.type.replace("/msg/", "/")
                schema = writer.register_schema(name, "ros1msg", b"")
                channels[raw.topic] = writer.register_channel(raw.topic, "ros1", schema)
            writer.add_message(channels[raw.topic], raw.log_time_ns, raw.data, raw.log_time_ns)
        writer.finish()
    require_whole(path)


def test_messages_in_another_encoding_are_named(tmp_path):
    path = tmp_path / "drive.mcap"
    with path.open("wb") as stream:
        writer = Writer(stream)
        writer.start()
        channel = writer.register_channel("/a", "protobuf", 0)
        writer.add_message(channel, 1, b"1", 1)
        writer.finish()
    words = "has messages in protobuf; valid are ROS 2 messages in cdr or ROS 1 messages in ros1"
    with pytest.raises(RecordingError, match=words):
        Bag(path)


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["sqlite3", "mcap"])
@pytest.mark.parametrize("change", ["qos", "counts", "names", "broken", "absent", "mode"])
def test_the_storage_is_believed_whatever_metadata_says(tmp_path, kind, change):
    metadata = write(tmp_path / "bag", kind) / "metadata.yaml"
    content = yaml.safe_load(metadata.read_text())
    information = content["rosbag2_bagfile_information"]
    topics = information["topics_with_message_count"]
    match change:
        case "qos":
            for topic in topics:
                topic["topic_metadata"]["offered_qos_profiles"] = "- history: 1\n  depth: 7"
        case "counts":
            for topic in topics:
                topic["message_count"] = 0
        case "names":
            topics[0]["topic_metadata"]["name"] = "/elsewhere"
        case "mode":
            information["compression_mode"] = "MESSAGE"
            information["compression_format"] = "zstd"
    metadata.write_text("{broken" if change == "broken" else yaml.safe_dump(content))
    if change == "absent":
        metadata.unlink()
    require_whole(tmp_path / "bag")


@pytest.mark.parametrize("kind", ["sqlite3", "mcap"])
def test_a_file_that_metadata_does_not_list_is_not_read(tmp_path, kind):
    path = write(tmp_path / "bag", kind)
    (other,) = (item for item in write(tmp_path / "other", kind, 1.5).iterdir() if "db3" in
                item.name or "mcap" in item.name)  # fmt: skip
    shutil.copy(other, path)
    require_whole(path)


def test_a_bag_whose_file_was_renamed_is_read_and_told(tmp_path):
    path = write(tmp_path / "bag", "sqlite3")
    (path / "bag.db3").rename(path / "monday.db3")
    require_whole(path)
    with Bag(path) as bag:
        assert bag.damages == ["metadata.yaml lists bag.db3; monday.db3 is there"]


def killed(folder, checkpoint):
    """A database as its recorder leaves it when it is killed."""
    whole = write(folder / "whole", "sqlite3") / "whole.db3"
    made = folder / "made" / "bag.db3"
    made.parent.mkdir()
    database = sqlite3.connect(made, isolation_level=None)
    database.execute("PRAGMA journal_mode=WAL")
    database.execute("PRAGMA wal_autocheckpoint=0")
    database.execute("ATTACH ? AS whole", (str(whole),))
    for table, rows in (("topics", "1=1"), ("messages", "id <= 30"), ("messages", "id > 30")):
        if rows != "id > 30":
            database.execute(f"CREATE TABLE {table} AS SELECT * FROM whole.{table} WHERE {rows}")
        else:
            if checkpoint:
                database.execute("PRAGMA wal_checkpoint")
            database.execute(f"INSERT INTO {table} SELECT * FROM whole.{table} WHERE {rows}")
    bag = folder / "bag"
    shutil.copytree(made.parent, bag)
    database.close()
    return bag


@pytest.mark.slow
@pytest.mark.parametrize("checkpoint", [True, False])
@pytest.mark.parametrize("shared", [True, False])
def test_what_lies_beside_a_killed_recorders_database_is_read(tmp_path, checkpoint, shared):
    bag = killed(tmp_path, checkpoint)
    if not shared:
        (bag / "bag.db3-shm").unlink()
    before = {item.name: item.read_bytes() for item in bag.iterdir()}
    require_whole(bag)
    require_whole(bag / "bag.db3")
    assert {item.name: item.read_bytes() for item in bag.iterdir()} == before


def test_a_database_whose_messages_lie_in_a_missing_file_says_which(tmp_path):
    bag = killed(tmp_path, checkpoint=False)
    (bag / "bag.db3-wal").unlink()
    with pytest.raises(BagError, match=r"they are in bag.db3-wal, which is missing"):
        Bag(bag)


def test_a_database_that_is_no_bag_is_named(tmp_path):
    with closing(sqlite3.connect(tmp_path / "notes.db3")) as database, database:
        database.execute("CREATE TABLE notes (id INTEGER)")
    with pytest.raises(BagError, match="no tables topics and messages"):
        Bag(tmp_path / "notes.db3")


def test_a_ros_1_bag_that_was_not_finished_has_its_cure(tmp_path):
    (tmp_path / "drive.bag.active").write_bytes(b"#ROSBAG V2.0\n")
    with pytest.raises(BagError, match=r"`rosbag reindex drive.bag.active` .* to drive.bag"):
        Bag(tmp_path / "drive.bag.active")


@pytest.mark.parametrize("kind", ["sqlite3", "mcap"])
@pytest.mark.parametrize(
    ("names", "pause"),
    [(("monday", "tuesday"), 5.0), (("run_0", "run_1"), 7200.0), (("run_0", "run_1"), -3.0)],
)
def test_two_drives_in_a_folder_are_not_followed_as_one(tmp_path, kind, names, pause):
    folder = gathered(tmp_path, kind, names, pause)
    with pytest.raises(BagError, match=f"holds several drives.*{names[0]}.*{names[1]}"):
        Bag(folder)


@pytest.mark.parametrize("kind", ["sqlite3", "mcap"])
def test_the_parts_of_one_recording_are_read_in_their_order(tmp_path, kind):
    names = [f"run_{number}" for number in range(12)]
    folder = gathered(tmp_path, kind, names, 0.1)
    for item in list(folder.iterdir()):
        (folder / f"._{item.name}").write_bytes(b"what a Mac leaves beside a file that it copies")
    with Bag(folder) as bag:
        logged = [message.logged for message in bag.messages(["/scan"], as_written=True)]
    assert logged == sorted(logged)
    assert len(logged) == COUNT * len(names)


def gathered(tmp_path, kind, names, pause):
    """A folder without metadata, with one file of each name."""
    folder = tmp_path / "folder"
    folder.mkdir()
    start = 0.0
    for name in names:
        with LaserBag(tmp_path / name, kind) as bag:
            fill(bag, start)
        (file,) = (item for item in (tmp_path / name).iterdir() if item.name != "metadata.yaml")
        shutil.copy(file, folder)
        start += 0.1 * (COUNT - 1) + pause
    return folder
