"""Benchmark of a wheel's speed step: our control loop, and the two loops of the firmware.

The step is from 0 to 500 degrees/s, with two free medium motors that are up to 10 % faster or
slower than the driver expects, on the emulated board's clock. Then a blocked wheel is released.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from benchmarks.hat.bricks import MEDIUM, Bricks
from benchmarks.result import Result
from robot.geometry import Array
from robot.hat.protocol import commands
from sim.hat.motor_figures import MOTOR_FIGURES
from sim.hat.plants import FreeMotors

SPEED = 500.0
"""[degree/s]"""

GAINS = (0.9, 0.95, 1.0, 1.05, 1.1)
PHASES_MS = (1, 4, 8)
WITHIN = 0.05
WATCHED_S = 3.0
SMOOTH_MS = 20

FIRMWARE = {
    "firmware, speed mode": ("pid {0} 0 0 s1 1 0 0.003 0.01 0 100 0.01", 0.1),
    "firmware, angle gained": ("pid_diff {0} 0 5 s2 0.0027777778 1 0 2.5 0 .4 0.01", 1 / 360),
}
"""The firmware's two closed loops, as the official library sets them up: the command, and the
set-point per degree/s."""


@dataclass(frozen=True)
class SpeedStep:
    """One step of speed."""

    settled: float
    """Time after which the speed stays within 5 % [s]; the whole time if it never does."""
    overshoot: float
    """As a share of the commanded speed."""
    apart: float
    """Time between the starts of the left and the right wheel [s]."""


def measure() -> Result:
    """Measure the time until the speed is right, for all three loops."""
    ours = [our_step(gain, phase) for gain in GAINS for phase in PHASES_MS]
    theirs = {name: [firmware_step(name, gain) for gain in GAINS] for name in FIRMWARE}
    return Result(
        unit="s until within 5 % of 500 degrees/s, median",
        brickpose=_median([step.settled for step in ours]),
        peer={name: _median([step.settled for step in steps]) for name, steps in theirs.items()},
        more={
            "the motor as expected: settled, worst [s]": max(
                our_step(1.0, phase).settled for phase in range(10)
            ),
            "10 % faster or slower: settled, worst [s]": max(step.settled for step in ours),
            "overshoot, worst [%]": 100 * max(step.overshoot for step in ours),
            "left and right start apart, worst [ms]": 1e3 * max(step.apart for step in ours),
            "stands after a stop within, worst [degree]": max(drift(phase) for phase in PHASES_MS),
            **{
                f"{name}: overshoot, worst [%]": 100 * max(step.overshoot for step in steps)
                for name, steps in theirs.items()
            },
            "asked for 100 degrees/s, blocked for 3 s, let go: highest [degree/s]": freed(),
            **{f"{name}: the same": freed(name) for name in FIRMWARE},
        },
    )


def our_step(gain: float, phase_ms: int) -> SpeedStep:
    """Do a step with the driver's loop, called at a phase of the board's ticks."""
    bricks = bricks_with(gain, phase_ms)
    bricks.until(bricks.ready)
    bricks.wanted = np.zeros(2)
    bricks.run(0.2)
    bricks.wanted = np.radians([SPEED, SPEED])
    return judged(bricks.run(WATCHED_S))


def firmware_step(name: str, gain: float) -> SpeedStep:
    """Do a step with one of the firmware's loops, set up as the official library does."""
    bricks = bricks_with(gain, 3)
    firmware_drives(bricks, name, SPEED)
    return judged(bricks.run(WATCHED_S))


def firmware_drives(bricks: Bricks, name: str, speed: float) -> None:
    """Give the wheels to one of the firmware's loops, at a speed [degree/s]."""
    bricks.until(bricks.ready)
    bricks.alive = False  # the driver does nothing
    bricks.run(0.5)
    pid, unit = FIRMWARE[name]
    lines = [f"port {port};select 0;selrate 10;{pid.format(port)}" for port in (0, 1)]
    starts = [f"port {port};set {commands.fixed(speed * unit, 6)}" for port in (0, 1)]
    for text in (*lines, ";".join(starts)):
        bricks.emulated.receive(commands.line(text))


def drift(phase_ms: int) -> float:
    """Return how far a shaft still turns within 2 s after it stopped [degree]."""
    bricks = bricks_with(1.0, phase_ms)
    bricks.until(bricks.ready)
    bricks.wanted = np.radians([SPEED, SPEED])
    bricks.run(1.0)
    bricks.wanted = np.zeros(2)
    bricks.until(bricks.stands, 1.0)
    return float(np.ptp(bricks.run(2.0)[:, 3:], axis=0).max())


def freed(name: str | None = None) -> float:
    """Return the highest speed of a released wheel with 100 degrees/s commanded [degree/s]."""
    bricks = bricks_with(1.0, 3)
    if name is None:
        bricks.until(bricks.ready)
        bricks.wanted = np.radians([100.0, 100.0])
    else:
        firmware_drives(bricks, name, 100.0)
    bricks.motor(1).stalled = True
    bricks.run(3.0)
    bricks.motor(1).stalled = False
    return float(np.abs(bricks.run(2.0)[:, 2]).max())


def bricks_with(gain: float, phase_ms: int) -> Bricks:
    """Return two motors whose speed and acceleration differ from the usual ones by a factor."""
    figures = MOTOR_FIGURES[MEDIUM]
    fast = replace(
        figures,
        no_load_speed=gain * figures.no_load_speed,
        acceleration=gain * figures.acceleration,
    )
    return Bricks(plants=FreeMotors({0: fast, 1: fast}), phase_ms=phase_ms)


def judged(rows: Array) -> SpeedStep:
    """Return a step's figures from time and both speeds, with one row per millisecond."""
    speeds = np.abs(rows[:, 1:3])
    since = rows[:, 0] - rows[0, 0]
    window = np.ones(SMOOTH_MS) / SMOOTH_MS
    smooth = np.column_stack([np.convolve(c, window, "valid") for c in speeds.T])
    wrong = (np.abs(smooth / SPEED - 1) > WITHIN).any(axis=1)
    begins = [float(since[np.argmax(column > 5)]) for column in speeds.T]
    last = np.flatnonzero(wrong).max(initial=0)
    return SpeedStep(
        settled=float(since[min(last + SMOOTH_MS, len(since) - 1)]),
        overshoot=float(smooth.max() / SPEED - 1),
        apart=abs(begins[0] - begins[1]),
    )


def _median(values: Sequence[float]) -> float:
    return float(np.median(values))
