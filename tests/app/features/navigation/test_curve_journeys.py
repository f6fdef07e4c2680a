"""A robot drives along closed curves by its estimate, until somebody ends that."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest
from journeys import JourneyBench

from app.features.navigation.messages import (
    CancelCommand,
    CurveMessage,
    GoalMessage,
    NavigateCommand,
)
from robot.errors import CommandError
from robot.geometry import Pose2

ORIGIN = GoalMessage(x=0.0, y=0.0, theta=0.0)


@pytest.fixture
def bench() -> Iterator[JourneyBench]:
    made = JourneyBench(imperfect=True)
    yield made
    made.close()


def along(shape: str, **more) -> NavigateCommand:
    curve = CurveMessage(shape=shape, **more)
    return NavigateCommand(type="navigate", curve=curve, renewed=True)


@pytest.mark.slow
def test_the_truth_stays_on_the_closed_figure_eight_lap_after_lap(bench):
    bench.send(along("figure_eight", start=ORIGIN))
    bench.go(4.0)
    assert bench.status.state == "driving"
    assert bench.status.on_curve
    middles = ((0.0, 0.19), (0.0, -0.19))
    shown = bench.go(36.0)
    places = np.array([[each.truth.x, each.truth.y] for each in shown])
    off = np.min([np.abs(np.hypot(*(places - at).T) - 0.19) for at in middles], axis=0)
    assert np.sqrt(np.mean(off**2)) < 0.0008
    assert np.ptp(places[:, 1]) > 0.74
    bench.send(CancelCommand(type="cancel"))
    bench.go(0.1)
    assert bench.status.state == "canceled"


@pytest.mark.slow
def test_it_first_drives_to_where_the_curve_begins(bench):
    start = GoalMessage(x=0.2, y=-0.1, theta=1.57)
    bench.send(along("circle", size=0.15, start=start, speed=0.1))
    shown = bench.go(25.0)
    places = np.array([[each.truth.x, each.truth.y] for each in shown[-600:]])
    assert np.abs(np.hypot(*(places - (0.05, -0.1)).T) - 0.15).max() < 0.003


@pytest.mark.slow
def test_pushed_off_it_comes_back_to_its_curve():
    bench = JourneyBench(imperfect=True, map="stub")  # on the square, all four sides look alike
    start = GoalMessage(x=0.0, y=-0.25, theta=0.0)
    bench.send(along("circle", size=0.12, start=start))
    bench.go(10.0)
    bench.program.robot.place(bench.now.truth @ Pose2(0.0, 0.06, 0.1))
    looked = {each.added["navigation"].state for each in bench.go(10.0)}
    shown = bench.go(20.0)
    bench.close()
    assert looked >= {"driving", "waiting"}
    places = np.array([[each.truth.x, each.truth.y] for each in shown[-200:]])
    assert np.abs(np.hypot(*(places - (0.0, -0.13)).T) - 0.12).max() < 0.003


def test_a_curve_into_a_wall_fails_and_the_robot_stands(bench):
    bench.send(along("circle", size=0.5))
    bench.go(2.0)
    assert bench.status.state == "failed"
    assert "would touch a wall" in bench.status.reason
    assert bench.now.mode == "idle"


@pytest.mark.parametrize(
    ("command", "words"),
    [
        (along("points"), "points are given with the shape points"),
        (along("points", points=[(0, 0), (0.1, 0), (3.0, 0)]), "beyond the field"),
        (along("circle", start=GoalMessage(x=0.1, y=0.1)), "the curve's start has no theta"),
        (
            NavigateCommand(
                type="navigate",
                poses=[GoalMessage(x=0, y=0)],
                curve=CurveMessage(shape="circle"),
            ),
            "poses, a curve or a line",
        ),
    ],
)
def test_what_cannot_be_a_curve_is_refused(bench, command, words):
    with pytest.raises(CommandError, match=words):
        bench.send(command)
