"""``brickpose localize`` on a damaged MCAP file: what is whole is used, and the rest is told."""

import json

import pytest
from laser_office import drive, write_bag, write_map
from mcap.reader import make_reader
from mcap.writer import Writer
from mcap_files import chunks_of

from app.command_line import main

pytestmark = pytest.mark.slow


@pytest.mark.parametrize("finished", [True, False])
def test_of_a_damaged_mcap_file_all_else_is_used_and_the_damage_is_told(tmp_path, capsys, finished):
    (whole,) = write_bag(tmp_path / "office").glob("*.mcap")
    with whole.open("rb") as stream, (tmp_path / "hurt.mcap").open("wb") as hurt:
        writer = Writer(hurt, chunk_size=20_000)
        writer.start("ros2")
        channels = {}
        for schema, channel, message in make_reader(stream).iter_messages():
            if channel.id not in channels:
                kind = writer.register_schema(schema.name, schema.encoding, schema.data)
                channels[channel.id] = writer.register_channel(channel.topic, "cdr", kind)
            time_ns = message.log_time
            writer.add_message(channels[channel.id], time_ns, message.data, time_ns)
        writer.finish()
    path = tmp_path / "hurt.mcap"
    chunks = chunks_of(path)
    data = bytearray(path.read_bytes())
    middle = chunks[len(chunks) // 2]
    data[middle.chunk_start_offset + middle.chunk_length - 5] ^= 0xFF
    path.write_bytes(data if finished else data[: chunks[-1].chunk_start_offset + 30])
    options = ["--map", str(write_map(tmp_path)), "--out", str(tmp_path / "out")]
    assert main(["localize", str(path), *options]) == 0
    assert "on are damaged" in capsys.readouterr().out
    found = json.loads((tmp_path / "out" / "results.json").read_text())
    assert found["scans"]["used"] > 0.8 * len(drive())
