"""A robot follows tape by its camera: as a command, in the whole program."""

from __future__ import annotations

import numpy as np
import pytest
from journeys import JourneyBench

from app.features.navigation.messages import (
    CancelCommand,
    GoalMessage,
    LineMessage,
    NavigateCommand,
)
from robot.errors import CommandError
from robot.geometry import Pose2

FOLLOW = NavigateCommand(type="navigate", line=LineMessage(), renewed=True)


def test_it_comes_to_the_tape_follows_it_around_a_corner_and_is_canceled():
    bench = JourneyBench(imperfect=True)
    bench.program.robot.place(Pose2(0.3, 0.1, 0.3))
    bench.go(0.3)
    bench.send(FOLLOW)
    shown = bench.go(14.0)
    assert bench.status.state == "driving"
    places = np.array([[each.truth.x, each.truth.y] for each in shown[-400:]])
    # The tape's middle: a square of one metre.
    assert np.abs(np.abs(places).max(axis=1) - 0.5).max() < 0.06
    assert places[0, 0] > 0.4
    assert places[-1, 0] < 0.3
    bench.send(CancelCommand(type="cancel"))
    bench.go(0.1)
    assert bench.status.state == "canceled"
    assert bench.now.mode == "idle"
    bench.close()


@pytest.mark.slow
def test_on_stub_it_comes_to_the_end_of_the_tape_that_branches_off():
    """It begins in front of it, as it goes straight on where the branch leaves the side."""
    bench = JourneyBench(imperfect=True, map="stub")
    bench.program.robot.place(Pose2(0.36, 0.02, 3.0))
    bench.go(0.3)
    bench.send(FOLLOW)
    bench.go(20.0)
    assert bench.status.state == "arrived"
    truth = bench.now.truth
    assert abs(truth.y) < 0.05
    assert 0.0 < truth.x < 0.3
    bench.close()


def test_a_line_and_a_goal_at_once_are_refused():
    bench = JourneyBench()
    both = NavigateCommand(type="navigate", line=LineMessage(), poses=[GoalMessage(x=0, y=0)])
    with pytest.raises(CommandError, match="poses, a curve or a line"):
        bench.send(both)
    bench.close()
