"""Ways to read a file that a process of its own has to survive."""

import os
import re
from pathlib import Path

from robot.fields.field import FieldError


def text(path):
    """What stands in it."""
    return path.read_text()


def refuse(path):
    """No such file is of use."""
    raise FieldError(f"{path.name} has no tape")


def never_read(path):
    """A regular expression that holds Python's lock and ends in some thousand years."""
    return re.match(r"(a+)+$", "a" * 60 + "!")


def swallow(path):
    """More memory than there may be."""
    return len(bytearray(8 << 30))


def swallow_bit_by_bit(path):
    """As many lists as there is memory for."""
    kept = []
    while True:
        kept.append([0] * 1_000_000)


def crash(path):
    """As a library does that reads behind the end of a buffer."""
    os.kill(os.getpid(), 11)


def niceness(path):
    """How much it gives way to the robot."""
    return os.getpriority(os.PRIO_PROCESS, 0)


def process(path: Path):
    """Where it is read."""
    return os.getpid()
