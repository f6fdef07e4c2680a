"""``brickpose emulate-hat`` in a process of its own, for programs that open its serial port."""

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
        """The answer to a command.

        Raises:
            ValueError: it answers with an error.
        """
        (answer,) = self._answers(line)
        return answer

    def pose(self) -> tuple[float, list[float]]:
        """Where the robot is: x, y [m], theta, and when that was [s].

        The time goes as the clock on the wall does, from a zero of the board's; both are of one
        turn of the emulator, however late it takes it.
        """
        state, truth = self._answers("state", "truth")
        now, *_, lost = state.split("; ")
        stamp = float(now.removeprefix("now ")) + float(lost.removeprefix("lost "))
        return stamp, [float(word) for word in truth.split()]

    def _answers(self, *lines: str) -> list[str]:
        """To commands that are sent together."""
        with socket.socket(socket.AF_UNIX) as connection:
            connection.settimeout(ANSWER_S)
            connection.connect(str(self.control))
            connection.sendall("".join(f"{line}\n" for line in lines).encode())
            told = connection.makefile()
            answers = [told.readline().rstrip("\n") for _ in lines]
        for line, answer in zip(lines, answers, strict=True):
            if answer.startswith("error"):
                raise ValueError(f"{line}: {answer}")
        return answers

    def motors(self) -> tuple[float, list[float]]:
        """The board's time [s], and how fast the motors at its ports turn [degree/s]."""
        now, _, _, *ports, _ = self.ask("state").split("; ")
        plugged = [words for words in map(str.split, ports) if words[1] != "-"]
        return float(now.removeprefix("now ")), [abs(float(words[3])) for words in plugged]

    def cpu_seconds(self) -> float:
        """Processor time that it has used [s], as Linux counts it."""
        fields = Path(f"/proc/{self.process.pid}/stat").read_text().rpartition(")")[2].split()
        return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


@contextmanager
def emulated_hat(folder: Path, *options: str) -> Iterator[EmulatedHat]:
    """Start one with its names in a folder, and end it as a service is ended.

    Raises:
        RuntimeError: it does not start, or does not end with 0.
    """
    device, control = folder / "hat", folder / "hands"
    names = ("--link", str(device), "--control", str(control))
    with started("emulate-hat", *options, *names, says="^(Build HAT) at ") as (process, _):
        yield EmulatedHat(device, control, process)
    check_ended_well(process)
