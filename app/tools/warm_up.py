"""Compiles what is compiled, so that the first start is quick: ``python -m app.tools.warm_up``.

The compiler works by the types of arguments, and the filters and models call its results with
many. So a robot is driven with each of them once, as people will.
"""

from __future__ import annotations

from typing import Any

from app.engine.build import build_program
from app.engine.program import Program
from app.engine.snapshot import Snapshot
from app.messages.commands import (
    Command,
    FigureEightCommand,
    ScatterCommand,
    SetParametersCommand,
    SetPoseCommand,
)
from app.settings.config import Config

SEARCH_TICKS = 150
"""Until the hypotheses have a short map, and have looked for places twice."""
TICKS = 8
"""A few pictures."""
FIRST_USES: tuple[dict[str, Any], ...] = (
    {"filter": "kalman"},
    {"filter": "grid"},
    {"filter": "particles", "laser_model_type": "beam"},
    {"laser_model_type": "likelihood_field_prob", "do_beamskip": True},
    {"robot_model_type": "omni"},
    {"robot_model_type": "velocity"},
    {"robot_model_type": "stationary"},
)
"""Parameters that bring in what was not used before, one after another."""


def drive(program: Program, ticks: int, *first: Command) -> Snapshot:
    """Drive the figure-eight, after some commands."""
    for command in first:
        program.engine.commands.put(command)
    for _ in range(ticks):
        program.engine.commands.put(FigureEightCommand(type="figure_eight"))
        snapshot = program.engine.step()
    return snapshot


def where(snapshot: Snapshot) -> SetPoseCommand:
    """Tells the filter the truth, for some of a model is asked only by a narrow cloud."""
    pose = snapshot.truth or snapshot.odometry
    return SetPoseCommand(
        type="set_pose", x=pose.x, y=pose.y, theta=pose.theta, sd_xy=0.002, sd_theta=0.01
    )


def warm_up() -> None:
    """Use all that is compiled at its first use."""
    program = build_program(Config(robot="kinematic"))
    drive(program, TICKS)
    snapshot = drive(program, SEARCH_TICKS, ScatterCommand(type="scatter"))
    for values in FIRST_USES:
        change = SetParametersCommand(type="set_parameters", values=values)
        drive(program, TICKS, change, where(snapshot))
        snapshot = drive(program, TICKS, ScatterCommand(type="scatter"))
    if snapshot.line_scan is not None:
        _ = snapshot.line_scan.response  # the page asks for it when a ray is looked at
    program.robot.close()


if __name__ == "__main__":
    warm_up()
