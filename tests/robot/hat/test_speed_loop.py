"""When a wheel that does not move is taken for blocked."""

from dataclasses import replace

import numpy as np
import pytest

from benchmarks.hat.bricks import MEDIUM, Bricks
from robot.description.wiring import KINDS
from robot.hat.joint_track import JointTrack
from robot.hat.speed_loop import (
    HELD_S,
    HELD_TRAVEL,
    KICK_S,
    LARGEST_LAG,
    MOST_PUSH,
    NOMINAL_SUPPLY,
    RAIL,
    SpeedLoop,
)
from sim.hat.motor_figures import MOTOR_FIGURES
from sim.hat.plants import FreeMotors

DT = 0.01


def is_held_on_the_spot(wanted, seconds):
    """Whether a shaft counts as blocked that stays where it is; it was told a speed [degree/s]."""
    loop, track = SpeedLoop(next(iter(KINDS.values())), position_gain=5.0), JointTrack()
    held = False
    for tick in range(round(seconds / DT)):
        track.report(tick * DT, 0, 0)
        loop.update(wanted, tick * DT, track, 8.0)
        held = held or loop.is_held
    return held


@pytest.mark.parametrize("way", [-1, 1])
def test_a_wheel_is_blocked_that_should_have_turned_and_did_not(way):
    assert is_held_on_the_spot(way * 100, 3 * HELD_S)


def test_a_slow_wheel_may_stay_on_one_degree_for_longer():
    slow = 0.5 * HELD_TRAVEL / (3 * HELD_S)
    assert not is_held_on_the_spot(slow, 3 * HELD_S)
    assert is_held_on_the_spot(slow, 9 * HELD_S)


def test_a_quick_wheel_may_stay_for_a_moment():
    assert not is_held_on_the_spot(1000, 0.9 * HELD_S)


@pytest.mark.parametrize("way", [-1, 1])
def test_a_wheel_that_stood_gets_more_duty_for_a_moment(way):
    """Static friction is larger than that of a wheel that turns."""
    kind = next(iter(KINDS.values()))
    loop, track = SpeedLoop(kind, position_gain=0.0), JointTrack()
    duties = []
    for tick in range(round(2 * KICK_S / DT)):
        track.report(tick * DT, 0, 0)
        duties.append(way * loop.update(way * 100.0, tick * DT, track, 8.0))
    kicks, later = duties[: round(KICK_S / DT)], duties[round(KICK_S / DT) :]
    assert kind.breakaway > kind.friction and len(later) == len(kicks)
    more = (kind.breakaway - kind.friction) / (RAIL * 8.0 / NOMINAL_SUPPLY)
    assert np.ptp(kicks) == np.ptp(later) == 0
    assert kicks[0] - later[0] == pytest.approx(more)


@pytest.mark.parametrize("way", [-1, 1])
def test_a_wheel_that_is_held_is_pushed_by_the_largest_lag_and_a_bit_more_and_no_harder(way):
    kind, gain, wanted = next(iter(KINDS.values())), 5.0, 300.0
    loop, track = SpeedLoop(kind, gain), JointTrack()
    duties = []
    for tick in range(100):
        track.report(tick * DT, 0, 0)
        duties.append(way * loop.update(way * wanted, tick * DT, track, 8.0))
    friction = kind.friction + MOST_PUSH
    pushed = ((wanted + gain * LARGEST_LAG) / kind.free_speed + friction) / (
        RAIL * 8.0 / NOMINAL_SUPPLY
    )
    assert (max(duties), duties[-1]) == pytest.approx((pushed, pushed))


def test_a_wheel_that_nobody_hears_of_is_not_pushed():
    """It turns, as far as anybody knows: more duty would make it turn faster."""
    kind = next(iter(KINDS.values()))
    heard, quiet = (duties_after_a_second(kind, hears) for hears in (True, False))
    assert max(quiet) <= heard[0] + 1e-9


def duties_after_a_second(kind, hears):
    """The next duties of a wheel that has turned as it should, if reports go on or end there."""
    loop, track = SpeedLoop(kind, position_gain=0.0), JointTrack()
    duties = []
    for tick in range(120):
        if hears or tick < 100:
            track.report(tick * DT, tick, (tick + 180) % 360 - 180)
        duties.append(loop.update(100.0, tick * DT, track, 8.0))
    return duties[100:]


@pytest.mark.parametrize("speed", [5, 9, 15, 25, 40, 80])
@pytest.mark.parametrize(
    ("friction", "breakaway"), [(1.0, 1.0), (1.1, 1.3), (1.5, 2.0), (2.0, 2.5)]
)
def test_a_slow_wheel_that_sticks_more_than_a_free_motor_turns(speed, friction, breakaway):
    """It was taken for blocked, and a robot that crept to its goal never came there."""
    free = MOTOR_FIGURES[MEDIUM]
    loaded = replace(free, friction=friction * free.friction, breakaway=breakaway * free.breakaway)
    bricks = Bricks(plants=FreeMotors({0: loaded, 1: loaded}))
    bricks.until(bricks.ready)
    bricks.wanted = np.radians([speed, -speed])
    for _ in range(30):
        rows = bricks.run(0.1)
        assert bricks.ready()
    turned, commanded = np.abs(rows[-1, 3:]), speed * 3.0
    assert turned.min() > commanded - LARGEST_LAG
    assert turned.max() < commanded + 3
