"""Files that are damaged or none of ours are refused in words, whatever their bytes."""

import gzip
import sqlite3

import pytest
import zstandard
from mcap_files import chunks_of, write_foreign
from recordings import make

from app.recordings.files.mcap_reader import open_recording
from app.recordings.files.recorded import RecordingError


def test_damage_in_the_middle_of_a_finished_file_is_told_when_it_is_met(tmp_path):
    path = make(tmp_path / "drive", ticks=1000)
    data = bytearray(path.read_bytes())
    chunk = chunks_of(path)[20]
    data[chunk.chunk_start_offset + chunk.chunk_length - 5] ^= 0xFF
    path.write_bytes(data)
    reader = open_recording(path)
    with pytest.raises(RecordingError, match=r"drive_0.mcap is damaged: .*valid is"):
        list(reader.messages())


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
    with pytest.raises(RecordingError, match="has no message"):
        open_recording(path)
