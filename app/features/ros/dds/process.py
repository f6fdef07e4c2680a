"""The DDS process, ``python -m app.features.ros.dds.process DESCRIPTOR``, which the program starts.

It ends when the program ends, for whatever reason: the socket to the program then closes.
"""

from __future__ import annotations

import gc
import signal
import socket
import sys
import threading
import time

from app.features.ros.dds.participant import Participant, WriteError
from app.features.ros.dds.protocol import (
    ALIVE,
    ALIVE_S,
    PLAN,
    READY,
    TROUBLE,
    WORDS,
    Frames,
    Plan,
    header,
)
from robot.worker_thread import WorkerThread

LONGEST_OUT = 64 * 1024 * 1024
LONGEST_IN = 16 * 1024
"""Longest command [bytes]: commands are short."""

PAUSE_S = 0.005
"""Pause after commands [s]: they are read at most 200 times a second, each time the newest."""


class ProgramConnection:
    """The connection to the program; any thread may send."""

    def __init__(self, end: socket.socket) -> None:
        self.end = end
        self._lock = threading.Lock()

    def send(self, number: int, payload: bytes = b"") -> None:
        """Send a message; waits while the program does not take any."""
        with self._lock:
            self.end.sendall(header(number, payload) + payload)


class CommandReader(WorkerThread):
    """Passes received messages to the program."""

    def __init__(self, participant: Participant, wire: ProgramConnection) -> None:
        super().__init__(
            "hearing",
            self._pass_on,
            owner="the DDS process",
            patience=ALIVE_S,
            wake=participant.wake,
        )
        self._participant = participant
        self._wire = wire

    def _pass_on(self, stopping: threading.Event) -> None:
        while not stopping.is_set():
            came = self._participant.heard(ALIVE_S)
            for number, data in came:
                self._hand_over(number, data)
            if came:
                stopping.wait(PAUSE_S)

    def _hand_over(self, number: int, data: bytes) -> None:
        if len(data) <= LONGEST_IN:
            self._wire.send(number, data)
        else:
            words = f"a message of {len(data)} bytes came; valid are up to {LONGEST_IN}"
            self._wire.send(TROUBLE, words.encode())


def main(descriptor: int) -> int:
    """Publish and receive until the program ends."""
    # The process ends by its socket. A service sends SIGTERM to all its processes: if that ended
    # this one first, the program would see it die.
    signal.signal(signal.SIGTERM, signal.SIG_IGN)
    wire = ProgramConnection(socket.socket(fileno=descriptor))
    frames = Frames(LONGEST_OUT)
    try:
        plan, rest = _plan(wire.end, frames)
        participant = Participant(plan)
        hearing = CommandReader(participant, wire)
        wire.send(READY)
        hearing.start()
        _publish(participant, wire, frames, rest, hearing)
        hearing.stop()
        # Cyclone's objects end when they are collected; then they tell the other participants.
        del hearing, participant
        gc.collect()
    except (BrokenPipeError, ConnectionResetError, EOFError):
        return 0  # the program has ended
    except Exception as error:
        wire.send(WORDS, f"{type(error).__name__}: {error}"[:2000].encode())
        return 1
    return 0


def _plan(end: socket.socket, frames: Frames) -> tuple[Plan, list[tuple[int, bytes]]]:
    """Receive the plan; return it, and the messages that arrived in one piece with it."""
    while data := end.recv(65536):
        came = list(frames.feed(data))
        if came:
            number, payload = came[0]
            if number != PLAN:
                raise ValueError(f"the plan comes first, not number {number}")
            return Plan.from_json(payload), came[1:]
    raise EOFError


def _publish(
    participant: Participant,
    wire: ProgramConnection,
    frames: Frames,
    rest: list[tuple[int, bytes]],
    hearing: CommandReader,
) -> None:
    wire.end.settimeout(ALIVE_S)
    clock = time.monotonic()
    for number, payload in rest:
        _write(participant, wire, number, payload)
    while True:
        try:
            data = wire.end.recv(262144)
        except TimeoutError:
            data = None
        if data == b"":
            return
        for number, payload in frames.feed(data or b""):
            _write(participant, wire, number, payload)
        if time.monotonic() - clock >= ALIVE_S:
            clock = time.monotonic()
            if not hearing.alive:
                raise RuntimeError("it no longer hears commands")
            wire.send(ALIVE)


def _write(participant: Participant, wire: ProgramConnection, number: int, payload: bytes) -> None:
    try:
        participant.write(number, payload)
    except WriteError as error:
        wire.send(TROUBLE, str(error).encode())


if __name__ == "__main__":
    sys.exit(main(int(sys.argv[1])))
