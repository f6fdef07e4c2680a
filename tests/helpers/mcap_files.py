"""MCAP files for tests of their reader."""

from mcap.reader import make_reader
from mcap.writer import Writer
from recordings import TEXT, text_cdr

from app.features.ros.message_types import definition


def write_foreign(path, times, *, encoding="cdr", **options):
    """An MCAP file by the mcap package, with messages logged at the times [ns] in this order."""
    with path.open("wb") as stream:
        writer = Writer(stream, **options)
        writer.start("ros2")
        schema = writer.register_schema(TEXT, "ros2msg", definition(TEXT).encode())
        channels = [writer.register_channel(f"/{name}", encoding, schema) for name in "ab"]
        for count, time_ns in enumerate(times):
            writer.add_message(channels[count % 2], time_ns, text_cdr(f"{count}"), time_ns)
        writer.finish()
    return path


def chunks_of(path):
    with path.open("rb") as stream:
        return make_reader(stream).get_summary().chunk_indexes
