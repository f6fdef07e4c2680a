"""A robot that stands, and that nobody looks at, takes a picture a second; else all of them."""

from __future__ import annotations

from collections.abc import Iterator

import pytest
from engine_runs import kinematic

from app.engine.program import Program
from app.engine.rest import STILL_M, VISIT_S, Audience, Standstill
from app.messages.commands import PlaceCommand, SetPoseCommand
from app.messages.driving_commands import DriveCommand
from robot.geometry import Pose2
from robot.interface import RESTING_PERIOD

USUAL_HZ = 25
"""Pictures a second of a camera that does not rest, at least."""


@pytest.fixture
def program() -> Iterator[Program]:
    made = kinematic()
    yield made
    made.robot.close()


def seconds(program: Program, duration: float) -> list:
    return [program.engine.step() for _ in range(round(50 * duration))]


def pictures(snapshots: list) -> int:
    """How many different pictures were scanned."""
    return len({shown.filter.line_scan.scan.stamp for shown in snapshots if shown.filter.line_scan})


@pytest.fixture
def resting(program: Program) -> Program:
    program.engine.audience.leave()
    seconds(program, 3)
    return program


def test_the_camera_of_a_robot_that_nobody_looks_at_rests_and_all_else_goes_on(resting) -> None:
    before = resting.engine.latest.get()
    snapshots = seconds(resting, 5)
    assert 5 <= pictures(snapshots) <= 6
    assert {shown.integrity.state for shown in snapshots} == {before.integrity.state}
    assert not [shown for shown in snapshots if shown.problems.present]
    assert snapshots[-1].loop.frame_hz > USUAL_HZ
    assert before.pose.distance_to(snapshots[-1].pose) < 0.001


def test_who_made_the_engine_and_steps_it_sees_all_pictures(program) -> None:
    seconds(program, 3)
    assert pictures(seconds(program, 2)) > 2 * USUAL_HZ


@pytest.mark.parametrize("looking", ["audience", "recorder"])
def test_pictures_are_there_at_once_when_somebody_looks(resting, looking: str) -> None:
    engine = resting.engine
    with engine.audience.joined() if looking == "audience" else engine.every.subscribe(10):
        woken = seconds(resting, 1)
        assert pictures(woken[:6]) >= 2
        assert pictures(woken) > USUAL_HZ - 2
        assert not [shown for shown in woken if shown.problems.present]
        assert woken[-1].loop.frame_hz > USUAL_HZ
    seconds(resting, 1.1)
    assert pictures(seconds(resting, 3)) <= 4


@pytest.mark.parametrize(
    "command",
    [
        DriveCommand(type="drive", v=0.1, omega=0.0),
        SetPoseCommand(type="set_pose", x=0.0, y=0.0, theta=0.0),
        PlaceCommand(type="place", x=0.1, y=0.1, theta=0.3),
    ],
    ids=lambda command: command.type,
)
def test_what_changes_where_the_robot_is_or_may_be_wakes_it(resting, command) -> None:
    before = resting.engine.latest.get().filter.line_scan.scan.stamp
    resting.engine.commands.put(command)
    newest = seconds(resting, 0.24)[-1]
    # A new picture, and not that of the second: the robot has stood for whole seconds before.
    assert newest.filter.line_scan.scan.stamp > before
    assert newest.filter.line_scan.scan.stamp >= newest.stamp - 0.12
    assert not newest.problems.present


def test_a_robot_that_is_lost_and_stands_waits_for_the_next_picture_only(resting) -> None:
    resting.engine.localization.scatter()
    assert pictures(seconds(resting, 0.2)) >= 2


def test_a_camera_that_fails_while_it_rests_is_told_a_second_later(resting, monkeypatch) -> None:
    monkeypatch.setattr(resting.robot, "_frame", lambda: None)
    told = [shown.stamp for shown in seconds(resting, 4) if shown.problems.present]
    assert told[0] - resting.engine.controls.frame.stamp < RESTING_PERIOD + 0.6


def test_who_asks_once_looks_for_a_moment(monkeypatch) -> None:
    clock = [100.0]
    monkeypatch.setattr("app.engine.rest.time.monotonic", lambda: clock[0])
    audience = Audience()
    audience.leave()
    assert not audience.present
    audience.visit()
    assert audience.present
    clock[0] += VISIT_S
    assert not audience.present


def test_audiences_come_and_go() -> None:
    audience = Audience()
    audience.leave()
    with audience.joined(), audience.joined():
        assert audience.present
    assert not audience.present


def test_a_robot_that_creeps_does_not_stand() -> None:
    standing = Standstill()
    assert standing.seconds(Pose2(), 10.0) == 0
    assert standing.seconds(Pose2(0.9 * STILL_M), 11.0) == 1
    assert standing.seconds(Pose2(1.1 * STILL_M), 12.0) == 0
    assert standing.seconds(Pose2(1.1 * STILL_M, 0, 0.01), 13.0) == 0
    assert standing.seconds(Pose2(1.1 * STILL_M, 0, 0.01), 15.0) == 2
    # The clock was set back.
    assert standing.seconds(Pose2(1.1 * STILL_M, 0, 0.01), 3.0) == 0
