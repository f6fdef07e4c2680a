"""Benchmark of the tracking error, and of the recovery after a wrong pose."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from app.engine.build import build_program
from app.engine.program import LocalProgram
from app.engine.snapshot import Snapshot
from app.features.lab.evaluation.runs import time_to_converge
from app.messages.commands import SetPoseCommand
from app.messages.driving_commands import FigureEightCommand
from app.settings.config import Config
from benchmarks.result import Result
from robot.geometry import Pose2

SEEDS = range(12)
"""Parameters were chosen on seeds from 100 on."""

WRONG = Pose2(-0.1, -0.1, 0.3)
"""Error of the wrong pose, in the map's axes, as in the paper [m, m, rad]."""

BEFORE = 0.1
"""Time from the start to the wrong pose [s]. Then a single wall is in sight, which is hard: a
second later a corner is in sight, and the pose would be right again after 0.1 s."""

WATCHED = 9.0
"""Time on the figure-eight after the wrong pose [s]."""


@dataclass(frozen=True)
class RecoveryRun:
    """One robot's run."""

    seconds: float
    """Time until the estimate is within 20 mm and 0.1 rad for a second [s]; inf if never."""
    error: float
    """Mean distance of the estimate from the truth, from a second after that on [m]."""
    odometry_error: float
    """The same for dead reckoning alone [m]."""


def recover(seed: int) -> RecoveryRun:
    """Give a robot with the default imperfections a wrong pose while it drives."""
    program = build_program(Config(robot="sim", seed=seed))
    start = _drive(program, BEFORE)[-1]
    assert start.truth is not None
    command = SetPoseCommand(
        type="set_pose",
        x=start.truth.x + WRONG.x,
        y=start.truth.y + WRONG.y,
        theta=start.truth.theta + WRONG.theta,
    )
    program.engine.commands.put(command)
    shown = _drive(program, WATCHED)
    program.robot.close()
    seconds = _seconds(shown) + shown[0].stamp - start.stamp
    settled = [s for s in shown if s.stamp > start.stamp + seconds + 1]
    return RecoveryRun(
        seconds,
        _mean([s.pose for s in settled], settled),
        _mean([s.odometry for s in settled], settled),
    )


def measure() -> Result:
    """Measure twelve robots on the square: unaligned errors, with all imperfections."""
    runs = [recover(seed) for seed in SEEDS]
    seconds = [run.seconds for run in runs]
    return Result(
        unit="mm mean error while tracking",
        brickpose=1e3 * float(np.mean([run.error for run in runs])),
        peer={"odometry alone": 1e3 * float(np.mean([run.odometry_error for run in runs]))},
        more={
            "worst robot's mean error [mm]": 1e3 * max(run.error for run in runs),
            "recovered within 4 s, of 12": sum(s <= 4 for s in seconds),
            "recovery, median [s]": float(np.median(seconds)),
            "recovery, worst [s]": max(seconds),
        },
    )


def _seconds(shown: Sequence[Snapshot]) -> float:
    """Return the time [s] from the first snapshot until the estimate is right; inf if never."""
    offsets = np.array(
        [s.truth.offset_to(s.pose) if s.pose and s.truth else np.full(3, np.inf) for s in shown]
    )
    distances = np.hypot(offsets[:, 0], offsets[:, 1])
    return time_to_converge(np.array([s.stamp for s in shown]), distances, offsets[:, 2])


def _mean(poses: Sequence[Pose2 | None], shown: Sequence[Snapshot]) -> float:
    pairs = zip(poses, shown, strict=True)
    return float(np.mean([p.distance_to(s.truth) for p, s in pairs if p and s.truth]))


def _drive(program: LocalProgram, seconds: float) -> list[Snapshot]:
    shown = [program.engine.step()]
    while shown[-1].stamp < shown[0].stamp + seconds:
        program.engine.commands.put(FigureEightCommand(type="figure_eight"))
        shown.append(program.engine.step())
    return shown
