"""Snapshots as bytes: what comes out is what went in, and what was one object stays one."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import pytest
from engine_runs import drive, kinematic, run
from hypothesis import given
from hypothesis import strategies as st

from app.features.control.parts import PartsReader, PartsWriter
from app.features.control.process import PARTS


@dataclass(frozen=True)
class Box:
    """A part, with whatever is in it."""

    content: object


LEAVES = st.integers() | st.floats(allow_nan=False) | st.text(max_size=5) | st.none()
VALUES = st.recursive(
    LEAVES,
    lambda inner: st.lists(inner, max_size=3) | inner.map(Box) | st.tuples(inner, inner),
    max_leaves=20,
)


def pair() -> tuple[PartsWriter, PartsReader]:
    return PartsWriter([Box]), PartsReader()


@given(st.lists(VALUES, max_size=5), st.data())
def test_values_come_out_as_they_went_in_also_if_they_share_parts(values, data):
    writer, reader = pair()
    boxes = [Box(value) for value in values]
    for _ in range(6):
        chosen = data.draw(st.lists(st.sampled_from(boxes), max_size=4)) if boxes else []
        message = [Box(list(chosen)), *chosen]
        assert reader.read(writer.write(message)) == message


def test_a_part_is_sent_once_for_as_long_as_messages_have_it():
    writer, reader = pair()
    picture = np.zeros((100, 100))
    inner = Box(picture)
    first = reader.read(writer.write((Box(inner), picture)))
    assert first[0].content.content is first[1]
    again = writer.write([Box(picture)])
    assert len(again) < 300
    assert reader.read(again)[0].content is first[1]
    assert reader.read(writer.write("nothing of it")) == "nothing of it"
    assert len(writer.write([Box(picture)])) > 80_000


def test_what_is_within_a_part_is_kept_with_it():
    writer, reader = pair()
    table = Box(np.arange(1000.0))
    outer = Box(table)
    reader.read(writer.write(outer))
    for _ in range(3):
        reader.read(writer.write(outer))
    written = writer.write(table)
    assert len(written) < 300
    assert np.array_equal(reader.read(written).content, np.arange(1000.0))


def test_arrays_come_out_read_only():
    writer, reader = pair()
    (out,) = reader.read(writer.write([np.zeros(1000)]))
    with pytest.raises(ValueError, match="read-only"):
        out[0] = 1.0


def test_what_cannot_be_written_harms_nothing_that_comes_after_it():
    writer, reader = pair()
    box = Box(np.zeros(1000))
    with pytest.raises(Exception, match="pickle"):
        writer.write([box, Box(lambda: None)])
    assert np.array_equal(reader.read(writer.write([box]))[0].content, np.zeros(1000))


def test_the_two_ends_remember_no_more_than_the_last_message_has():
    writer, reader = pair()
    for number in range(50):
        reader.read(writer.write([Box(np.full(100, float(number))) for _ in range(3)]))
    assert len(writer._table.parts) == len(reader._table.parts) == 6


def test_snapshots_of_a_drive_come_out_whole_and_share_what_they_shared():
    program = kinematic(map="stub")
    writer, reader = PartsWriter(PARTS), PartsReader()
    before = None
    sizes = []
    for snapshot in run(program, 3.0, drive(0.1, 0.5)):
        written = writer.write(snapshot)
        out = reader.read(written)
        sizes.append(len(written))
        assert out.layers == snapshot.layers  # a set has no order
        assert repr(replace(out, layers=None)) == repr(replace(snapshot, layers=None))
        assert out.commands == snapshot.commands
        assert (out.frame is out.reading.frame) == (snapshot.frame is snapshot.reading.frame)
        if before is not None:
            assert (out.frame is before[1].frame) == (snapshot.frame is before[0].frame)
            assert out.filter.scanner is before[1].filter.scanner
        if snapshot.frame is not None:
            assert np.array_equal(out.frame.image, snapshot.frame.image)
            assert np.array_equal(out.filter.cloud.poses, snapshot.filter.cloud.poses)
        before = snapshot, out
    program.robot.close()
    # A tick without a new picture, and one with it: nobody sends tables again.
    assert min(sizes[5:]) < 5_000 and max(sizes[5:]) < 500_000


def test_what_both_ends_had_before_is_never_sent_and_stays():
    picture = np.zeros((100, 100))
    shared = (Box("what a fork has, too"), picture)
    writer, reader = PartsWriter([Box], shared=shared), PartsReader(shared=shared)
    for _ in range(2):
        written = writer.write([shared[0], Box(picture)])
        assert len(written) < 300
        had, box = reader.read(written)
        assert had is shared[0]
        assert box.content is picture
        assert reader.read(writer.write("nothing of it")) == "nothing of it"
