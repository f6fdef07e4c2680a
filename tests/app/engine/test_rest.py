"""A robot that stands, and that nobody looks at, costs less, and is there when somebody looks."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from engine_runs import kinematic

from app.engine.build import build_program
from app.engine.engine import FRAME_OVERDUE
from app.engine.program import Program
from app.engine.rest import (
    PAGE_HZ,
    RESTING_PERIOD,
    STILL_M,
    STILL_RAD,
    VISIT_S,
    WATCHED_PERIOD,
    Audience,
    Standstill,
)
from app.engine.snapshot import Snapshot
from app.messages.commands import PlaceCommand, SetPoseCommand
from app.messages.driving_commands import DriveCommand, FigureEightCommand, StopCommand
from app.settings.config import MAPS, Config
from robot.description.spec import RobotSpec
from robot.fields.field_loading import load_field
from robot.geometry import Pose2
from robot.interface import Reading
from robot.localization.estimate import State
from robot.scan import Scan
from sim.simulated import PERIOD

USUAL_HZ = 25
"""Pictures a second of a camera that does not rest, at least."""
RESTING_HZ, WATCHED_HZ = 1 / RESTING_PERIOD, 1 / WATCHED_PERIOD


class Unhurried:
    """A robot that cannot be told that its camera may rest, as a real one."""

    def __init__(self, robot) -> None:
        self._robot = robot
        self.name, self.spec = robot.name, robot.spec
        self.read, self.write, self.close = robot.read, robot.write, robot.close


@pytest.fixture
def program() -> Iterator[Program]:
    made = kinematic()
    yield made
    made.robot.close()


def seconds(program: Program, duration: float) -> list[Snapshot]:
    shown = [program.engine.step()]
    while shown[-1].stamp < shown[0].stamp + duration - 1e-9:
        shown.append(program.engine.step())
    return shown[1:]


def pictures(snapshots: list[Snapshot]) -> int:
    """How many different pictures were scanned."""
    return len({shown.filter.line_scan.scan.stamp for shown in snapshots if shown.filter.line_scan})


def rest(program: Program) -> Program:
    program.engine.audience.leave()
    seconds(program, 3)
    return program


@pytest.fixture
def resting(program: Program) -> Program:
    return rest(program)


@pytest.fixture(params=["told", "not told"])
def robots(request) -> Iterator[Program]:
    """A program whose robot is told that its camera may rest, and one whose robot is not."""
    first = kinematic()
    robot = first.robot if request.param == "told" else Unhurried(first.robot)
    made = build_program(first.config, robot=robot)
    yield rest(made)
    made.robot.close()


def test_the_camera_of_a_robot_that_nobody_looks_at_rests_and_all_else_goes_on(robots) -> None:
    before = robots.engine.latest.get()
    snapshots = seconds(robots, 5)
    assert 0.8 * RESTING_HZ * 5 <= pictures(snapshots) <= RESTING_HZ * 5 + 1
    assert {shown.integrity.state for shown in snapshots} == {before.integrity.state}
    assert not [shown for shown in snapshots if shown.problems.present]
    assert snapshots[-1].loop.frame_hz > USUAL_HZ
    assert before.pose.distance_to(snapshots[-1].pose) < 0.001


def test_a_simulation_that_rests_reads_five_times_a_second(resting) -> None:
    stamps = [shown.stamp for shown in seconds(resting, 2)]
    assert np.diff(stamps) == pytest.approx(RESTING_PERIOD)
    with resting.engine.audience.joined():
        woken = [shown.stamp for shown in seconds(resting, 2)][1:]
    assert np.diff(woken) == pytest.approx(PERIOD)


def test_a_page_sees_a_third_of_the_pictures_of_a_robot_that_stands(robots) -> None:
    with robots.engine.audience.joined(PAGE_HZ):
        seconds(robots, 1)
        snapshots = seconds(robots, 5)
    assert 0.7 * WATCHED_HZ * 5 <= pictures(snapshots) <= WATCHED_HZ * 5 + 1
    shown = [each.frame.stamp for each in snapshots]
    scanned = [each.filter.line_scan.scan.stamp for each in snapshots]
    assert shown == scanned  # a page draws edges on the picture that they were found in
    # It is as new as every picture, not one from before the rest.
    came = [after for before, after in pairwise(snapshots) if after.frame is not before.frame]
    assert max(each.stamp - each.frame.stamp for each in came) < 0.07
    assert snapshots[-1].loop.frame_hz > USUAL_HZ


@pytest.mark.parametrize("wanted", [0, 3])
def test_a_command_wakes_a_simulation_in_the_middle_of_its_rest(program, wanted: int) -> None:
    asked = iter(range(100))
    before = program.robot.read().stamp
    program.robot.rest(RESTING_PERIOD, lambda: next(asked) >= wanted)
    assert program.robot.read().stamp == pytest.approx(before + (wanted + 1) * PERIOD)
    program.robot.rest(0.0, bool)
    assert program.robot.read().stamp == pytest.approx(before + (wanted + 2) * PERIOD)


def test_who_made_the_engine_and_steps_it_sees_all_pictures(program) -> None:
    seconds(program, 3)
    assert pictures(seconds(program, 2)) > 2 * USUAL_HZ


@pytest.mark.parametrize("looking", ["audience", "recorder"])
def test_pictures_are_there_at_once_when_somebody_looks(robots, looking: str) -> None:
    engine = robots.engine
    with engine.audience.joined() if looking == "audience" else engine.every.subscribe(10):
        woken = seconds(robots, 1)
        assert pictures(woken[:8]) >= 3
        assert pictures(woken) > USUAL_HZ - 2
        assert not [shown for shown in woken if shown.problems.present]
        assert woken[-1].loop.frame_hz > USUAL_HZ
    seconds(robots, 0.1)
    assert pictures(seconds(robots, 3)) <= RESTING_HZ * 3 + 1


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
    resting.engine.commands.put(command)
    woken = seconds(resting, 0.5)
    assert pictures(woken) >= 0.3 * USUAL_HZ
    assert not [shown for shown in woken if shown.problems.present]


def test_a_robot_that_is_lost_and_stands_waits_for_the_next_picture_only(resting) -> None:
    resting.engine.localization.scatter()
    assert pictures(seconds(resting, 0.2)) >= 2


@pytest.mark.parametrize("kind", ["update_min_d", "update_min_a"])
def test_a_filter_that_learns_while_the_robot_stands_has_all_pictures(kind: str) -> None:
    config = Config(robot="kinematic", map="stub")
    always = replace(config.localization.filter, **{kind: 0.0})
    config = replace(config, localization=replace(config.localization, filter=always))
    program = rest(build_program(config))
    assert pictures(seconds(program, 1)) > USUAL_HZ - 2
    program.robot.close()


def test_a_camera_that_fails_while_it_rests_is_told_once_whoever_comes(
    resting, monkeypatch
) -> None:
    monkeypatch.setattr(resting.robot, "_frame", lambda: None)
    told = [shown.stamp for shown in seconds(resting, 2) if shown.problems.present]
    assert told[0] - resting.engine.controls.frame.stamp < FRAME_OVERDUE + RESTING_PERIOD
    count = resting.engine.latest.get().problems.count
    for _ in range(3):
        with resting.engine.audience.joined():
            assert all(shown.problems.present for shown in seconds(resting, 1))
        seconds(resting, 1)
    assert resting.engine.latest.get().problems.count == count


@pytest.mark.parametrize("turned", [0.3, -1.0, 2.5])
def test_a_robot_that_is_carried_off_while_it_rests_soon_claims_nothing(turned: float) -> None:
    program = kinematic(map="square")
    for _ in range(300):
        program.engine.commands.put(FigureEightCommand(type="figure_eight"))
        program.engine.step()
    program.engine.commands.put(StopCommand(type="stop"))
    rest(program)
    snapshot = program.engine.latest.get()
    assert snapshot.integrity.state is State.CERTAIN
    moved = snapshot.truth @ Pose2(0.05, 0.03, turned)
    program.robot.place(moved)
    after = seconds(program, 2)
    certain = [shown.stamp for shown in after if shown.integrity.state is State.CERTAIN]
    assert max(certain, default=snapshot.stamp) - snapshot.stamp < 0.5
    program.robot.close()


class LaserCart:
    """Stands in a room, and sends a scan forty times a second."""

    name = "cart"
    spec = RobotSpec.load()
    bearings = np.radians(np.arange(-180.0, 180.0, 4.0))

    def __init__(self) -> None:
        self.stamp = 0.0
        field = load_field("square", MAPS)
        (self.ranges,) = field.ranges(field.start.to_array()[None], self.bearings, range_max=2.0)

    def read(self) -> Reading:
        self.stamp += 0.025
        scan = Scan(self.stamp, self.bearings, self.ranges)
        return Reading(self.stamp, np.zeros(2), np.zeros(2), None, None, None, scan=scan)

    def write(self, velocities):
        return 0 * velocities

    def close(self) -> None:
        pass


def test_a_laser_rests_as_well() -> None:
    program = build_program(Config(map="square"), robot=LaserCart())
    used: list[float] = []
    follower = program.engine.controls.follower
    measure = follower.measure

    def noted(seen, odometry) -> None:
        used.append(seen.stamp)
        measure(seen, odometry)

    follower.measure = noted
    rest(program)
    program.engine.audience.join()
    used.clear()
    assert not [shown for shown in seconds(program, 2) if shown.problems.present]
    awake = len(used)
    program.engine.audience.leave()
    used.clear()
    assert not [shown for shown in seconds(program, 2) if shown.problems.present]
    assert len(used) < awake / 4


def test_who_asks_once_looks_for_a_moment(monkeypatch) -> None:
    clock = [100.0]
    monkeypatch.setattr("app.engine.rest.time.monotonic", lambda: clock[0])
    audience = Audience()
    audience.leave()
    assert audience.rate == 0
    audience.visit()
    assert audience.rate == PAGE_HZ
    clock[0] += VISIT_S
    assert audience.rate == 0


def test_audiences_come_and_go() -> None:
    audience = Audience()
    audience.leave()
    with audience.joined(), audience.joined():
        assert audience.rate > 0
    assert audience.rate == 0


def test_a_robot_that_creeps_does_not_stand() -> None:
    standing = Standstill()
    assert standing.seconds(Pose2(), 10.0) == 0
    assert standing.seconds(Pose2(0.9 * STILL_M), 11.0) == 1
    assert standing.seconds(Pose2(1.1 * STILL_M), 12.0) == 0
    assert standing.seconds(Pose2(1.1 * STILL_M, 0, 1.1 * STILL_RAD), 13.0) == 0
    assert standing.seconds(Pose2(1.1 * STILL_M, 0, 1.1 * STILL_RAD), 15.0) == 2
    # The clock was set back.
    assert standing.seconds(Pose2(1.1 * STILL_M, 0, 1.1 * STILL_RAD), 3.0) == 0
