"""What the driver costs: processor and serial line, with two motors, on an emulated board."""

from __future__ import annotations

import tempfile
import time
from pathlib import Path

import numpy as np

from benchmarks.hat.emulated_hat import emulated_hat
from benchmarks.result import Result
from robot.description.spec import RobotSpec
from robot.geometry import Array
from robot.hat.board import Board
from robot.hat.serial_link import SerialLink
from robot.hat.settings import BuildHatSettings
from robot.hat.start.bring_up import BringUp

SECONDS = 20.0
PERIOD = 0.02
BAUD_BYTES = 11520
"""Bytes a second at 115200 baud."""

START_S = 10.0


class Counted(Board):
    """A board that counts what goes over the wire."""

    sent = received = 0

    def receive(self, data: bytes, now: float) -> bytes:
        """Bytes came."""
        self.received += len(data)
        answer = super().receive(data, now)
        self.sent += len(answer)
        return answer

    def tick(self, now: float) -> bytes:
        """A hundredth of a second passed."""
        found = super().tick(now)
        self.sent += len(found)
        return found


def measure() -> Result:
    """Share of one core that the link's thread and the program's calls take while driving."""
    board = Counted(RobotSpec.load().joints, BuildHatSettings(), BringUp())
    with (
        tempfile.TemporaryDirectory() as folder,
        emulated_hat(Path(folder), "--world", "free") as hat,
    ):
        link = SerialLink(str(hat.device), board)
        link.start()
        try:
            _wait(board)
            begin, busy, sent, received = _now(board)
            _drive(board, SECONDS)
            end, busy_then, sent_then, received_then = _now(board)
        finally:
            link.close()
    passed = end - begin
    return Result(
        unit="% of a core while both wheels drive",
        brickpose=100 * (busy_then - busy) / passed,
        more={
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


def _now(board: Counted) -> tuple[float, float, int, int]:
    return time.monotonic(), time.process_time(), board.sent, board.received


def _wait(board: Board) -> None:
    deadline = time.monotonic() + START_S
    while not board.state(time.monotonic()).ready:
        if time.monotonic() > deadline:
            raise TimeoutError(f"not ready: {board.state(time.monotonic()).faults}")
        time.sleep(PERIOD)


def _drive(board: Board, seconds: float) -> None:
    """Speeds that change all the time, as on a figure-eight, with the calls of the program."""
    begin = now = time.monotonic()
    while now < begin + seconds:
        board.command(_speeds(now - begin), now)
        board.state(now)
        time.sleep(PERIOD)
        now = time.monotonic()


def _speeds(now: float) -> Array:
    return 5.0 + 2.0 * np.array([np.sin(now), np.cos(1.3 * now)])
