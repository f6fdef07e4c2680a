"""Files of other people are read beside the program: they can cost it neither time nor memory."""

import os
import pickle
import threading
import time
from pathlib import Path

import foreign_jobs
import numpy as np
import pytest
from replays import recorded_eight

from app.features.recordings.replay.opening import Opened
from app.foreign_files import CostlyFileError, read_apart
from app.settings.config import MAPS
from robot.fields.field import FieldError
from robot.fields.field_loading import load_field

FILE = Path(__file__)


def test_what_is_read_comes_back():
    assert read_apart(foreign_jobs.text, FILE) == FILE.read_text()


@pytest.mark.slow
def test_it_is_another_process_which_gives_way():
    assert read_apart(foreign_jobs.process, FILE) != os.getpid()
    assert read_apart(foreign_jobs.niceness, FILE) >= 10


def test_an_error_is_the_readers_own():
    with pytest.raises(FieldError, match=r"test_foreign_files\.py has no tape"):
        read_apart(foreign_jobs.refuse, FILE)


@pytest.mark.slow
def test_the_clock_ends_it_and_others_go_on_meanwhile():
    """The pattern holds Python's lock for years, but not here: a thread makes its steps."""
    late, done = [], threading.Event()

    def step():
        last = time.monotonic()
        while not done.wait(0.02):
            late.append(time.monotonic() - last)
            last = time.monotonic()

    thread = threading.Thread(target=step)
    thread.start()
    with pytest.raises(CostlyFileError, match="is not read after 6 s; valid are files"):
        read_apart(foreign_jobs.never_read, FILE, 6.0)
    done.set()
    thread.join()
    assert max(late) < 2.0


@pytest.mark.slow
@pytest.mark.parametrize("read", [foreign_jobs.swallow, foreign_jobs.swallow_bit_by_bit])
def test_memory_has_an_end(read):
    with pytest.raises(CostlyFileError, match="takes more than 1024 MB of memory"):
        read_apart(read, FILE)


def test_a_crash_is_told():
    with pytest.raises(CostlyFileError, match="ends the process that reads it"):
        read_apart(foreign_jobs.crash, FILE)


def test_a_field_from_there_is_the_field():
    here = load_field("stub", MAPS)
    there = pickle.loads(pickle.dumps(here))
    assert there.name == here.name and there.start == here.start
    np.testing.assert_array_equal(there.edges, here.edges)
    np.testing.assert_array_equal(there.floor.image, here.floor.image)


@pytest.mark.slow
def test_a_recording_from_there_is_the_recording(tmp_path):
    path, _ = recorded_eight(tmp_path, 2.0)
    here, there = Opened.of(path), read_apart(Opened.of, path)
    assert there.parts.config == here.parts.config
    assert there.parts.has_settings and there.parts.from_start
    np.testing.assert_array_equal(there.parts.field.edges, here.parts.field.edges)
    assert there.reader.duration == here.reader.duration
    assert list(there.reader.messages()) == list(here.reader.messages())
    assert dict(there.reader.attachments) == dict(here.reader.attachments)
