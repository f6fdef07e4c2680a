"""Drives a robot with each filter and model, and prints what compiled functions are called with."""

from __future__ import annotations

import sys
from typing import Any

from numba.core.dispatcher import Dispatcher

from app.engine.build import build_program
from app.engine.program import Program
from app.engine.snapshot import Snapshot
from app.features.navigation.messages import GoalMessage, NavigateCommand
from app.features.weighing.ray_profile import along_rays
from app.messages.commands import Command, ScatterCommand, SetParametersCommand, SetPoseCommand
from app.messages.driving_commands import FigureEightCommand
from app.settings.config import Config
from robot.localization.filter_kinds import FILTERS
from robot.localization.models.motion_models import MOTION_MODELS

SEARCH_TICKS = 150
"""Enough for the hypotheses to collect a short map, and to search for places twice."""
SETTLED_TICKS = 100
"""Enough to compare poses with odometry, which begins when the place is known for some time."""
TICKS = 8
"""A few pictures."""
ADDED = {"picture_odometry": {"enabled": True}}
GOALS = tuple(
    NavigateCommand(type="navigate", poses=[GoalMessage(x=x, y=0.1, theta=0.0)], planner=planner)
    for x, planner in ((0.1, "grid"), (-0.1, "lattice"))
)
JOURNEY_TICKS = 40
"""Enough to stand, and to plan a way."""
FIRST_USES: tuple[dict[str, Any], ...] = (
    *({"filter": name} for name in FILTERS),
    {"filter": "particles", "laser_model_type": "beam"},
    {"laser_model_type": "likelihood_field_prob", "do_beamskip": True},
    *({"robot_model_type": name} for name in MOTION_MODELS),
)
"""Parameter changes, one after another; each brings in code that was not used before."""


def drive(program: Program, ticks: int, *first: Command) -> Snapshot:
    """Send some commands, then drive the figure-eight; return the last snapshot."""
    for command in first:
        program.engine.commands.put(command)
    for _ in range(ticks):
        program.engine.commands.put(FigureEightCommand(type="figure_eight"))
        snapshot = program.engine.step()
    return snapshot


def where(snapshot: Snapshot) -> SetPoseCommand:
    """Return a command that sets the filter to the truth: some code runs only in a narrow cloud."""
    pose = snapshot.truth or snapshot.odometry
    return SetPoseCommand(
        type="set_pose", x=pose.x, y=pose.y, theta=pose.theta, sd_xy=0.002, sd_theta=0.01
    )


def drive_with_each() -> None:
    """Use every filter and model, as users do."""
    program = build_program(Config(robot="kinematic", added=ADDED))
    drive(program, SETTLED_TICKS)
    snapshot = drive(program, SEARCH_TICKS, ScatterCommand(type="scatter"))
    for values in FIRST_USES:
        change = SetParametersCommand(type="set_parameters", values=values)
        drive(program, TICKS, change, where(snapshot))
        snapshot = drive(program, TICKS, ScatterCommand(type="scatter"))
    if snapshot.filter.line_scan is not None:
        along_rays(snapshot.filter.line_scan)  # the page asks for it when the user looks at a ray
    program.engine.commands.put(where(snapshot))
    for goal in GOALS:
        program.engine.commands.put(goal)
        for _ in range(JOURNEY_TICKS):
            program.engine.step()
    # Without a place, a robot with a goal looks around.
    found = SetParametersCommand(type="set_parameters", values={"filter": "hypotheses"})
    for command in (found, ScatterCommand(type="scatter"), GOALS[0]):
        program.engine.commands.put(command)
    for _ in range(SEARCH_TICKS):
        program.engine.step()
    program.robot.close()


def called() -> set[tuple[str, str]]:
    """The compiled functions that Python has called, each with its arguments' types."""
    functions = [
        (f"{name}.{own}", value)
        for name, module in list(sys.modules.items())
        if name.split(".")[0] in ("app", "robot", "sim")
        for own, value in vars(module).items()
        if isinstance(value, Dispatcher) and value.py_func.__module__ == name
    ]
    return {(name, str(types)) for name, value in functions for types in value.signatures}


if __name__ == "__main__":
    drive_with_each()
    for name, types in sorted(called()):
        print(name, types, sep="\t")
