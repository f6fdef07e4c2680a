"""A client that sends its goal once: its journey is kept up as long as it is there."""

from __future__ import annotations

import time
from collections.abc import Iterator

import pytest
from journeys import OTHER, PAGE, RENEW, JourneyBench, goal

from app.engine.drivers import Drivers
from app.features.navigation.commands import KEEPER
from app.messages.commands import PlaceCommand
from app.messages.driving_commands import StopCommand
from robot.errors import CommandError
from robot.geometry import Pose2

ONCE = goal(0.3, 0.2, 1.0).model_copy(update={"renewed": False})
LONGEST_S = 20.0
"""A busy machine may keep a thread waiting."""


@pytest.fixture
def bench() -> Iterator[JourneyBench]:
    made = JourneyBench()
    yield made
    made.close()


def renewed(bench: JourneyBench, seconds: float = 0.3) -> bool:
    """Whether the engine gets a renewal within a time [s]."""
    bench.program.engine.commands.take()
    until = time.monotonic() + seconds
    while time.monotonic() < until:
        if any(command == RENEW for command in bench.program.engine.commands.take()):
            return True
    return False


def test_a_goal_that_was_sent_once_is_renewed_until_somebody_stops_it(bench):
    bench.send(ONCE)
    bench.go(0.5, renew=False)
    assert bench.status.active
    assert renewed(bench, LONGEST_S)
    bench.send(StopCommand(type="stop"), OTHER)
    bench.go(0.04, renew=False)
    assert not renewed(bench)


def test_a_robot_that_is_put_off_its_way_goes_on_to_its_goal():
    """As one that is carried off by hand: it notices, looks around, and plans anew."""
    bench = JourneyBench(map="stub", seed=1)
    try:
        bench.send(goal(0.25, 0.2, 1.57))
        bench.go(1.0)
        bench.send(PlaceCommand(type="place", x=-0.2, y=0.2, theta=0.5))
        bench.go(0.5)
        assert bench.status.active
        bench.go(60.0)
        assert bench.status.state == "arrived"
        assert bench.now.truth.distance_to(Pose2(0.25, 0.2, 1.57)) < 0.02
    finally:
        bench.close()


def test_it_is_not_renewed_when_its_sender_has_left(bench):
    bench.send(ONCE)
    bench.go(0.5)
    bench.outlets.drivers.leave(PAGE)
    bench.go(0.04, renew=False)
    assert bench.status.state == "canceled"
    assert not renewed(bench)


def test_who_renews_it_itself_is_not_helped(bench):
    bench.send(goal(0.3, 0.2, 1.0))
    bench.go(0.5, renew=False)
    assert not renewed(bench)


def test_a_goal_that_is_refused_is_not_kept(bench):
    bench.send(ONCE)
    bench.go(0.1)
    with pytest.raises(CommandError, match="drives"):
        bench.send(ONCE, OTHER)
    keeper = bench.outlets.part(KEEPER)
    assert keeper._kept[0] is PAGE


def test_only_who_drives_renews():
    bench = JourneyBench()
    drivers = Drivers.of(bench.program)
    assert not drivers.renew(PAGE, RENEW)
    drivers.put(PAGE, ONCE)
    assert drivers.renew(PAGE, RENEW)
    assert not drivers.renew(OTHER, RENEW)
    bench.close()
