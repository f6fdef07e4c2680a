"""What all tests share."""

import os
import textwrap

import pytest
from hypothesis import settings

# The machine may be busy: a slow example is no fault.
settings.register_profile("brickpose", deadline=None, derandomize=True)
settings.load_profile("brickpose")


@pytest.fixture
def save(tmp_path):
    """Writes a file as an editor does; each time it is newer, however quick the test."""
    times = iter(range(10**9, 2 * 10**9))

    def write(text, name="mine.py"):
        path = tmp_path / name
        path.write_text(textwrap.dedent(text), encoding="utf-8")
        stamp = next(times)
        os.utime(path, (stamp, stamp))
        return path

    return write
