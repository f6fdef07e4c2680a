"""``brickpose emulate-hat`` as a program."""

from __future__ import annotations

import os
import re
import signal
import socket
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest
import serial
from simulators import require_engine

from app.features.build_hat.emulate_hat import emulate_hat
from app.settings.config import ROOT
from robot.camera import Lens
from robot.cameras.picture_socket import PictureSocket
from robot.description.spec import RobotSpec
from robot.settings import SettingError

pytestmark = pytest.mark.slow

MAIN = [sys.executable, "-m", "app"]


@contextmanager
def program(*options: str, **more: str) -> Iterator[subprocess.Popen[str]]:
    with subprocess.Popen(
        [*MAIN, "emulate-hat", *options],
        cwd=ROOT,
        env=os.environ | more,
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    ) as process:
        try:
            yield process
        finally:
            process.kill()


def first_line(process: subprocess.Popen[str]) -> str:
    assert process.stdout is not None
    return process.stdout.readline().rstrip("\n")


def ask(path: Path, line: str) -> str:
    with socket.socket(socket.AF_UNIX) as connection:
        connection.settimeout(10)
        connection.connect(str(path))
        connection.sendall(f"{line}\n".encode())
        return connection.makefile().readline().rstrip("\n")


@pytest.mark.parametrize("ending", [signal.SIGINT, signal.SIGTERM])
def test_it_names_its_port_answers_there_and_ends_with_0(tmp_path: Path, ending: int) -> None:
    link, hands = tmp_path / "hat", tmp_path / "hands"
    with program("--world", "free", "--link", str(link), "--control", str(hands)) as process:
        assert first_line(process) == f"Build HAT at {link}"
        with serial.Serial(str(link), 115200, timeout=5) as port:
            port.write(b"version\r")
            assert port.readline() == b"\r\n"
            assert port.readline().startswith(b"Firmware version: 1737564117 ")
        assert ask(hands, "state").startswith("now ")
        process.send_signal(ending)
        assert process.wait(10) == 0
        assert process.stderr is not None
        assert process.stderr.read() == ""
    assert list(tmp_path.iterdir()) == []


def test_without_a_link_the_device_itself_is_named() -> None:
    with program("--world", "free") as process:
        name = re.fullmatch(r"Build HAT at (/dev/pts/\d+)", first_line(process))
        assert name
        with serial.Serial(name[1], 115200, timeout=5) as port:
            port.write(b"vin\r")
            port.readline()
            assert port.readline() == b"8.00 V\r\n"


def test_lines_are_typed_and_their_end_ends_nothing() -> None:
    with program("--world", "free", "--motors", "C=large-grey", "--firmware", "1670596313") as one:
        device = first_line(one).removeprefix("Build HAT at ")
        assert one.stdin is not None
        one.stdin.write("state\n")
        one.stdin.close()
        assert "firmware; A - 0.0 0.0; B - 0.0 0.0; C 4C" in first_line(one)
        with serial.Serial(device, 115200, timeout=5) as port:
            port.write(b"version\r")
            port.readline()
            assert port.readline().startswith(b"Firmware version: 1670596313 ")


def test_it_keeps_its_state_between_programs() -> None:
    with program("--world", "free") as process:
        device = first_line(process).removeprefix("Build HAT at ")
        with serial.Serial(device, 115200, timeout=5) as port:
            port.write(b"echo 1\r")
            assert port.read_until(b"P0>") == b"\r\nP0>"
        with serial.Serial(device, 115200, timeout=5) as port:
            port.write(b"p 1\r")
            assert port.read_until(b"P1>") == b"p 1\r\nP1>"


def test_it_can_wait_in_the_bootloader() -> None:
    with program("--world", "free", "--bootloader") as process:
        device = first_line(process).removeprefix("Build HAT at ")
        with serial.Serial(device, 115200, timeout=5) as port:
            port.write(b"version\r")
            assert b"BuildHAT bootloader version" in port.read_until(b"+01:00\r\n")


def test_the_free_motors_need_no_physics(tmp_path: Path) -> None:
    for module in ("pybullet", "mujoco"):
        (tmp_path / f"{module}.py").write_text("raise ImportError('not here')")
    with program(PYTHONPATH=str(tmp_path)) as process:
        assert first_line(process).startswith("Build HAT at ")
        assert process.stdin is not None
        process.stdin.write("truth\n")
        process.stdin.flush()
        assert first_line(process).startswith("error: there is no robot")
    with program("--world", "sim", PYTHONPATH=str(tmp_path)) as process:
        assert process.wait(60) == 1
        assert process.stderr is not None
        assert "No physics engine is installed" in process.stderr.read()


def test_a_robot_s_pictures_are_served_with_stamps_of_the_shared_clock(tmp_path: Path) -> None:
    import time

    require_engine()
    pictures, hands = tmp_path / "pictures", tmp_path / "hands"
    lens: Lens = RobotSpec.load().lens
    with program("--pictures", str(pictures), "--control", str(hands), "--world", "sim") as one:
        assert first_line(one).startswith("Build HAT at ")
        camera = PictureSocket(pictures, lens)
        camera.open()
        stamps = []
        while len(stamps) < 10:
            frame = camera.grab(5.0)
            assert frame is not None
            stamps.append(frame.stamp)
            age = time.monotonic() - frame.stamp
            assert 0 < age < 1
        assert stamps == sorted(stamps)
        standing = frame.image
        assert ask(hands, "place 0.3 0.2 2") == "ok"
        for _ in range(3):
            frame = camera.grab(5.0)
            assert frame is not None
        assert abs(frame.image.astype(int) - standing.astype(int)).mean() > 5
        camera.close()
        one.terminate()
        assert one.wait(10) == 0
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"world": "free", "pictures": Path("x")}, "--pictures has no effect with --world free"),
        ({"world": "free", "map": "tee"}, "--map has no effect"),
        ({"world": "free", "firmware": 1, "bootloader": True}, "give one of them"),
        ({"world": "free", "motors": "E=large"}, "no port 'E'; valid are A, B, C, D"),
        ({"world": "free", "motors": "A=huge"}, "no motor is called 'huge'; valid are medium"),
        ({"world": "free", "motors": "A"}, "no motor is called ''"),
    ],
)
def test_an_option_that_cannot_be_names_what_is_valid(options: dict, message: str) -> None:
    with pytest.raises(SettingError, match=message):
        emulate_hat(options)


def test_a_file_in_the_way_is_told_in_one_line(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("precious")
    for option in ("--link", "--control"):
        with program("--world", "free", option, str(tmp_path / "file")) as process:
            assert process.wait(60) == 1
            assert process.stderr is not None
            assert re.fullmatch(r"brickpose: .*file.*\n", process.stderr.read())
    assert (tmp_path / "file").read_text() == "precious"
