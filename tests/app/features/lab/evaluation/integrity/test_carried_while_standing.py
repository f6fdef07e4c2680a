"""A robot that is carried off while it stands: its camera shows that something has changed."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np
import pytest

from app.engine.build import build_program
from app.engine.program import Program
from app.engine.snapshot import Snapshot
from app.features.lab.evaluation.integrity.claims import follow_claims
from app.features.lab.evaluation.integrity.drives import CARRY_STAMP, moved_drive
from app.features.lab.evaluation.integrity.measures import certain, longest, misleading
from app.messages.commands import Command, PauseCommand, PlaceCommand, ResumeCommand
from app.messages.driving_commands import FigureEightCommand, StopCommand
from app.settings.config import Config
from robot.geometry import Pose2
from robot.localization.estimate import BOUNDED, State

pytestmark = pytest.mark.slow

EIGHT = FigureEightCommand(type="figure_eight")
STOP = StopCommand(type="stop")
AWAY = Pose2(0.15, -0.1, 0.6)

Drive = Callable[[Command, float], Snapshot]


@pytest.fixture
def program() -> Iterator[Program]:
    """A robot that knows its place on the square, where each place has three others like it."""
    made = build_program(Config(robot="kinematic", map="square", seed=5))
    yield made
    made.robot.close()


@pytest.fixture
def drive(program: Program) -> Drive:
    """Gives a command again and again for a time [s]; returns the last snapshot."""

    def go(command: Command, seconds: float) -> Snapshot:
        snapshot = program.engine.step()
        end = snapshot.stamp + seconds
        while snapshot.stamp < end:
            program.engine.commands.put(command)
            snapshot = program.engine.step()
        return snapshot

    return go


def put(program: Program, pose: Pose2) -> None:
    x, y, theta = pose.to_array().tolist()
    program.engine.commands.put(PlaceCommand(type="place", x=x, y=y, theta=theta))


def true_pose(snapshot: Snapshot) -> Pose2:
    assert snapshot.truth is not None
    return snapshot.truth


def test_it_is_certain_no_more_and_again_when_it_is_put_back(
    program: Program, drive: Drive
) -> None:
    drive(EIGHT, 3.0)
    before = drive(STOP, 1.0)
    assert before.integrity.state is State.CERTAIN
    put(program, true_pose(before) @ AWAY)
    away = drive(STOP, 0.5)
    assert away.integrity.state is State.APPROXIMATE
    put(program, true_pose(before))
    assert drive(STOP, 0.5).integrity.state is State.CERTAIN
    # It was not away, as far as the filter is concerned.
    assert drive(EIGHT, 1.0).integrity.state is State.CERTAIN


def test_when_it_drives_on_it_may_be_at_any_place_that_looks_alike(
    program: Program, drive: Drive
) -> None:
    drive(EIGHT, 3.0)
    put(program, true_pose(drive(STOP, 1.0)) @ AWAY)
    drive(STOP, 0.5)
    last = drive(EIGHT, 6.0)
    assert last.integrity.state is State.AMBIGUOUS
    assert last.estimate is not None
    weights = [hypothesis.weight for hypothesis in last.estimate.hypotheses]
    assert weights == pytest.approx([0.25] * 4, abs=0.01)
    assert last.pose is not None
    turned = last.pose.to_array()[2] - true_pose(last).theta
    places = [Pose2(theta=turned).inverse() @ last.pose]
    assert places[0].distance_to(true_pose(last)) < 0.005


def test_what_it_drove_while_the_filter_was_paused_is_not_taken_for_a_move(
    program: Program, drive: Drive
) -> None:
    drive(EIGHT, 3.0)
    drive(PauseCommand(type="pause"), 0.1)
    drive(EIGHT, 2.0)
    drive(STOP, 0.5)
    drive(ResumeCommand(type="resume"), 0.1)
    drive(STOP, 0.5)
    assert drive(EIGHT, 1.0).integrity.state is State.CERTAIN


def test_on_a_field_without_symmetry_it_is_not_certain_of_a_wrong_place() -> None:
    config = Config(robot="sim", map="town", seed=5010)
    claims = follow_claims(moved_drive(config), config, "moved")
    assert longest(claims.stamps, misleading(claims)) < 0.3
    before = claims.stamps < CARRY_STAMP
    bounded = [state in BOUNDED for state in claims.states]
    assert np.mean(np.array(bounded)[before]) > 0.9
    assert certain(claims)[before].mean() > 0.5
