"""``brickpose doctor`` and ``stop-motors`` at a Build HAT's serial port, which is emulated."""

from __future__ import annotations

import fcntl
import os
import re
import select
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path

import cv2
import numpy as np
import pytest
from hat_boards import Bench
from serving import ROOT

from app.command_line import main
from app.features.build_hat import board_check as board
from app.tools.doctor.finding import PROBLEM, WARNING, Finding
from benchmarks.hat.emulated_hat import EmulatedHat, emulated_hat
from robot.description.spec import RobotSpec
from robot.hat.settings import BuildHatSettings

pytestmark = pytest.mark.slow

Examine = Callable[[], list[Finding]]


@pytest.fixture(scope="module")
def pictures(tmp_path_factory) -> Path:
    folder: Path = tmp_path_factory.mktemp("pictures")
    lens = RobotSpec.load().lens
    cv2.imwrite(str(folder / "0.png"), np.full((lens.height, lens.width), 128, np.uint8))
    return folder


def doctor(hat: EmulatedHat, pictures: Path) -> list[str]:
    options = ["--robot", "buildhat", "--serial-port", str(hat.device), "--camera", str(pictures)]
    return ["doctor", *options]


@pytest.fixture(scope="module")
def upload(tmp_path_factory, pictures: Path) -> Iterator[subprocess.Popen[str]]:
    """Runs meanwhile: the firmware takes five seconds on the wire."""
    with emulated_hat(tmp_path_factory.mktemp("cold"), "--world", "free", "--bootloader") as cold:
        command = [sys.executable, "-m", "app", *doctor(cold, pictures)]
        with subprocess.Popen(
            command, cwd=ROOT, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
        ) as running:
            yield running


@pytest.fixture(scope="module")
def running(tmp_path_factory, upload) -> Iterator[EmulatedHat]:
    with emulated_hat(tmp_path_factory.mktemp("hat"), "--world", "free") as hat:
        yield hat


@pytest.fixture
def hat(running: EmulatedHat) -> Iterator[EmulatedHat]:
    yield running
    for line in ("supply 8", "silent off", "fault motor off"):
        running.ask(line)


@pytest.fixture
def examine(hat: EmulatedHat) -> Examine:
    joints = RobotSpec.load().joints
    return lambda: board.check_board(str(hat.device), joints, BuildHatSettings(), lambda what: None)


def told(found: list[Finding], level: str) -> list[str]:
    return [one.message + one.cure for one in found if one.level == level]


def turned(hat: EmulatedHat) -> list[str]:
    return re.findall(r"[AB] 30 (\S+)", hat.ask("state"))


def test_a_robot_that_is_well_is_told_so_and_does_not_turn(hat, pictures, capsys) -> None:
    before = turned(hat)
    assert main(doctor(hat, pictures)) == 0
    lines = [line for line in capsys.readouterr().out.splitlines() if line.startswith("ok")]
    for what in ("firmware 1737564117", " 8.0", "Port A (left_wheel_joint): medium", "Port B"):
        assert any(what in line for line in lines), what
    assert turned(hat) == before
    assert hat.ask("duty").split()[:2] == ["0.0000", "0.0000"]


def test_a_weak_supply_is_a_warning(hat, examine: Examine) -> None:
    hat.ask("supply 6.5")
    found = examine()
    (weak,) = told(found, WARNING)
    assert "6.5" in weak and "charge" in weak
    assert told(found, PROBLEM) == []


def test_no_supply_is_a_problem_told_once(hat, examine: Examine, monkeypatch) -> None:
    monkeypatch.setattr(board, "PLUGGED_S", 0.5)
    hat.ask("supply 5")
    (none,) = told(examine(), PROBLEM)
    assert re.search(r"5\.0\d V.*connect the battery", none)


def test_a_motor_power_fault_is_a_problem(hat, examine: Examine, monkeypatch) -> None:
    monkeypatch.setattr(board, "PLUGGED_S", 0.5)
    hat.ask("fault motor on")
    (fault,) = told(examine(), PROBLEM)
    assert "motor power fault" in fault


def test_a_silent_board_is_a_problem_with_all_its_cures(hat, examine: Examine, monkeypatch) -> None:
    monkeypatch.setattr(board, "SILENT_S", 0.2)
    hat.ask("silent on")
    (silent,) = told(examine(), PROBLEM)
    assert all(cure in silent for cure in ("raspi-config", "8 V", "/dev/ttyAMA0", "1-Wire"))


def test_a_port_that_another_program_has_is_a_problem(hat, examine: Examine) -> None:
    fd = os.open(hat.device, os.O_RDWR | os.O_NOCTTY)
    try:
        # Our own process is not looked at; the lock is found when the port is opened.
        fcntl.flock(fd, fcntl.LOCK_EX)
        (taken,) = told(examine(), PROBLEM)
    finally:
        os.close(fd)
    assert "Another program has" in taken


def test_a_missing_and_a_wrong_motor_are_problems_of_their_ports(hat, examine: Examine) -> None:
    for line in ("unplug A", "unplug B", "plug B large"):
        hat.ask(line)
    missing, wrong = told(examine(), PROBLEM)
    assert "port A (left_wheel_joint)" in missing
    assert "port B (right_wheel_joint) is a large angular motor" in wrong


def test_a_board_without_firmware_gets_it_and_says_how_far_it_is(upload) -> None:
    out, err = upload.communicate(timeout=60)
    assert (upload.returncode, "\nproblem" in out) == (0, False)
    assert "sending the firmware, which takes five seconds" in err
    assert "firmware 1737564117" in out


def test_motors_that_another_program_left_running_are_stopped() -> None:
    bench = Bench(motors=2)
    bench.say("port 0;pwm;set .5;port 1;pid 1 0 5 s2 .0027777778 1 0 2.5 0 .4 .01;set 1", 0.3)
    assert all(bench.board.duty(port) for port in (0, 1))
    bench.board.receive(b"port 0;set pulse .5 0")  # who was killed in the middle of a line
    ours, theirs = os.openpty()
    try:
        assert main(["stop-motors", "--serial-port", os.ttyname(theirs)]) == 0
        assert select.select([ours], [], [], 1)[0]
        bench.board.receive(os.read(ours, 4096))
        bench.board.advance(0.05)
        assert [bench.board.duty(port) for port in (0, 1)] == [0, 0]
    finally:
        os.close(ours)
        os.close(theirs)


def test_without_a_port_stopping_fails_in_one_line(tmp_path, capsys) -> None:
    assert main(["stop-motors", "--serial-port", str(tmp_path / "none")]) == 1
    said = capsys.readouterr().err
    assert "there is no serial port" in said
    assert said.count("\n") == 1
