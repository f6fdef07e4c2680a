"""Recordings made by hand."""

from app.recording.recording_file import RecordingFile
from app.ros2.message_types import new, to_cdr
from app.ros2.topic import LATCHED, Quality

BEGIN_NS = 1_800_000_000_000_000_000
TICK_NS = 20_000_000
TEXT = "std_msgs/msg/String"
FACTS = {"robot": "Kinematic robot", "map": "square", "seed": "7", "version": "0.1.0"}


def text_cdr(text):
    return to_cdr(new(TEXT, data=text), TEXT)


def write_ticks(file, count, first=0):
    """A text each tick, and now and then a latched one."""
    for tick in range(first, first + count):
        now = BEGIN_NS + tick * TICK_NS
        if tick % 100 == 0:
            file.write("/robot_description", TEXT, LATCHED, now, now, text_cdr(f"robot {tick}"))
        file.write("/command", TEXT, Quality(), now, now, text_cdr(f"tick {tick}"))


def make(folder, ticks=200, close=True):
    """A recording with one attachment; its file and the last message's tick."""
    file = RecordingFile(folder, FACTS)
    file.attach("settings.toml", b"seed = 7\n", "application/toml", BEGIN_NS)
    write_ticks(file, ticks)
    if close:
        file.close()
    else:
        file.abandon()
    return file.path
