"""Files that are damaged or none of ours are refused in words, whatever their bytes."""

import gzip
import sqlite3

import pytest
import zstandard
from mcap_files import chunks_of, write_foreign
from recordings import make

from app.features.recordings.files.mcap_reader import open_recording
from app.features.recordings.files.recorded import RecordingError


def in_order(path):
    return [(m.log_time_ns, m.topic, m.cdr) for m in open_recording(path).messages()]


def hurt(path, chunk, offset):
    """Flip a byte of a chunk."""
    data = bytearray(path.read_bytes())
    data[chunk.chunk_start_offset + offset % chunk.chunk_length] ^= 0xFF
    path.write_bytes(data)


@pytest.fixture
def drive(tmp_path):
    """A recording of 20 s in chunks of 0.4 s: its file, what is in it, and its chunks."""
    path = make(tmp_path / "drive", ticks=1000)
    return path, in_order(path), chunks_of(path)


@pytest.mark.slow
@pytest.mark.parametrize("offset", [1, 5, 8, 9, 17, 25, 33, 40, 60, -5], ids=str)
@pytest.mark.parametrize("finished", [True, False])
@pytest.mark.parametrize("place", [0, 32])
def test_a_damaged_chunk_costs_only_itself_and_is_told_by_time(drive, offset, finished, place):
    path, whole, chunks = drive
    if not finished:
        path.write_bytes(path.read_bytes()[: chunks[-1].chunk_start_offset])
        whole = [one for one in whole if one[0] < chunks[-1].message_start_time]
    hurt(path, chunks[place], offset)
    begin, end = chunks[place].message_start_time, chunks[place].message_end_time
    reader = open_recording(path)
    found = [(m.log_time_ns, m.topic, m.cdr) for m in reader.messages()]
    left = [one for one in whole if not begin <= one[0] <= end]
    assert [one for one in found if not begin <= one[0] <= end] == left
    if len(found) == len(whole):
        return  # nothing depends on that byte
    assert found == left
    (words,) = reader.damages
    if place == 0 and not finished:
        assert words == "the beginning is damaged"
    else:
        start = (begin - reader.start_ns) / 1e9
        expected = (start, 0.4) if finished else (start - 0.02, 0.42)
        assert words == f"{expected[1]:.1f} s from {expected[0]:.1f} s on are damaged"


@pytest.mark.slow
@pytest.mark.parametrize("place", [0, 1, 17, 40])
def test_whatever_bit_of_a_killed_recording_is_wrong_the_other_chunks_are_read(drive, place):
    path, whole, chunks = drive
    data = path.read_bytes()[: chunks[-1].chunk_start_offset]
    chunk = chunks[place]
    whole = [each for each in whole if each[0] < chunks[-1].message_start_time]
    begin, end = chunk.message_start_time, chunk.message_end_time
    for bit in range(place, 8 * chunk.chunk_length, 61):
        wrong = bytearray(data)
        wrong[chunk.chunk_start_offset + bit // 8] ^= 1 << (bit % 8)
        path.write_bytes(wrong)
        left = [each for each in in_order(path) if not begin <= each[0] <= end]
        assert left == [each for each in whole if not begin <= each[0] <= end], bit


def test_schemas_and_channels_stand_outside_of_the_chunks_more_than_once(drive):
    """So any program that goes on behind a damage finds them."""
    path, _, chunks = drive
    data = path.read_bytes()
    for chunk in chunks:
        begin = chunk.chunk_start_offset
        data = data[:begin] + bytes(chunk.chunk_length) + data[begin + chunk.chunk_length :]
    for name in (b"/command", b"/robot_description", b"std_msgs/msg/String"):
        assert data.count(name) >= 6, name


def test_if_nothing_is_left_that_tells_the_topics_the_file_is_damaged(tmp_path):
    path = write_foreign(tmp_path / "drive.mcap", range(0, 10**9, 10**6), chunk_size=1000)
    chunks = chunks_of(path)
    path.write_bytes(path.read_bytes()[: chunks[-1].chunk_start_offset])
    hurt(path, chunks[0], -5)
    with pytest.raises(RecordingError, match=r"is damaged: what tells its topics"):
        open_recording(path)


def test_chunks_that_are_damaged_in_a_row_are_told_as_one(drive):
    path, whole, chunks = drive
    for place in (21, 22, 23, 40):
        hurt(path, chunks[place], -5)
    reader = open_recording(path)
    assert len(list(reader.messages())) < len(whole)
    assert reader.damages == [
        "1.2 s from 8.4 s on are damaged",
        "0.4 s from 16.0 s on are damaged",
    ]


def test_of_a_file_in_which_every_chunk_is_damaged_no_other_reason_is_told(drive):
    path, _, chunks = drive
    path.write_bytes(path.read_bytes()[: chunks[-1].chunk_start_offset])
    for chunk in chunks[:-1]:
        hurt(path, chunk, -5)
    with pytest.raises(RecordingError, match="is damaged: no message in it can be read"):
        open_recording(path)


def test_a_file_full_of_what_looks_like_chunks_is_given_up(tmp_path, drive):
    path, _, chunks = drive
    begin = path.read_bytes()[: chunks[0].chunk_start_offset]
    like = b"\x06" + (200).to_bytes(8, "little") + bytes(16) + (9).to_bytes(8, "little") + bytes(8)
    path.write_bytes(begin + b"\x00" + 100_000 * like)
    with pytest.raises(RecordingError, match="no message in it can be read"):
        open_recording(path)


FOREIGN = {
    "empty.mcap": (b"", "is empty; valid is an MCAP file"),
    "text.mcap": (b"hello, world", "is no MCAP file"),
    "start.mcap": (b"\x89MCAP0\r\n\x01", "ends at once"),
    "magic.mcap": (b"\x89MCAP0\r\n" + b"\x05" * 40, "without its first record"),
    "old.bag": (b"#ROSBAG V2.0\n", "is a ROS 1 bag"),
    "packed.mcap.zstd": (zstandard.compress(b"x"), "compressed as a whole by zstd"),
    "packed.mcap.gz": (gzip.compress(b"x"), "compressed as a whole by gzip"),
    "packed.zip": (b"PK\x03\x04....", "is a zip archive"),
}


@pytest.mark.parametrize("name", FOREIGN)
def test_other_files_are_told_by_what_they_are(tmp_path, name):
    content, words = FOREIGN[name]
    (tmp_path / name).write_bytes(content)
    with pytest.raises(RecordingError, match=words):
        open_recording(tmp_path / name)


def test_an_older_bag_is_told_by_what_it_is(tmp_path):
    base = sqlite3.connect(tmp_path / "bag.db3")
    base.execute("CREATE TABLE messages(id)")
    base.commit()
    base.close()
    with pytest.raises(RecordingError, match="SQLite"):
        open_recording(tmp_path / "bag.db3")
    with pytest.raises(RecordingError, match=r"has bag.db3; valid is a folder with an .mcap"):
        open_recording(tmp_path)


def test_what_is_not_there_or_has_nothing_is_told(tmp_path):
    with pytest.raises(RecordingError, match="No such file"):
        open_recording(tmp_path / "none.mcap")
    with pytest.raises(RecordingError, match="is empty; valid is a folder"):
        (tmp_path / "folder").mkdir()
        open_recording(tmp_path / "folder")
    with pytest.raises(RecordingError, match="has no message"):
        open_recording(make(tmp_path / "drive", ticks=0))
    with pytest.raises(RecordingError, match=r"has messages in json; valid are .* cdr"):
        open_recording(write_foreign(tmp_path / "j.mcap", range(5), encoding="json"))


def test_a_chunk_that_claims_to_be_huge_takes_no_memory(tmp_path):
    # 100 MB of zeros in 10 kB: the frame's own size is another than the chunk's.
    path = make(tmp_path / "drive", ticks=30)
    begin = chunks_of(path)[0].chunk_start_offset
    data = bytearray(path.read_bytes())
    bomb = zstandard.compress(bytes(100_000_000))
    head = begin + 9 + 28 + 8
    data[head : head + 8] = len(bomb).to_bytes(8, "little")
    old = int.from_bytes(path.read_bytes()[head : head + 8], "little")
    data[head + 8 : head + 8 + old] = bomb
    data[begin + 1 : begin + 9] = (28 + 8 + 8 + len(bomb)).to_bytes(8, "little")
    path.write_bytes(data)
    assert open_recording(path).damages == ["the beginning is damaged"]
