"""Benchmark of the driver's processor time and serial traffic, with two motors, on the emulator.

The share of the processor is that of the driver's thread in the whole program, which drives the
figure-eight. Alone in a process, where the processor sleeps in between, the same work takes longer.
"""

from __future__ import annotations

import tempfile
import time
from pathlib import Path

import numpy as np
from websockets.sync.connection import Connection

from benchmarks.hat.emulated_hat import emulated_hat
from benchmarks.hat.programs import robot_in_bricks
from benchmarks.programs import estimated, telemetry, until
from benchmarks.result import Result
from robot.description.spec import RobotSpec
from robot.geometry import Array
from robot.hat.board import BoardDriver
from robot.hat.serial_link import THREAD, SerialLink
from robot.hat.settings import BuildHatSettings
from robot.hat.start.bring_up import BringUp

SECONDS = 20.0
PERIOD = 0.02
BAUD_BYTES = 11520
"""Bytes per second at 115200 baud."""

START_S = 30.0
WARM_S = 5.0


class Counted(BoardDriver):
    """A board that counts the bytes on the serial line."""

    sent = received = 0

    def receive(self, data: bytes, current: float) -> bytes:
        """Count received bytes, and those of the answer."""
        self.received += len(data)
        answer = super().receive(data, current)
        self.sent += len(answer)
        return answer

    def tick(self, current: float) -> bytes:
        """Count the bytes sent in one tick."""
        data = super().tick(current)
        self.sent += len(data)
        return data


def measure() -> Result:
    """Measure the share of a core of the driver's thread, and the traffic on the serial line."""
    share = _in_the_program()
    board = Counted(RobotSpec.load().joints, BuildHatSettings(), BringUp())
    with (
        tempfile.TemporaryDirectory() as folder,
        emulated_hat(Path(folder), "--world", "free") as hat,
    ):
        link = SerialLink(str(hat.device), board)
        link.start()
        try:
            _wait(board)
            begin, busy, sent, received = _counters(board)
            _drive(board, SECONDS)
            end, busy_then, sent_then, received_then = _counters(board)
        finally:
            link.close()
    passed = end - begin
    return Result(
        unit="% of a core for the driver's thread in the program",
        brickpose=share,
        more={
            "driver and its caller alone in a process [% of a core]": 100
            * (busy_then - busy)
            / passed,
            "serial line to the board [% of 115200 baud]": 100
            * (sent_then - sent)
            / passed
            / BAUD_BYTES,
            "serial line from the board [% of 115200 baud]": 100
            * (received_then - received)
            / passed
            / BAUD_BYTES,
        },
    )


def _in_the_program() -> float:
    """Return the thread's share of a core [%] while the robot drives the figure-eight."""
    with (
        tempfile.TemporaryDirectory() as folder,
        robot_in_bricks(Path(folder), 0) as (_, program),
        program.live() as live,
    ):
        until(live, estimated, START_S)
        _figure_eight(live, WARM_S)
        begin, busy = time.monotonic(), program.thread_seconds(THREAD)
        _figure_eight(live, SECONDS)
        passed = time.monotonic() - begin
        return 100 * (program.thread_seconds(THREAD) - busy) / passed


def _figure_eight(live: Connection, seconds: float) -> None:
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        live.send('{"type": "figure_eight"}')
        telemetry(live)


def _counters(board: Counted) -> tuple[float, float, int, int]:
    return time.monotonic(), time.process_time(), board.sent, board.received


def _wait(board: BoardDriver) -> None:
    deadline = time.monotonic() + START_S
    while not board.state(time.monotonic()).ready:
        if time.monotonic() > deadline:
            raise TimeoutError(f"not ready: {board.state(time.monotonic()).faults}")
        time.sleep(PERIOD)


def _drive(board: BoardDriver, seconds: float) -> None:
    """Command speeds that always change, as on a figure-eight, with the calls of the program."""
    begin = stamp = time.monotonic()
    while stamp < begin + seconds:
        board.command(_speeds(stamp - begin), stamp)
        board.state(stamp)
        time.sleep(PERIOD)
        stamp = time.monotonic()


def _speeds(elapsed: float) -> Array:
    return 5.0 + 2.0 * np.array([np.sin(elapsed), np.cos(1.3 * elapsed)])
