"""A robot drives to goals, and stops doing so for every reason that there is."""

from __future__ import annotations

import math
import threading
from collections.abc import Iterator
from dataclasses import replace

import pytest
from camera_sources import until
from engine_runs import run
from journeys import OTHER, PAGE, RENEW, JourneyBench, goal

from app.engine.build import build_program
from app.engine.commands import parse
from app.engine.snapshot import DrawnMap
from app.features.navigation.messages import CancelCommand, GoalMessage, NavigateCommand
from app.messages.commands import PauseCommand, ResumeCommand, ScatterCommand
from app.messages.driving_commands import DriveCommand, StopCommand, TakeCommand
from app.page.telemetry import TelemetryWriter
from app.settings.config import Config
from robot.errors import CommandError
from robot.geometry import Pose2, Twist2
from robot.navigation.planners import PlannerKind, find_way
from sim.real_time import RealTime
from sim.simulated import no_wait

FAR = goal(0.3, 0.2, 1.0)


@pytest.fixture
def bench() -> Iterator[JourneyBench]:
    made = JourneyBench()
    yield made
    made.close()


def test_no_tick_waits_for_a_way_where_robot_time_is_real_time(monkeypatch, bench):
    ready = threading.Event()

    def slow(free, start, end):
        assert ready.wait(30), "nobody wanted it"
        return find_way(free, start, end)

    kind = PlannerKind("slow", slow, ends=True)
    monkeypatch.setattr("app.features.navigation.choices.Choices.planner", lambda *_: kind)
    companions = dict(bench.program.engine._companions._each)
    companions["navigation"]._waits = False
    bench.send(goal(0.2, 0.1))
    shown = bench.go(1.0)
    assert {each.added["navigation"].state for each in shown} == {"planning"}
    assert {each.twist for each in shown} == {Twist2()}
    ready.set()
    until(lambda: bench.go(0.02) and bench.status.state == "driving")


@pytest.mark.parametrize("live", [False, True])
def test_a_simulated_robot_says_whether_somebody_waits_for_it(live):
    wait = RealTime() if live else no_wait
    program = build_program(Config(robot="kinematic", map="square"), wait)
    assert program.robot.in_real_time == live
    assert dict(program.engine._companions._each)["navigation"]._waits != live
    program.robot.close()


@pytest.mark.slow
@pytest.mark.parametrize("place", [(0.3, 0.2, 1.0), (-0.25, 0.3, -2.0), (-0.36, 0.0, math.pi)])
def test_it_arrives_within_a_millimetre_of_the_truth(bench, place):
    bench.send(goal(*place))
    shown = bench.go(60)
    assert bench.status.state == "arrived"
    assert bench.now.mode == "idle"
    run(bench.program, 0.2)
    truth = bench.program.engine.latest.get().truth
    assert truth.distance_to(Pose2(*place)) < 0.001
    assert abs(math.degrees(truth.turn_to(Pose2(*place)))) < 0.3
    assert {each.mode for each in shown[1:-1]} == {"navigate"}


@pytest.mark.slow
def test_telemetry_tells_how_far_it_is(bench):
    writer = TelemetryWriter(bench.program, bench.outlets)
    assert writer.message(bench.now).navigation is None
    bench.send(FAR)
    bench.go(2.0)
    told = writer.message(bench.now).navigation
    assert told.state == "driving"
    assert told.reason is None
    assert 0 < told.remaining_m < 0.4
    assert 0 < told.remaining_s < 10
    assert told.target is not None
    bench.go(60)
    told = writer.message(bench.now).navigation
    assert (told.state, told.remaining_m, told.remaining_s) == ("arrived", 0, 0)


@pytest.mark.slow
def test_a_robot_that_may_be_anywhere_looks_around_first_and_then_arrives():
    """It stood for ever: without a place there was no way, and without a way no looking around."""
    bench = JourneyBench(imperfect=True, map="stub")
    bench.program.engine.commands.put(ScatterCommand(type="scatter"))
    bench.now = bench.program.engine.step()
    bench.send(goal(0.1, -0.15, 0.0))
    looked = {each.added["navigation"].state for each in bench.go(2.0)}
    bench.go(40.0)
    bench.close()
    assert "waiting" in looked
    assert bench.status.state == "arrived"
    assert bench.now.truth.distance_to(Pose2(0.1, -0.15)) < 0.002


def test_a_journey_that_a_fault_ends_names_it(bench, monkeypatch):
    """A motor that did not turn for a moment ended it with: the robot was stopped."""
    bench.send(FAR)
    bench.go(1.0)
    read, blocked = bench.program.robot.read, ("The motor on port A does not turn.",)
    monkeypatch.setattr(
        bench.program.robot, "read", lambda: replace(read(), connected=False, faults=blocked)
    )
    bench.go(0.1)
    assert (bench.status.state, bench.status.reason) == ("canceled", *blocked)
    monkeypatch.undo()
    bench.go(0.1)
    bench.send(FAR)
    bench.go(1.0)
    assert bench.status.state == "driving"
    bench.send(StopCommand(type="stop"))
    bench.go(0.1)
    assert bench.status.reason == "the robot was stopped"


def test_a_journey_waits_for_a_robot_that_does_not_answer_for_a_moment(bench, monkeypatch):
    bench.send(FAR)
    bench.go(1.0)
    read = bench.program.robot.read
    monkeypatch.setattr(bench.program.robot, "read", lambda: replace(read(), connected=False))
    bench.go(0.3)
    assert bench.now.twist == Twist2()
    assert bench.status.active
    monkeypatch.undo()
    bench.go(60)
    assert bench.status.state == "arrived"
    assert bench.now.truth.distance_to(Pose2(0.3, 0.2)) < 0.002


def test_a_stop_ends_it_at_once_and_holds_for_all(bench):
    bench.send(FAR)
    bench.go(2.0)
    bench.send(StopCommand(type="stop"), OTHER)
    bench.go(0.04)
    assert bench.now.twist == Twist2()
    assert (bench.status.state, bench.status.reason) == ("canceled", "the robot was stopped")
    with pytest.raises(CommandError, match="a stop holds"):
        bench.send(FAR)
    bench.send(TakeCommand(type="take"))
    bench.send(FAR)
    bench.go(0.1)
    assert bench.status.state == "planning"


def test_a_cancel_ends_it_and_others_may_drive(bench):
    bench.send(FAR)
    bench.go(2.0)
    bench.send(CancelCommand(type="cancel"), OTHER)
    bench.go(0.04)
    assert bench.now.twist == Twist2()
    assert (bench.status.state, bench.status.reason) == ("canceled", "somebody canceled it")
    assert not bench.outlets.drivers.state.stopped
    bench.send(CancelCommand(type="cancel"))
    bench.go(0.04)
    assert bench.status.state == "canceled"


def test_another_way_of_driving_ends_it(bench):
    bench.send(FAR)
    bench.go(2.0)
    bench.send(DriveCommand(type="drive", v=0.1, omega=0.0))
    bench.go(0.04)
    assert bench.now.mode == "drive"
    assert bench.status.state == "canceled"
    assert "otherwise" in bench.status.reason


def test_somebody_else_may_not_drive_meanwhile(bench):
    bench.send(FAR)
    bench.go(1.0)
    for command in (DriveCommand(type="drive", v=0.1, omega=0.0), FAR):
        with pytest.raises(CommandError, match="page 1 drives"):
            bench.send(command, OTHER)


def test_a_page_that_is_closed_stops_it(bench):
    bench.send(FAR)
    bench.go(2.0)
    bench.outlets.drivers.leave(PAGE)
    bench.go(0.04)
    assert bench.now.twist == Twist2()
    assert bench.status.state == "canceled"


def test_it_stands_while_nothing_is_heard_goes_on_and_ends_after_five_seconds(bench):
    bench.send(FAR)
    bench.go(2.0)
    bench.go(0.5, renew=False)
    assert bench.now.twist == Twist2()
    assert bench.status.state == "waiting"
    assert "nothing is heard" in bench.status.reason
    bench.go(0.5)
    assert bench.status.state == "driving"
    bench.go(4.5, renew=False)
    assert bench.now.twist == Twist2()
    assert bench.status.state == "waiting"
    bench.go(1.0, renew=False)
    assert bench.status.state == "canceled"
    assert bench.now.mode == "idle"


@pytest.mark.slow
def test_another_goal_takes_the_place_of_the_first(bench):
    bench.send(FAR)
    bench.go(2.0)
    bench.send(goal(-0.2, -0.1, 0.5))
    bench.go(60)
    assert bench.status.state == "arrived"
    assert bench.now.truth.distance_to(Pose2(-0.2, -0.1)) < 0.001


@pytest.mark.slow
def test_several_goals_are_driven_to_one_after_the_other(bench):
    poses = [GoalMessage(x=0.2, y=0.0), GoalMessage(x=0.2, y=0.2, theta=1.5)]
    bench.send(NavigateCommand(type="navigate", poses=poses))
    at = [each.added["navigation"].number for each in bench.go(60) if "navigation" in each.added]
    assert sorted(set(at)) == [0, 1]
    assert bench.status.state == "arrived"
    # The tolerance of 1 mm is by the estimate, which errs by some tenths itself.
    assert bench.now.truth.distance_to(Pose2(0.2, 0.2)) < 0.0013


@pytest.mark.parametrize(
    ("place", "words"),
    [
        ((0.5, 0.0, 0.0), "would stand on a wall"),
        ((0.402, 0.0, 0.0), "nearer to a wall than 8 mm"),
        ((3.0, 0.0, 0.0), "beyond the field; valid is x -0.750 to 0.750"),
        ((3.0, 0.0, None), "beyond the field"),
    ],
)
def test_a_goal_where_it_cannot_be_is_refused_and_the_robot_stands(bench, place, words):
    with pytest.raises(CommandError, match=words):
        bench.send(goal(*place))
    bench.go(0.2)
    assert bench.status is None
    assert bench.now.mode == "idle"


def test_a_goal_without_a_way_fails_and_says_why(bench):
    bench.send(goal(0.63, 0.0, None))
    bench.go(2.0)
    assert bench.status.state == "failed"
    assert bench.status.reason
    assert bench.now.mode == "idle"
    assert bench.now.twist == Twist2()


@pytest.mark.parametrize("x", ["NaN", "1e999", '"0.1"', "null"])
def test_what_is_no_number_is_no_goal(x):
    with pytest.raises(CommandError):
        parse('{"type": "navigate", "poses": [{"x": ' + x + ', "y": 0}]}')


def test_nothing_to_drive_to_is_no_command():
    with pytest.raises(CommandError):
        parse('{"type": "navigate", "poses": []}')


def test_while_the_filter_is_paused_there_is_no_journey(bench):
    bench.send(PauseCommand(type="pause"))
    bench.go(0.1)
    with pytest.raises(CommandError, match="the filter is paused"):
        bench.send(FAR)
    bench.send(ResumeCommand(type="resume"))
    bench.go(0.1)
    bench.send(FAR)


def test_a_filter_that_is_paused_ends_a_journey_and_the_robot_stands(bench):
    bench.send(FAR)
    bench.go(2.0)
    bench.send(PauseCommand(type="pause"))
    bench.go(0.1)
    assert (bench.status.state, bench.status.reason) == ("canceled", "the filter was paused")
    bench.go(0.1)
    assert bench.now.mode == "idle"
    assert bench.now.twist == Twist2()


def test_a_map_that_is_begun_ends_a_journey(bench):
    bench.send(FAR)
    bench.go(1.0)
    bench.program.engine.drawn.put(DrawnMap(1.0, bench.program.field.occupancy(0.05), Pose2()))
    bench.go(0.04)
    with pytest.raises(CommandError, match="a map is drawn"):
        bench.send(RENEW)
    bench.go(0.1, renew=False)
    assert bench.status.state == "canceled"
    assert bench.now.mode == "idle"


def test_while_a_map_is_drawn_there_is_no_journey(bench):
    grid = bench.program.field.occupancy(0.05)
    bench.program.engine.drawn.put(DrawnMap(1.0, grid, Pose2()))
    bench.go(0.1)
    with pytest.raises(CommandError, match="a map is drawn"):
        bench.send(FAR)


def test_a_robot_without_a_journey_shows_nothing_and_its_camera_may_rest(bench):
    bench.go(0.2)
    assert "navigation" not in bench.now.added
    assert not bench.program.engine._companions.need_pictures
    bench.send(RENEW)
    bench.go(0.2)
    assert bench.now.mode == "idle"
