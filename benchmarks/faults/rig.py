"""A program on an emulated board, with all that can be taken away from it."""

from __future__ import annotations

import contextlib
import json
import os
import shutil
import socket
import subprocess
import sys
import threading
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from websockets.sync.connection import Connection

from app.settings.config import ROOT
from benchmarks.hat.emulated_hat import EmulatedHat, emulated_hat
from benchmarks.programs import ServedProgram, check_ended_well, server

DISK_MB = 32


@dataclass
class Rig:
    """A running program, and what a fault may touch."""

    hat: EmulatedHat
    program: ServedProgram
    live: Connection
    camera: CameraCable
    recordings: Path
    disk: bool
    """Whether the recordings have a small disk of their own."""
    clients: list[subprocess.Popen[str]] = field(default_factory=list)
    """Viewers in processes of their own, to be killed at the end of their fault."""
    sockets: list[socket.socket] = field(default_factory=list)
    """Connections that say nothing."""
    killed: int | None = None
    """The process of ROS 2 that was killed last."""

    def ask(self, **command: Any) -> dict[str, Any]:
        """Send a command and return its answer."""
        self.live.send(json.dumps({"id": "soak", **command}))
        while True:
            message: dict[str, Any] = json.loads(self.live.recv(timeout=30))
            if message.get("id") == "soak":
                return message

    def start_viewers(self, count: int) -> None:
        """Start viewers of everything that the page shows."""
        words = ("-m", "benchmarks.viewers", self.program.address, str(count), "600")
        process = subprocess.Popen(
            [sys.executable, *words],
            cwd=ROOT,
            text=True,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
        )
        assert process.stdout is not None
        process.stdout.readline()
        self.clients.append(process)

    def dds_process(self) -> int | None:
        """Return the process that speaks DDS; None while there is none."""
        children: list[str] = []
        for thread in Path(f"/proc/{self.program.process.pid}/task").iterdir():
            with contextlib.suppress(OSError):  # the thread has just ended
                children += (thread / "children").read_text().split()
        return int(children[0]) if children else None

    def forget_recordings(self) -> None:
        """Delete all recordings."""
        for path in self.recordings.iterdir():
            shutil.rmtree(path) if path.is_dir() else path.unlink()


class CameraCable:
    """Hands the emulator's pictures on, as long as it is plugged in."""

    def __init__(self, source: Path, end: Path) -> None:
        self._source = source
        self._plugged = threading.Event()
        self._plugged.set()
        self._listening = socket.socket(socket.AF_UNIX)
        self._listening.bind(str(end))
        self._listening.listen()
        threading.Thread(target=self._run, name="camera cable", daemon=True).start()

    def plug(self) -> None:
        """Let pictures through again."""
        self._plugged.set()

    def unplug(self) -> None:
        """End the connection, and refuse others."""
        self._plugged.clear()

    def _run(self) -> None:
        while True:
            program, _ = self._listening.accept()
            if self._plugged.is_set():
                with contextlib.suppress(OSError):
                    self._pass_on(program)
            program.close()

    def _pass_on(self, program: socket.socket) -> None:
        with socket.socket(socket.AF_UNIX) as camera:
            camera.connect(str(self._source))
            camera.settimeout(0.5)
            while self._plugged.is_set():
                with contextlib.suppress(TimeoutError):
                    part = camera.recv(1 << 20)
                    if not part:
                        return
                    program.sendall(part)


@contextlib.contextmanager
def rig(folder: Path, seed: int) -> Iterator[Rig]:
    """Start the board, the program with ROS 2, and the cable between them."""
    recordings = folder / "recordings"
    recordings.mkdir()
    with small_disk(recordings) as disk:
        pictures, end = folder / "pictures.sock", folder / "camera.sock"
        config = folder / "soak.toml"
        config.write_text(f"[recording]\nfolder = {json.dumps(str(recordings))}\n")
        world = ("--world", "sim", "--pictures", str(pictures), "--seed", str(seed))
        with emulated_hat(folder, *world) as hat:
            camera = CameraCable(pictures, end)
            words = ("--serial-port", str(hat.device), "--camera", str(end), "--seed", str(seed))
            options = ("--robot", "buildhat", "--config", str(config), "--ros2", *words)
            with server(*options) as program, program.live() as live:
                yield Rig(hat, program, live, camera, recordings, disk)
            check_ended_well(program.process)


@contextlib.contextmanager
def small_disk(folder: Path) -> Iterator[bool]:
    """Mount a small disk on a folder, if this user may; yields whether it is there."""
    mounted = os.geteuid() == 0 and _mount("-t", "tmpfs", "-o", f"size={DISK_MB}m", "tmpfs", folder)
    try:
        yield mounted
    finally:
        if mounted:
            subprocess.run(["umount", "--lazy", str(folder)], check=False)


def _mount(*words: str | Path) -> bool:
    command = ["mount", *map(str, words)]
    return subprocess.run(command, check=False, stderr=subprocess.DEVNULL).returncode == 0
