"""Pictures of the emulated robot's camera, through a socket."""

from __future__ import annotations

import socket
import struct
import threading
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from robot.cameras.picture_socket import PictureSocket
from robot.errors import PortError
from robot.geometry import Pose2, Twist2
from robot.lens_files.reading import read_lens_file
from sim.floor_camera import CameraSettings
from sim.hat_emulator.picture_server import PictureServer, PictureServerError, Shot
from sim.hat_emulator.pseudo_terminal import listen, stop_listening
from sim.hat_emulator.surroundings import CameraFeed

STANDING = Twist2(0.0, 0.0)
LENS = replace(read_lens_file(Path("robot/description/pi_camera.yaml")).lens, width=64, height=48)


class Counting:
    """A camera whose picture's first pixel says where it was taken, as x in cm."""

    def __init__(self) -> None:
        self.taken = 0
        self.broken = False

    def picture(self, map_from_robot: Pose2, twist: Twist2):
        if self.broken:
            raise OSError("the lens fell off")
        self.taken += 1
        picture = np.zeros((48, 64), dtype=np.uint8)
        picture[0, 0] = round(100 * map_from_robot.x)
        return picture


class Clock:
    now = 100.0

    def __call__(self) -> float:
        return self.now


@pytest.fixture
def camera() -> Counting:
    return Counting()


@pytest.fixture
def clock() -> Clock:
    return Clock()


@pytest.fixture
def server(tmp_path: Path, camera: Counting, clock: Clock) -> Iterator[PictureServer]:
    made = PictureServer(tmp_path / "pictures", camera, clock)  # type: ignore[arg-type]
    made.start()
    yield made
    made.close()
    assert "pictures" not in {thread.name for thread in threading.enumerate()}


def shot(number: int, stamp: float = 99.0, due: float = 99.5) -> Shot:
    return Shot(stamp, due, Pose2(number / 100, 0.0, 0.0), STANDING)


def connect(path: Path) -> socket.socket:
    reader = socket.socket(socket.AF_UNIX)
    reader.settimeout(2)
    reader.connect(str(path))
    return reader


def picture(reader: socket.socket) -> tuple[float, int]:
    """Stamp and number of the next picture."""
    header = reader.recv(24, socket.MSG_WAITALL)
    mark, stamp, *shape = struct.unpack("<4sdIII", header)
    assert (mark, shape) == (b"BPF1", [48, 64, 1])
    return stamp, reader.recv(48 * 64, socket.MSG_WAITALL)[0]


def until(server: PictureServer, reader: socket.socket, first: Shot) -> tuple[float, int]:
    """Take a shot again and again until the reader, that was just welcomed, has one."""
    reader.settimeout(0.05)
    for _ in range(100):
        server.take(first)
        try:
            if reader.recv(1, socket.MSG_PEEK):
                break
        except TimeoutError:
            continue
    reader.settimeout(2)
    return picture(reader)


def test_a_reader_gets_stamp_shape_and_bytes(server: PictureServer, tmp_path: Path) -> None:
    with connect(tmp_path / "pictures") as reader:
        assert until(server, reader, shot(7, stamp=98.25)) == (98.25, 7)


def test_the_program_s_own_camera_reads_them(server: PictureServer, tmp_path: Path) -> None:
    client = PictureSocket(tmp_path / "pictures", LENS)
    client.open()
    for _ in range(100):
        server.take(shot(3, stamp=98.5))
        frame = client.grab(0.05)
        if frame is not None:
            break
    assert frame is not None
    assert frame.stamp == 98.5
    assert frame.image[0, 0] == 3
    assert frame.image.shape == (48, 64)
    client.close()


def test_each_reader_gets_each_picture_once(server: PictureServer, tmp_path: Path) -> None:
    with connect(tmp_path / "pictures") as one, connect(tmp_path / "pictures") as other:
        until(server, one, shot(1))
        until(server, other, shot(2))
        for number in range(10, 20):
            server.take(shot(number))
            for reader in (one, other):
                while (got := picture(reader)[1]) != number:
                    assert got in (1, 2)


def test_a_slow_reader_misses_pictures_and_delays_no_other(
    server: PictureServer, tmp_path: Path
) -> None:
    with connect(tmp_path / "pictures") as quick, connect(tmp_path / "pictures") as slow:
        slow.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
        until(server, quick, shot(1))
        until(server, slow, shot(1))
        for number in [*range(2, 200)] * 4:
            server.take(shot(number))
            while picture(quick)[1] != number:
                pass
        server.take(shot(200))
        seen = 0
        while picture(slow)[1] != 200:
            seen += 1
        assert seen < 790


def test_a_picture_comes_when_it_is_due_and_not_before(
    server: PictureServer, tmp_path: Path, clock: Clock
) -> None:
    with connect(tmp_path / "pictures") as reader:
        until(server, reader, shot(1))
        server.take(shot(2, due=clock.now + 0.3))
        reader.settimeout(0.05)
        with pytest.raises(TimeoutError):
            while picture(reader)[1] != 2:
                pass
        clock.now += 0.4
        reader.settimeout(2)
        assert picture(reader)[1] == 2


def test_pictures_that_are_long_under_way_all_come(
    server: PictureServer, camera: Counting, tmp_path: Path, clock: Clock
) -> None:
    with connect(tmp_path / "pictures") as reader:
        until(server, reader, shot(1))
        for number in (2, 3, 4):
            before = camera.taken
            server.take(shot(number, due=clock.now + 0.1 * number))
            for _ in range(1_000_000):
                if camera.taken > before:
                    break
        clock.now += 1
        server.take(shot(5))
        numbers = [0]
        while numbers[-1] != 5:
            numbers.append(picture(reader)[1])
        assert numbers[-4:] == [2, 3, 4, 5]


def test_nothing_is_worked_out_while_nobody_reads(
    server: PictureServer, camera: Counting, tmp_path: Path
) -> None:
    for number in range(100):
        server.take(shot(number))
    assert camera.taken == 0
    with connect(tmp_path / "pictures") as reader:
        until(server, reader, shot(1))
    for number in range(10_000):
        server.take(shot(number))
        if not server._readers:
            break
    assert not server._readers


def test_a_failure_is_told_and_not_swallowed(
    server: PictureServer, camera: Counting, tmp_path: Path
) -> None:
    camera.broken = True
    with (
        connect(tmp_path / "pictures"),
        pytest.raises(PictureServerError, match="the lens fell off"),
    ):
        for _ in range(1_000_000):
            server.take(shot(1))


def test_the_socket_goes_with_it(tmp_path: Path, camera: Counting) -> None:
    path = tmp_path / "pictures"
    server = PictureServer(path, camera)  # type: ignore[arg-type]
    server.start()
    assert path.is_socket()
    server.close()
    server.close()
    assert not path.exists()


def test_a_name_is_taken_from_the_dead_but_not_from_the_living_nor_from_files(
    tmp_path: Path,
) -> None:
    path = tmp_path / "socket"
    dead = socket.socket(socket.AF_UNIX)
    dead.bind(str(path))
    dead.close()
    living = listen(path)
    with pytest.raises(PortError, match="another program listens"):
        listen(path)
    stop_listening(living)
    path.write_text("precious")
    with pytest.raises(PortError, match="in use"):
        listen(path)
    assert path.read_text() == "precious"


class Rolling:
    """A world that rolls along x with 0.1 m/s."""

    now = 0.0

    @property
    def pose(self) -> Pose2:
        return Pose2(0.1 * self.now, 0.0, 0.0)

    @property
    def twist(self) -> Twist2:
        return Twist2(0.1, 0.0)


def roll(feed: CameraFeed, world: Rolling, seconds: float) -> None:
    for _ in range(round(seconds / 0.002)):
        world.now += 0.002
        feed.look(world.now)


def test_a_shot_shows_the_past_and_is_handed_over_once_it_is_exposed() -> None:
    settings = CameraSettings(frame_rate=20, exposure=0.01, delay=0.03, stamp_error=0.002)
    shots: list[tuple[float, Shot]] = []
    world = Rolling()
    feed = CameraFeed(
        world,  # type: ignore[arg-type]
        settings,
        0.02,
        lambda stamp: stamp + 1000,
        lambda one: shots.append((world.now, one)),
    )
    roll(feed, world, 0.5)
    assert len(shots) == 10
    for number, (handed, one) in enumerate(shots):
        exposed = number / 20
        assert handed == pytest.approx(exposed + 0.015, abs=0.0021)
        assert one.stamp == pytest.approx(1000 + exposed + 0.002)
        assert one.due == pytest.approx(1000 + exposed + 0.015 + 0.03)
        assert one.pose.x == pytest.approx(0.1 * max(exposed, 0.002))
        assert one.twist == Twist2(0.1, 0.0)


def test_after_being_put_elsewhere_no_old_picture_comes() -> None:
    shots: list[Shot] = []
    world = Rolling()
    feed = CameraFeed(
        world,  # type: ignore[arg-type]
        CameraSettings(frame_rate=20),
        0.02,
        lambda stamp: stamp,
        shots.append,
    )
    roll(feed, world, 0.101)
    feed.moved(world.now)
    before = len(shots)
    roll(feed, world, 0.1)
    assert [one.stamp for one in shots[before:]] == pytest.approx([0.15])
