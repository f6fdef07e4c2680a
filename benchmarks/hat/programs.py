"""Run ``brickpose run --robot buildhat`` on an emulated board with a simulated robot."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from benchmarks.hat.emulated_hat import EmulatedHat, emulated_hat
from benchmarks.programs import ServedProgram, check_ended_well, server


@contextmanager
def robot_in_bricks(
    folder: Path, seed: int, *options: str
) -> Iterator[tuple[EmulatedHat, ServedProgram]]:
    """Start an emulated board with pybullet's wheels and a rendered camera, and the program.

    Raises:
        RuntimeError: one of the two does not start, or does not end with 0.
    """
    eyes = folder / "eyes.sock"
    world = ("--world", "sim", "--pictures", str(eyes), "--seed", str(seed))
    with emulated_hat(folder, *world) as hat:
        robot = ("--robot", "buildhat", "--serial-port", str(hat.device), "--camera", str(eyes))
        with server(*robot, "--seed", str(seed), *options) as running:
            yield hat, running
        check_ended_well(running.process)
