"""Benchmark of the age of a wheel's position when the filter gets it, and of the stamp's error.

It uses the emulated board's clock. In between are the motors' own sampling, the board's reports and
the wire at 115200 baud. The program reads fifty times per second.
"""

from __future__ import annotations

import math

import numpy as np

from benchmarks.hat.bricks import Bricks
from benchmarks.result import Result
from robot.geometry import Array

READ_MS = 20
SECONDS = 4.0
SPEED = 500.0
"""[degree/s]: one degree, the step of the motors' encoders, takes 2 ms."""


def measure() -> Result:
    """Measure ages at the moment of reading, over phases of the motors and the program."""
    runs = [ages(motor, program) for motor in range(0, 10, 3) for program in range(1, 20, 4)]
    true, error = (np.concatenate([run[:, column] for run in runs]) for column in (0, 1))
    return Result(
        unit="ms from an encoder's sample to the filter, mean",
        brickpose=1e3 * float(true.mean()),
        more={
            "99 % within [ms]": 1e3 * float(np.quantile(true, 0.99)),
            "told stamp minus true one, mean [ms]": 1e3 * float(error.mean()),
            "told stamp minus true one, standard deviation [ms]": 1e3 * float(error.std()),
        },
    )


def ages(motor_ms: int, program_ms: int) -> Array:
    """Return (n, 2): the true age of the positions that were read, and the stamp's error [s].

    The clocks of the motors drift, so within a few seconds all phases occur.
    """
    bricks = Bricks()
    bricks.run(1e-3 * motor_ms)
    bricks.until(bricks.ready)
    zero = bricks.board.state(bricks.now).positions
    turned = np.array([bricks.motor(port).angle for port in (0, 1)])
    bricks.wanted = np.radians([SPEED, SPEED])
    history = [bricks.run(1.0 + 1e-3 * program_ms)]
    samples = []
    for _ in range(round(1e3 * SECONDS / READ_MS)):
        history.append(bricks.run(1e-3 * READ_MS))
        state = bricks.board.state(bricks.now)
        rows = np.concatenate(history[-10:])
        for index, direction in enumerate((-1, 1)):
            angle = direction * math.degrees(state.positions[index] - zero[index]) + turned[index]
            # The shaft turns in one direction, so each angle belongs to one moment.
            path = direction * rows[:, 3 + index]
            moment = float(np.interp(direction * angle, path, rows[:, 0]))
            samples.append((bricks.now - moment, state.stamp - moment))
    return np.array(samples)
