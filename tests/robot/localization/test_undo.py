"""``undo`` restores exactly what was believed; faster than real time."""

import math

import numpy as np
import pytest
from engine_runs import EIGHT, drive, kinematic, run

from app.messages.commands import (
    PauseCommand,
    PlaceCommand,
    ScatterCommand,
    SetParametersCommand,
    SetParticlesCommand,
    SetPoseCommand,
    UndoCommand,
)
from robot.localization.estimate import State

ELSEWHERE = SetPoseCommand(type="set_pose", x=0.2, y=-0.3, theta=1.0)
CHANGES = (
    ELSEWHERE,
    SetParticlesCommand(type="set_particles", poses=[(0.1, 0.1, 0.0), (-0.2, 0.1, 1.0)]),
    ScatterCommand(type="scatter"),
)
UNDO = UndoCommand(type="undo")


def using(kind):
    return SetParametersCommand(type="set_parameters", values={"filter": kind})


def after_a_drive(kind="hypotheses"):
    program = kinematic(map="stub")
    program.engine.commands.put(using(kind))
    return program, run(program, 2.0, EIGHT)[-1]


def give(program, *commands):
    for command in commands:
        program.engine.commands.put(command)
    return program.engine.step()


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["hypotheses", "particles", "kalman", "grid"])
def test_after_an_undo_everything_is_as_if_nothing_had_been_changed(kind):
    (ours, before), (twin, _) = after_a_drive(kind), after_a_drive(kind)
    assert before.filter.undoable == 0
    give(ours, *CHANGES, UNDO, UNDO, UNDO)
    twin.engine.step()
    for some, others in zip(run(ours, 2.0, EIGHT), run(twin, 2.0, EIGHT), strict=True):
        assert (some.pose, some.integrity, some.filter.undoable) == (
            others.pose,
            others.integrity,
            0,
        )
        assert np.array_equal(some.filter.cloud.poses, others.filter.cloud.poses)


def test_odometry_moves_an_earlier_belief_to_where_the_robot_is_now():
    program, before = after_a_drive()
    assert before.integrity.state is State.CERTAIN
    give(program, PauseCommand(type="pause"), ELSEWHERE)
    away = run(program, 1.5, drive(v=0.1))[-1]
    assert away.filter.undoable == 1
    assert away.pose.distance_to(away.truth) > 0.1
    back = give(program, UNDO)
    assert back.truth.distance_to(before.truth) > 0.1
    assert back.pose.distance_to(back.truth) < 0.02
    assert math.isfinite(back.integrity.radius)


def test_another_filter_takes_over_what_was_believed():
    program, _ = after_a_drive("kalman")
    give(program, PauseCommand(type="pause"), ELSEWHERE)
    give(program, using("particles"), UNDO)
    after = run(program, 0.1)[-1]
    assert after.pose.distance_to(after.truth) < 0.02
    assert len(after.filter.cloud.weights) >= after.filter.parameters.filter.min_particles


def test_where_the_robot_was_put_elsewhere_there_is_nothing_to_undo():
    program, _ = after_a_drive()
    give(program, ELSEWHERE, PlaceCommand(type="place", x=0, y=0, theta=0))
    after = give(program, UNDO)
    assert after.filter.undoable == 0
    assert after.problems.record[-1].message == "There was nothing to undo."
