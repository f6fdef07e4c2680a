"""The route of an exploration is a command: a recording has it, and its replay repeats it."""

import pytest
from engine_runs import kinematic
from recordings import record
from replays import course_of, to_the_end

from app.features.mapping.messages import ExploreCommand, RouteCommand

ROUTE = RouteCommand(type="route", x=0.05, y=0.0, theta=0.3, turn=0.3)


def test_a_route_is_recorded_and_repeated(tmp_path):
    program = kinematic(seed=1)
    program.engine.commands.put(ExploreCommand(type="explore", start=True))
    program.engine.commands.put(ROUTE)
    folder, shown, _ = record(program, tmp_path, 1.0, ExploreCommand(type="explore"))
    driven = [tick.route for tick in shown if tick.route is not None]
    assert driven
    assert (driven[0].x, driven[0].y, driven[0].theta) == (0.05, 0.0, pytest.approx(0.3))
    repeated = [tick.route for tick in to_the_end(course_of(folder)) if tick.route is not None]
    assert repeated
    assert repeated[0] == driven[0]
