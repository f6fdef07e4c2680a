"""Recordings of anybody are read in order of time; what is none is refused in words."""

import random

import numpy as np
import pytest
from mcap.opcode import Opcode
from mcap.writer import CompressionType, IndexType, Writer
from mcap_files import chunks_of, write_foreign
from recordings import BEGIN_NS, TEXT, TICK_NS, make, text_cdr
from rosbags.rosbag2 import StoragePlugin
from rosbags.rosbag2 import Writer as RosbagsWriter

from app.features.recordings.files.mcap_reader import open_recording
from app.features.recordings.files.recorded import RecordingError
from app.features.ros.message_types import definition, typestore


def records_at(data):
    """Opcode and end of each record, up to the end of the data section."""
    found, end, opcode = [], 8, None
    while opcode != Opcode.DATA_END:
        opcode, length = data[end], int.from_bytes(data[end + 1 : end + 9], "little")
        end += 9 + length
        found.append((opcode, end))
    return found


def told(path, *arguments):
    return [(m.log_time_ns, m.topic, m.cdr) for m in open_recording(path).messages(*arguments)]


SHUFFLED = random.Random(3).sample(range(1000), 1000)


@pytest.mark.parametrize(
    "options",
    [
        {},
        {"compression": CompressionType.LZ4},
        {"compression": CompressionType.NONE, "enable_crcs": False},
        {"use_chunking": False},
        {"use_statistics": False, "use_summary_offsets": False},
        {"index_types": IndexType.NONE},
        {"index_types": IndexType.CHUNK},
        {"repeat_schemas": False, "repeat_channels": False, "use_statistics": False},
        {"chunk_size": 200},
        {"chunk_size": 200, "index_types": IndexType.NONE},
    ],
)
def test_all_ways_to_write_a_file_are_read_alike_and_in_order_of_time(tmp_path, options):
    path = write_foreign(tmp_path / "theirs.mcap", SHUFFLED, **options)
    found = told(path)
    expected = [(t, "/a" if n % 2 == 0 else "/b", text_cdr(f"{n}")) for n, t in enumerate(SHUFFLED)]
    assert found == sorted(expected)
    assert told(path, {"/b"}) == [one for one in found if one[1] == "/b"]
    assert told(path, {"/a"}, 700) == [one for one in found if one[1] == "/a" and one[0] >= 700]
    assert told(path, (), 0) == []
    reader = open_recording(path)
    assert (reader.start_ns, reader.end_ns, reader.unfinished) == (0, 999, False)


def test_messages_of_the_same_time_keep_their_order(tmp_path):
    path = write_foreign(tmp_path / "theirs.mcap", [5] * 300, chunk_size=200)
    assert [m.cdr for m in open_recording(path).messages()] == [
        text_cdr(f"{n}") for n in range(300)
    ]


def test_several_files_in_a_folder_are_one_recording(tmp_path):
    write_foreign(tmp_path / "x_0.mcap", range(0, 100, 2))
    write_foreign(tmp_path / "x_1.mcap", range(1, 100, 2))
    (tmp_path / "._x_1.mcap").write_bytes(b"what a Mac leaves beside a file that it copies")
    assert [time for time, _, _ in told(tmp_path)] == list(range(100))


def test_what_rosbags_writes_is_read(tmp_path):
    with RosbagsWriter(tmp_path / "bag", version=9, storage_plugin=StoragePlugin.MCAP) as writer:
        scan = writer.add_connection("/scan", TEXT, typestore=typestore())
        for tick in range(50):
            writer.write(scan, BEGIN_NS + tick * TICK_NS, text_cdr(f"{tick}"))
    reader = open_recording(tmp_path / "bag")
    assert reader.topics == {"/scan": TEXT}
    assert reader.duration == 49 * 0.02
    assert [m.cdr for m in reader.messages()] == [text_cdr(f"{n}") for n in range(50)]


@pytest.mark.parametrize("share", [0.2, 0.5, 0.9, 1.0])
def test_a_file_that_was_cut_off_is_read_up_to_there(tmp_path, share):
    path = make(tmp_path / "drive", ticks=1000)
    whole = told(path)
    last = chunks_of(path)[-1]
    end = last.chunk_start_offset + last.chunk_length
    path.write_bytes(path.read_bytes()[: int(end * share)])
    reader = open_recording(path)
    assert reader.unfinished
    assert bool(reader.damages) is (share < 1)
    part = told(path)
    assert part == whole[: len(part)]
    assert len(part) >= len(whole) * (share - 0.1)


@pytest.mark.slow
@pytest.mark.parametrize(
    "options",
    [
        {"use_chunking": False},
        {"compression": CompressionType.NONE, "chunk_size": 200},
        {"compression": CompressionType.NONE, "chunk_size": 200, "index_types": IndexType.NONE},
    ],
)
def test_wherever_a_file_was_cut_off_all_that_is_whole_is_read(tmp_path, options):
    path = write_foreign(tmp_path / "theirs.mcap", range(12), **options)
    whole, data = told(path), path.read_bytes()
    ends = [data.index(cdr) + len(cdr) for _, _, cdr in whole]
    if "use_chunking" not in options:
        chunks = [part for part in records_at(data) if part[0] == Opcode.CHUNK]
        assert len(chunks) > 2
        ends = [next(end for _, end in chunks if end >= one) for one in ends]
    whole_ends = [end for _, end in records_at(data)]
    for cut in range(ends[0], len(data)):
        path.write_bytes(data[:cut])
        assert told(path) == whole[: sum(end <= cut for end in ends)]
        clean = cut in whole_ends or cut >= whole_ends[-1] - 4  # the data section's checksum
        assert bool(open_recording(path).damages) is not clean


def test_chunks_messages_outside_of_them_and_records_of_a_writer_s_own_may_be_mixed(tmp_path):
    chunked = write_foreign(tmp_path / "chunked.mcap", range(10)).read_bytes()
    loose = write_foreign(tmp_path / "loose.mcap", range(10, 20), use_chunking=False).read_bytes()
    (chunk,) = chunks_of(tmp_path / "chunked.mcap")
    end = chunk.chunk_start_offset + chunk.chunk_length
    own = b"\x80" + (5).to_bytes(8, "little") + b"hello"
    mixed = tmp_path / "mixed.mcap"
    # The first record of the other, its header, is left out with the file's beginning.
    rest = loose[8 + 9 + int.from_bytes(loose[9:17], "little") :]
    mixed.write_bytes(chunked[:end] + own + rest)
    assert [time_ns for time_ns, _, _ in told(mixed)] == list(range(20))
    mixed.write_bytes(chunked[:end] + own)
    reader = open_recording(mixed)
    assert (reader.unfinished, reader.damages) == (True, [])


def test_a_damaged_attachment_of_an_unfinished_file_costs_only_itself(tmp_path):
    path = make(tmp_path / "drive", ticks=60, close=False)
    whole = told(path)
    path.write_bytes(path.read_bytes().replace(b"application/toml", b"application\xfftoml", 1))
    reader = open_recording(path)
    assert (told(path), reader.damages, list(reader.attachments)) == (whole, [], ["settings.toml"])
    with pytest.raises(RecordingError, match="is damaged"):
        reader.attachments["settings.toml"]


def test_a_chunk_that_is_compressed_in_an_unknown_way_is_told(tmp_path):
    path = write_foreign(tmp_path / "theirs.mcap", range(10))
    path.write_bytes(path.read_bytes().replace(b"zstd", b"brot", 1))
    with pytest.raises(RecordingError, match=r"'brot'; valid are zstd, lz4 and none"):
        list(open_recording(path).messages())


def test_a_file_that_ends_in_zeros_as_after_a_power_cut_is_read_up_to_there(tmp_path):
    path = make(tmp_path / "drive", ticks=200, close=False)
    whole = told(path)
    path.write_bytes(path.read_bytes() + bytes(5000))
    reader = open_recording(path)
    assert reader.unfinished
    seconds = (whole[-1][0] - whole[0][0]) / 1e9
    assert reader.damages == [f"what follows {seconds:.1f} s is damaged or cut off"]
    assert told(path) == whole


def test_seeking_reads_only_what_it_needs(tmp_path):
    """By the bytes that are read: a seek into a long file must not go through all of it."""
    noise = np.random.default_rng(1)
    path = tmp_path / "long.mcap"
    with path.open("wb") as stream:
        writer = Writer(stream, chunk_size=10_000)
        writer.start("ros2")
        schema = writer.register_schema(TEXT, "ros2msg", definition(TEXT).encode())
        often = writer.register_channel("/often", "cdr", schema)
        once = writer.register_channel("/once", "cdr", schema)
        for time_ns in range(500):
            writer.add_message(often, time_ns, noise.bytes(1000), time_ns)
        writer.add_message(once, 500, text_cdr("x"), 500)
        writer.finish()
    data = bytearray(path.read_bytes())
    reader = open_recording(path)
    # Everything before is made unreadable: who touched it would notice.
    cut = chunks_of(path)[-5].chunk_start_offset
    data[100:cut] = bytes(cut - 100)
    path.write_bytes(data)
    assert len(list(reader.messages({"/once"}))) == 1
    assert len(list(reader.messages(None, 480))) == 21
    assert len(list(reader.messages())) < 100
    (missing,) = reader.damages
    assert "are damaged" in missing
