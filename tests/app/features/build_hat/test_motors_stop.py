"""However the program ends, the motors stop: real processes, timed by the board's clock."""

from __future__ import annotations

import json
import os
import signal
from contextlib import ExitStack
from pathlib import Path

import cv2
import httpx
import numpy as np
import pytest
from serving import ServedProgram, drive_until, serving, until

from benchmarks.hat.emulated_hat import EmulatedHat, emulated_hat

pytestmark = pytest.mark.real_time

STOP_S = 0.5
SPEED = 0.2
"""How fast the robot drives [m/s]."""


@pytest.fixture(scope="module")
def hat(tmp_path_factory):
    with emulated_hat(tmp_path_factory.mktemp("hat"), "--world", "free") as running:
        yield running


@pytest.fixture(scope="module")
def starts(hat, tmp_path_factory):
    """Starts a program on the board, or goes on with the one that still runs."""
    folder = tmp_path_factory.mktemp("pictures")
    cv2.imwrite(str(folder / "floor.png"), np.full((480, 640), 200, np.uint8))
    options = ("--robot", "buildhat", "--serial-port", str(hat.device), "--camera", str(folder))
    with ExitStack() as running:
        servers = {}

        def start(*form: str):
            if form not in servers or servers[form].process.poll() is not None:
                for other in servers.values():  # the port is one program's
                    other.process.terminate()
                    other.process.wait(15)
                servers.clear()
                servers[form] = running.enter_context(serving(*options, *form))
            return servers[form]

        yield start


@pytest.fixture
def form(request) -> tuple[str, ...]:
    """Options of ``run``: nothing is control in a process of its own."""
    return getattr(request, "param", ())


@pytest.fixture
def driven(hat, starts, form):
    """A program that drives, and a connection that keeps it driving while it is read from."""
    server = starts(*form)
    with server.live() as live:
        until(live, lambda now: now["robot"]["connected"])
        drive_until(live, SPEED, lambda now: now["twist"]["v"] > 0.95 * SPEED)
        drive_until(live, SPEED, lambda now: state(hat)[1] > 200)
        yield server, live


def state(hat: EmulatedHat) -> tuple[float, float]:
    """The board's time [s] and the speed of its fastest motor [degree/s]."""
    now, speeds = hat.motors()
    return now, max(speeds)


def control_of(server: ServedProgram) -> int:
    """Return the number of the process that controls the robot: a fork of the server."""
    process = Path(f"/proc/{server.process.pid}")
    children = [
        Path("/proc", child)
        for children in process.glob("task/*/children")
        for child in children.read_text().split()
    ]
    words = (process / "cmdline").read_bytes()
    (control,) = [child for child in children if (child / "cmdline").read_bytes() == words]
    return int(control.name)


def time_to_stop(hat: EmulatedHat, begin: float) -> float:
    """From a time of the board's until no motor turns [s]."""
    now, speed = state(hat)
    while speed > 1:
        assert now - begin < 5, "the motors go on"
        now, speed = state(hat)
    return now - begin


@pytest.mark.parametrize(
    ("trouble", "cure", "message"),
    [
        ("unplug A", "plug A", "No motor answers on port A"),
        ("fault motor on", "fault motor off", "motor power fault"),
        ("supply 5.8", "supply 8", "battery is low"),
        ("silent on", "silent off", "does not answer"),
        ("stall B", "free B", "port B (right_wheel_joint) does not turn"),
    ],
)
def test_trouble_at_the_board_stops_them_is_told_and_can_be_cured(
    hat, driven, trouble, cure, message
):
    server, live = driven
    hat.ask(trouble)
    try:
        begin, _ = state(hat)
        assert time_to_stop(hat, begin) < STOP_S
        # The command may have ended before a blocked wheel was noticed: it is given again.
        record = f"{server.url}/api/problems"
        drive_until(live, SPEED, lambda _: message in httpx.get(record).text)
    finally:
        hat.ask(cure)
    until(live, lambda now: now["robot"]["connected"] and not now["problems"])


def test_a_tab_that_is_closed_stops_them(hat, driven):
    _, live = driven
    live.close()
    begin, _ = state(hat)
    assert time_to_stop(hat, begin) < STOP_S


def test_a_network_that_is_lost_lets_them_stop(hat, driven):
    """The connection stays, and nothing comes any more."""
    _, live = driven
    live.send(json.dumps({"type": "drive", "v": SPEED, "omega": 0.0}))
    begin, _ = state(hat)
    assert time_to_stop(hat, begin) < STOP_S


@pytest.mark.parametrize("seconds", [0.3, 0.6, 1.0])
def test_a_program_that_hung_takes_no_wheel_for_blocked(hat, driven, seconds):
    server, live = driven
    begin, _ = state(hat)
    server.process.send_signal(signal.SIGSTOP)
    try:
        while state(hat)[0] < begin + seconds:
            pass
    finally:
        server.process.send_signal(signal.SIGCONT)
    problems = set()

    def has_driven_again(now):
        problems.update(now["problems"])
        return now["stamp"] > end

    end = until(live, lambda now: True)["stamp"] + seconds + 2
    drive_until(live, SPEED, has_driven_again)
    assert not [problem for problem in problems if "does not turn" in problem]
    drive_until(live, SPEED, lambda now: state(hat)[1] > 200)


@pytest.mark.parametrize("form", [(), ("--one-process",)], indirect=True)
def test_a_program_that_hangs_lets_them_stop(hat, driven):
    server, _ = driven
    server.process.send_signal(signal.SIGSTOP)
    begin, _ = state(hat)
    try:
        assert time_to_stop(hat, begin) < STOP_S
    finally:
        server.process.send_signal(signal.SIGCONT)


def test_a_control_process_that_hangs_lets_them_stop_and_goes_on(hat, driven):
    server, live = driven
    control = control_of(server)
    os.kill(control, signal.SIGSTOP)
    begin, _ = state(hat)
    try:
        assert time_to_stop(hat, begin) < STOP_S
    finally:
        os.kill(control, signal.SIGCONT)
    drive_until(live, SPEED, lambda now: state(hat)[1] > 200)


def test_a_control_process_that_is_killed_leaves_no_motor_turning_and_is_told(hat, driven):
    server, _ = driven
    os.kill(control_of(server), signal.SIGKILL)
    begin, _ = state(hat)
    assert time_to_stop(hat, begin) < STOP_S
    with server.live() as live:
        until(live, lambda now: "ended by SIGKILL" in " ".join(now["problems"]))
    server.process.terminate()
    server.process.wait(15)


@pytest.mark.parametrize("form", [(), ("--one-process",)], indirect=True)
@pytest.mark.parametrize("ending", [signal.SIGTERM, signal.SIGKILL])
def test_a_program_that_ends_leaves_no_motor_turning(hat, driven, ending):
    server, _ = driven
    server.process.send_signal(ending)
    begin, _ = state(hat)
    assert time_to_stop(hat, begin) < STOP_S
    server.process.wait(15)
