"""A robot explores a floor by itself while its map is drawn."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest
from drawn_maps import MappingBench
from engine_runs import run

from app.engine.drivers import Driver
from app.engine.driving import GAP_S
from app.features.mapping.drawing_work import EXPLORED, NOTHING_SEEN
from app.features.mapping.messages import ExploreCommand
from app.features.mapping.routes import drawing_message
from app.messages.driving_commands import DriveCommand, StopCommand
from robot.errors import CommandError
from robot.geometry import Twist2

pytestmark = pytest.mark.slow

PAGE, OTHER = Driver("page 1"), Driver("page 2")
START = ExploreCommand(type="explore", start=True)
RENEW = ExploreCommand(type="explore")
LONGEST_S = 200.0
TICK_S = 0.02
TICKS_DRAWN = 25
"""A map is drawn so often."""
MOST_WAITS = 200
"""For what is said at the end, each 0.05 s."""


@pytest.fixture
def bench() -> Iterator[MappingBench]:
    made = MappingBench()
    yield made
    made.close()


def explored(bench: MappingBench) -> float:
    """Let the robot explore until it stops by itself; return how long that takes [s]."""
    engine = bench.program.engine
    bench.outlets.carry_out(PAGE, START)
    for tick in range(round(LONGEST_S / TICK_S)):
        snapshot = engine.step()
        if tick > 0 and snapshot.mode == "idle":
            return tick * TICK_S
        bench.outlets.carry_out(PAGE, RENEW)
        # Map and routes are made by another thread, which follows the real time.
        if snapshot.route is None:
            bench.drawer._follower.wait(0.005)
        elif tick % TICKS_DRAWN == 0:
            bench.follow(snapshot)
    raise AssertionError("the robot does not stop")


def test_the_square_is_explored_and_the_robot_comes_back(bench):
    start = bench.program.engine.step().truth
    assert explored(bench) < 180.0
    end = bench.program.engine.step()
    assert end.truth.distance_to(start) < 0.08
    for _ in range(MOST_WAITS):
        if bench.drawer.drawing.words == EXPLORED:
            break
        bench.drawer._follower.wait(0.05)
        run(bench.program, 0.1)
    assert bench.drawer.drawing.words == EXPLORED
    bench.finish()
    message = drawing_message(bench.drawer.drawing)
    assert len(message.strokes) == 4
    assert message.remarks == []
    for stroke in message.strokes:
        assert np.abs(stroke.points) == pytest.approx(0.5, abs=0.002)


def test_where_no_tape_is_in_sight_it_gives_up(bench):
    run(bench.program, 12.0, DriveCommand(type="drive", v=0.25, omega=0.0))
    assert explored(bench) < 20.0
    while bench.drawer.drawing.words != NOTHING_SEEN:
        bench.drawer._follower.wait(0.05)
        run(bench.program, 0.1)


def test_a_stop_ends_it_and_nobody_else_takes_it_over(bench):
    engine = bench.program.engine
    bench.outlets.carry_out(PAGE, START)
    for _ in range(10):
        snapshot = engine.step()
        bench.outlets.carry_out(PAGE, RENEW)
    assert snapshot.mode == "explore"
    with pytest.raises(CommandError, match="drives"):
        bench.outlets.carry_out(OTHER, START)
    bench.outlets.drivers.put(OTHER, StopCommand(type="stop"))
    assert engine.step().mode == "idle"
    with pytest.raises(CommandError, match="stop holds"):
        bench.outlets.carry_out(PAGE, RENEW)
    assert engine.step().mode == "idle"


def test_without_renewal_the_robot_stands(bench):
    engine = bench.program.engine
    bench.outlets.carry_out(PAGE, START)
    ticks = [engine.step() for _ in range(40)]
    assert ticks[5].mode == "explore"
    assert (ticks[-1].mode, ticks[-1].twist) == ("explore", Twist2())
    run(bench.program, GAP_S)
    # A renewal alone does not begin again.
    bench.outlets.carry_out(PAGE, RENEW)
    assert engine.step().mode == "idle"


def test_a_finished_map_is_not_forgotten(bench):
    bench.drawer.begin()
    bench.drive(12.0)
    bench.finish()
    with pytest.raises(CommandError, match="save or discard"):
        bench.outlets.carry_out(PAGE, START)
    assert bench.drawer.drawing.result is not None
