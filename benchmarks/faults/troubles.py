"""The troubles: how each begins, how it ends, and whether the motors must stop."""

from __future__ import annotations

import os
import signal
import socket
from collections.abc import Callable
from dataclasses import dataclass

from benchmarks.faults.rig import Rig
from benchmarks.programs import Telemetry, until

Act = Callable[[Rig], None]

IDLE_SOCKETS = 60

DDS_S = 30.0
"""The process of ROS 2 is back within this time, by the robot's clock [s]."""


@dataclass(frozen=True)
class Trouble:
    """One kind of fault."""

    name: str
    begin: Act
    end: Act | None
    stops: bool = False
    """Whether the motors must stop."""
    needs_disk: bool = False
    """Whether the recordings must have a small disk of their own."""


def _board(name: str, begin: str, end: str | None, *, stops: bool = True) -> Trouble:
    """A fault of the board, by lines that a person's hands would be."""

    def act(line: str) -> Act:
        def ask(rig: Rig) -> None:
            rig.hat.ask(line)

        return ask

    return Trouble(name, act(begin), act(end) if end else None, stops)


def _end_clients(rig: Rig) -> None:
    for process in rig.clients:
        process.kill()
        process.communicate()
    rig.clients.clear()


def _hang(rig: Rig) -> None:
    rig.start_viewers(2)
    rig.clients[-1].send_signal(signal.SIGSTOP)


def _plug_camera(rig: Rig) -> None:
    rig.camera.plug()
    until(rig.live, lambda message: not any("camera" in text for text in message["problems"]), 30)


def _open_idle(rig: Rig) -> None:
    host, _, port = rig.program.address.rpartition(":")
    rig.sockets += [socket.create_connection((host, int(port))) for _ in range(IDLE_SOCKETS)]


def _close_idle(rig: Rig) -> None:
    for connection in rig.sockets:
        connection.close()
    rig.sockets.clear()


def _kill_dds(rig: Rig) -> None:
    rig.killed = rig.dds_process()
    if rig.killed is not None:
        os.kill(rig.killed, signal.SIGKILL)


def _await_dds(rig: Rig) -> None:
    """Wait until another process speaks DDS; it is started after some seconds."""
    until(rig.live, lambda message: rig.dds_process() not in (None, rig.killed), DDS_S)


def _no_recording(message: Telemetry) -> bool:
    return not (message["recording"] and message["recording"]["running"])


def _begin_recording(rig: Rig) -> None:
    rig.ask(type="record", on=True)


def _end_recording(rig: Rig) -> None:
    rig.ask(type="record", on=False)
    until(rig.live, _no_recording)
    rig.forget_recordings()


def _fill_disk(rig: Rig) -> None:
    _begin_recording(rig)
    filler = rig.recordings / "filler"
    # Without a buffer, whose rest could not be written when the file is closed.
    with filler.open("wb", buffering=0) as file:
        try:
            while True:
                file.write(bytes(1 << 16))
        except OSError:
            pass
    until(rig.live, _no_recording)


def _change_parameters(rig: Rig) -> None:
    rig.ask(type="set_parameters", values={"filter.max_particles": 300})
    rig.ask(type="scatter")


def _reset(rig: Rig) -> None:
    rig.ask(type="reset")


TROUBLES = (
    _board("left motor unplugged", "unplug A", "plug A"),
    _board("right motor unplugged", "unplug B", "plug B"),
    _board("wheel blocked", "stall B", "free B"),
    _board("motor power fault", "fault motor on", "fault motor off"),
    _board("port power fault", "fault port on", "fault port off"),
    _board("low supply", "supply 5.6", "supply 8"),
    _board("supply over 10 V", "supply 10.1", "supply 8", stops=False),
    _board("silent board", "silent on", "silent off"),
    _board("board restarts", "reset", None),
    _board("noise from the board", "garble 0.003", "garble 0", stops=False),
    _board("garbled bytes to the board", "garble-in 0.0005", "garble-in 0", stops=False),
    _board("bytes lost to the board", "lose 0.001", "lose 0", stops=False),
    _board("slow main loop", "late 20", None, stops=False),
    Trouble("camera unplugged", lambda rig: rig.camera.unplug(), _plug_camera),
    Trouble("viewers come and are killed", lambda rig: rig.start_viewers(2), _end_clients),
    Trouble("viewers hang", _hang, _end_clients),
    Trouble("idle connections", _open_idle, _close_idle),
    Trouble("ROS 2 process killed", _kill_dds, _await_dds),
    Trouble("recording", _begin_recording, _end_recording),
    Trouble("disk full while recording", _fill_disk, Rig.forget_recordings, needs_disk=True),
    Trouble("parameters changed, cloud scattered", _change_parameters, _reset),
)
