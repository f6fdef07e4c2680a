"""The client of the emulator's camera, on a real Unix socket."""

import socket
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from camera_sources import READOUT, Emulator, lens, picture, until, wire
from hypothesis import given
from hypothesis import strategies as st

from robot.cameras.camera import PictureError
from robot.cameras.picture_socket import HEADER, MARK, PictureSocket

SMALL = lens(8, 6)


class Wire:
    """The client's socket, without a path: bytes come as a test has them come."""

    def __init__(self):
        self.client = PictureSocket("nowhere", SMALL)
        ours, self.theirs = socket.socketpair()
        self.client._socket = ours

    def close(self):
        self.client.close()
        self.theirs.close()


@pytest.fixture
def line():
    made = Wire()
    yield made
    made.close()


@pytest.fixture
def source(tmp_path):
    made = Emulator(tmp_path)
    yield made
    made.close()


def test_stamps_and_pictures_come_as_they_were_sent(line):
    for stamp, shape in ((12.345678901, (6, 8)), (12.4, (6, 8, 3))):
        sent = np.random.default_rng(1).integers(0, 255, shape).astype(np.uint8)
        line.theirs.sendall(wire(sent, stamp))
        frame = line.client.grab(1.0)
        assert frame.stamp == stamp
        assert np.array_equal(frame.image, sent)


@given(cuts=st.lists(st.integers(0, 4 * (HEADER.size + 48)), max_size=12))
def test_pictures_come_whole_however_their_bytes_are_cut(cuts):
    line = Wire()
    sent = [picture(number, 8, 6) for number in range(4)]
    stream = b"".join(wire(image, 1.0 + place) for place, image in enumerate(sent))
    edges = [0, *sorted(cuts), len(stream)]
    frames = []
    for start, end in pairwise(edges):
        line.theirs.sendall(stream[start:end])
        while (frame := line.client.grab(1e-4)) is not None:
            frames.append(frame)
    line.close()
    assert [frame.stamp for frame in frames] == [1.0, 2.0, 3.0, 4.0]
    assert all(np.array_equal(f.image, image) for f, image in zip(frames, sent, strict=True))


@pytest.mark.parametrize(
    "header",
    [
        HEADER.pack(b"HTTP", 1.0, 6, 8, 1),
        HEADER.pack(MARK, 1.0, 6, 8, 4),
        HEADER.pack(MARK, float("nan"), 6, 8, 1),
    ],
)
def test_what_is_no_picture_is_refused(line, header):
    line.theirs.sendall(header)
    with pytest.raises(PictureError, match="no pictures of BrickPose's emulator"):
        line.client.grab(1.0)


@given(noise=st.binary(min_size=HEADER.size, max_size=200))
def test_noise_is_refused_or_waited_out_but_nothing_else(noise):
    line = Wire()
    line.theirs.sendall(noise)
    with pytest.raises(PictureError):
        line.client.grab(1e-3)
    line.close()


def test_a_header_that_announces_gigabytes_is_refused_at_once(line):
    line.theirs.sendall(HEADER.pack(MARK, 1.0, 2**32 - 1, 2**32 - 1, 3))
    with pytest.raises(PictureError, match=r"8 x 6 px"):
        line.client.grab(1.0)


def test_half_a_picture_is_waited_for(line):
    sent = wire(picture(0, 8, 6), 1.0)
    line.theirs.sendall(sent[:-1])
    assert line.client.grab(1e-3) is None
    line.theirs.sendall(sent[-1:])
    assert line.client.grab(1.0).stamp == 1.0


def test_the_end_of_the_emulator_is_told(line):
    line.theirs.close()
    with pytest.raises(PictureError, match="has ended"):
        line.client.grab(1.0)


def test_nothing_that_listens_is_told_with_the_cure(tmp_path):
    client = PictureSocket(tmp_path / "absent.sock", SMALL)
    with pytest.raises(
        PictureError, match=r"start brickpose emulate-hat --pictures .*absent\.sock"
    ):
        client.open()
    client.close()


def test_without_opening_there_is_no_picture(tmp_path):
    with pytest.raises(PictureError, match="not open"):
        PictureSocket(tmp_path / "absent.sock", SMALL).grab(0.0)


def test_an_emulator_that_ends_and_comes_again_is_found_again(source):
    first = source.next()
    source.end()
    until(lambda: source.camera.problem)
    assert source.camera.newest() is None
    source.listen()
    assert source.next().stamp > first.stamp
    assert source.camera.problem is None


def test_half_a_picture_of_the_last_connection_is_forgotten(source):
    source.next()
    source.send_bytes(wire(picture(1, *source.size), 2.0)[:100])
    source.end()
    until(lambda: source.camera.problem)
    source.listen()
    frame = source.next()
    assert np.array_equal(frame.image, picture(source.exposed - 1, *source.size))


def test_the_emulators_stamp_is_taken_as_it_is(source):
    source.send_bytes(wire(picture(0, *source.size), 4321.125))
    assert until(source.camera.newest).stamp == 4321.125
    assert source.lens.readout == READOUT


def descriptors():
    return len(list(Path("/proc/self/fd").iterdir()))


def test_attempts_and_reconnections_leave_no_descriptor_open(source):
    source.next()
    before = descriptors()
    for _ in range(5):
        source.end()
        until(lambda: "does not answer" in (source.camera.problem or ""))
        source.listen()
        source.next()
    assert descriptors() == before
