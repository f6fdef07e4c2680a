"""Planners and controllers of one's own: used, refused by line, taken anew when saved."""

from __future__ import annotations

import pytest
from journeys import JourneyBench, goal

from app.features.navigation.choices import Choices
from app.features.navigation.own_code import OwnController, OwnPlanner
from app.features.own_models.error_messages import OwnModelError
from app.settings.config import MAPS
from robot.description.spec import RobotSpec
from robot.errors import CommandError
from robot.fields.field_loading import load_field
from robot.geometry import Pose2, Twist2
from robot.navigation.free_space import FreeSpace
from robot.navigation.planning import NoWayError
from robot.navigation.settings import NavigationSettings

GOOD = """\
def corners(space, start, goal):
    return [(start.x, goal.y)]


def command(now):
    return now.ahead.v, now.ahead.omega
"""


@pytest.fixture
def file(tmp_path):
    path = tmp_path / "mine.py"
    path.write_text(GOOD)
    return path


@pytest.fixture(scope="module")
def free():
    return FreeSpace.of(load_field("square", MAPS), RobotSpec.load().outline, NavigationSettings())


def plan(file, free, goal=Pose2(0.25, 0.25)):
    return OwnPlanner(f"{file}:corners").plan(free, Pose2(), goal)


def test_its_corners_become_a_way(file, free):
    legs = plan(file, free)
    assert legs[-1].end.distance_to(Pose2(0.25, 0.25)) < 1e-6
    assert max(leg.poses[:, 1].max() for leg in legs) < 0.26
    assert all(free.fits(leg.poses) for leg in legs)


@pytest.mark.parametrize(
    ("code", "words"),
    [
        ("def corners(a, b, c):\n    return 1 / 0\n", "mine.py line 2: ZeroDivisionError"),
        (
            "def corners(a, b, c):\n    return [1, 2]\n",
            r"line 1: it gives the shape \(2,\)",
        ),
        ("def corners(a, b, c):\n    return 'here'\n", "mine.py line 1: it gives no array"),
        ("def corners(a, b, c):\n    return [(1e9, 0)]\n", "no finite numbers"),
        ("def corners(a b):\n", "mine.py line 1: SyntaxError"),
        ("x = 1\n", "there is no class corners"),
    ],
)
def test_what_is_wrong_is_named_by_its_line(file, free, code, words):
    file.write_text(code)
    with pytest.raises(OwnModelError, match=words):
        plan(file, free)


def test_a_way_through_a_wall_and_none_are_no_way(file, free):
    file.write_text("def corners(a, b, c):\n    return [(0.6, 0.0)]\n")
    with pytest.raises(NoWayError, match="too near to a wall at"):
        plan(file, free)
    file.write_text("def corners(a, b, c):\n    pass\n")
    with pytest.raises(NoWayError, match="corners finds no way"):
        plan(file, free)


@pytest.mark.parametrize(
    ("code", "words"),
    [
        ("def command(now):\n    return now.speed\n", "mine.py line 2: AttributeError"),
        ("def command(now):\n    pass\n", "mine.py line 1: it gives None"),
        ("def command(now):\n    return 1.0\n", "mine.py line 1: it gives 1.0; valid are v and"),
        ("def command(now):\n    return float('nan'), 0.0\n", "valid are finite numbers"),
    ],
)
def test_a_broken_controller_is_named_by_its_line(file, code, words):
    file.write_text(code)
    with pytest.raises(OwnModelError, match=words):
        OwnController(f"{file}:command").command(None)


def test_a_saved_file_is_taken_anew(file, monkeypatch):
    clock = iter(range(1000))
    monkeypatch.setattr("app.features.navigation.own_code.time.monotonic", lambda: next(clock))
    file.write_text("def command(now):\n    return 1 / 0\n")
    own = OwnController(f"{file}:command")
    with pytest.raises(OwnModelError):
        own.command(None)
    file.write_text("def command(now):\n    return 0.1, 0.25\n")
    with pytest.raises(OwnModelError):  # it may still be written
        own.command(None)
    assert own.command(None) == Twist2(0.1, 0.25)


def test_clients_choose_by_names_and_run_no_files(file):
    choices = Choices(NavigationSettings(planner=f"{file}:corners"))
    choices.require(None, None)
    choices.require("rrt", "pursuit")
    with pytest.raises(CommandError, match="there is no planner fast; valid are grid, lattice"):
        choices.require("fast", None)
    with pytest.raises(CommandError, match="there is no controller"):
        choices.require(None, f"{file}:command")


def test_a_journey_says_why_its_own_controller_fails_and_the_robot_stands(file):
    file.write_text("def command(now):\n    return now.speed\n")
    bench = JourneyBench(added={"navigation": {"controller": f"{file}:command"}})
    try:
        bench.send(goal(0.3, 0.0, None))
        bench.go(2.0)
        assert bench.status.state == "waiting"
        assert bench.status.reason.startswith("mine.py line 2: AttributeError")
        assert bench.now.twist == Twist2()
    finally:
        bench.close()


def test_an_unknown_planner_in_the_settings_is_refused_with_the_first_goal():
    bench = JourneyBench(added={"navigation": {"planner": "fast"}})
    try:
        with pytest.raises(CommandError, match="there is no planner fast; valid are grid"):
            bench.send(goal(0.3, 0.0, None))
    finally:
        bench.close()


ENDLESS = """\
import sys
import time


def command(now):
    while not hasattr(sys, "own_controllers_end"):
        time.sleep(0.001)
"""


def test_a_controller_that_never_returns_is_named_by_its_line_and_can_be_mended(file, monkeypatch):
    monkeypatch.setattr("app.features.navigation.own_code.HANGS_S", 0.2)
    file.write_text(ENDLESS)
    own = OwnController(f"{file}:command")
    try:
        with pytest.raises(OwnModelError, match=r"mine.py line [67]: .*this does not end"):
            own.command(None)
        monkeypatch.setattr("app.features.navigation.own_code.HANGS_S", 20.0)
        with pytest.raises(OwnModelError, match="this does not end"):  # it is not called again
            own.command(None)
        file.write_text("def command(now):\n    return 0.1, 0.25\n")
        clock = iter(range(10**6, 10**7))
        monkeypatch.setattr("app.features.navigation.own_code.time.monotonic", lambda: next(clock))
        with pytest.raises(OwnModelError):  # it may still be written
            own.command(None)
        assert own.command(None) == Twist2(0.1, 0.25)
    finally:
        monkeypatch.setattr("sys.own_controllers_end", True, raising=False)
