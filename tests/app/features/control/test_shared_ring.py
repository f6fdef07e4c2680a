"""Arrays go through memory that two processes share, and nobody ever waits for the other."""

from __future__ import annotations

import multiprocessing
import os
import signal
import sys

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.features.control.parts import LARGE, PartsReader, PartsWriter
from app.features.control.shared_ring import SharedRing


@given(st.lists(st.tuples(st.integers(1, 60), st.booleans()), max_size=60))
def test_what_is_taken_is_what_was_put_however_far_the_reader_is(steps):
    ring, waiting = SharedRing(100), []
    for count, (size, reads) in enumerate(steps):
        array = np.full(size, count, np.uint8)
        position = ring.put(array)
        if position is None:
            assert sum(len(other) for _, other in waiting) + size > 100 - 60
        else:
            waiting.append((position, array))
        if reads and waiting:
            position, array = waiting.pop(0)
            assert np.array_equal(ring.take(position, len(array)), array)
            ring.free(position + len(array))
    for position, array in waiting:
        assert np.array_equal(ring.take(position, len(array)), array)


def test_a_reader_that_keeps_up_needs_room_for_what_it_reads_alone():
    ring = SharedRing(1000)
    for _ in range(50):
        position = ring.put(np.zeros(90))
        assert position % 1000 == 0
        ring.free(position + 720)


def test_what_is_larger_than_the_ring_goes_another_way():
    ring = SharedRing(1000)
    assert ring.put(np.zeros(1001, np.uint8)) is None
    assert ring.put(np.zeros(1000, np.uint8)) == 0


def test_large_arrays_of_messages_go_through_the_ring_while_there_is_room():
    ring = SharedRing(3 * LARGE)
    writer, reader = PartsWriter([], ring), PartsReader(ring)
    arrays = [np.full((2, LARGE // 16), float(each)) for each in range(7)]
    written = [writer.write([each]) for each in arrays]
    assert [len(each) > LARGE for each in written] == [False] * 3 + [True] * 4
    for message, array in zip(written, arrays, strict=True):
        (out,) = reader.read(message)
        assert np.array_equal(out, array) and not out.flags.writeable
    reader.read(writer.write("what is read is free at the next message"))
    assert len(writer.write([np.zeros(LARGE, np.uint8)])) < LARGE  # the eighth


@pytest.mark.skipif(sys.platform != "linux", reason="only a fork shares it")
def test_the_memory_outlives_a_writer_that_is_killed():
    ring = SharedRing()

    def write(connection) -> None:
        connection.send(ring.put(np.arange(100_000)))
        signal.pause()

    ours, theirs = multiprocessing.get_context("fork").Pipe()
    process = multiprocessing.get_context("fork").Process(target=write, args=(theirs,))
    process.start()
    position = ours.recv()
    os.kill(process.pid, signal.SIGKILL)
    process.join()
    assert np.array_equal(ring.take(position, 800_000).view(np.int64), np.arange(100_000))
