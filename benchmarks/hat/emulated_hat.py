"""Run ``brickpose emulate-hat`` in its own process, for programs that open its serial port."""

from __future__ import annotations

import os
import socket
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from benchmarks.programs import ANSWER_S, check_ended_well, started


@dataclass(frozen=True)
class EmulatedHat:
    """A running emulator."""

    device: Path
    """The serial port."""
    control: Path
    """The socket that takes commands."""
    process: subprocess.Popen[str]

    def ask(self, line: str) -> str:
        """Send a command and return the answer.

        Raises:
            ValueError: the answer is an error.
        """
        (answer,) = self._answers(line)
        return answer

    def pose(self) -> tuple[float, list[float]]:
        """Return the stamp [s] and the robot's pose: x, y [m], theta.

        The stamp runs like wall-clock time, from the board's own zero. Stamp and pose belong to the
        same cycle of the emulator, even if it runs late.
        """
        state, truth = self._answers("state", "truth")
        clock, *_, lost = state.split("; ")
        stamp = float(clock.removeprefix("now ")) + float(lost.removeprefix("lost "))
        return stamp, [float(word) for word in truth.split()]

    def _answers(self, *lines: str) -> list[str]:
        """Send commands together and return the answers."""
        with socket.socket(socket.AF_UNIX) as connection:
            connection.settimeout(ANSWER_S)
            connection.connect(str(self.control))
            connection.sendall("".join(f"{line}\n" for line in lines).encode())
            reader = connection.makefile()
            answers = [reader.readline().rstrip("\n") for _ in lines]
        for line, answer in zip(lines, answers, strict=True):
            if answer.startswith("error"):
                raise ValueError(f"{line}: {answer}")
        return answers

    def motors(self) -> tuple[float, list[float]]:
        """Return the board's time [s], and the speeds of the motors at its ports [degree/s]."""
        clock, _, _, *ports, _ = self.ask("state").split("; ")
        plugged = [words for words in map(str.split, ports) if words[1] != "-"]
        return float(clock.removeprefix("now ")), [abs(float(words[3])) for words in plugged]

    def cpu_seconds(self) -> float:
        """Return the processor time that it has used [s], as Linux counts it."""
        fields = Path(f"/proc/{self.process.pid}/stat").read_text().rpartition(")")[2].split()
        return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


@contextmanager
def emulated_hat(folder: Path, *options: str) -> Iterator[EmulatedHat]:
    """Start an emulator with its device and socket in a folder; end it as a service is ended.

    Raises:
        RuntimeError: the emulator does not start, or does not end with 0.
    """
    device, control = folder / "hat", folder / "hands"
    names = ("--link", str(device), "--control", str(control))
    with started("emulate-hat", *options, *names, says="^(Build HAT) at ") as (process, _):
        yield EmulatedHat(device, control, process)
    check_ended_well(process)
