"""What cannot be true of pictures and wheels is said, and moves no estimate."""

from __future__ import annotations

import pickle

import numpy as np
import pytest
from floor_scans import LEFT, drive

from app.features.plausibility.checks import SHOWN, STANDS, PlausibilityChecks
from app.features.plausibility.companion import SAID, TOPIC, PlausibilityCompanion
from app.features.plausibility.companion import SHOWN as COUNTS_SHOWN
from robot.geometry import Pose2
from robot.interface import Reading
from robot.localization.estimate import Cause
from robot.scan import Scan

PERIOD = 1 / 15
RAYS = 31
AHEAD = Pose2(0.01)
"""Way between two pictures."""


def scan(number: int, *, picture: int | None = None) -> Scan:
    ranges = np.full(RAYS, 0.4)
    return Scan(
        number * PERIOD,
        np.linspace(-0.5, 0.5, RAYS),
        ranges,
        picture=number + 1 if picture is None else picture,
    )


def test_a_picture_that_stands_while_wheels_turn_tells_nothing_and_is_named() -> None:
    checks, odometry = PlausibilityChecks(0.12), Pose2()
    for number in range(90):
        frozen = 30 <= number < 45
        seen = scan(number, picture=30 if frozen else None)
        cleared = checks.cleared(seen, odometry)
        assert (cleared is seen) == (not frozen)
        if frozen:
            assert not cleared.hit.any()
            assert np.isnan(cleared.sight).all()
        said = [alert.cause for alert in checks.alerts]
        assert said == ([Cause.FROZEN] if 2.0 <= seen.stamp < 44 * PERIOD + SHOWN else [])
        odometry = odometry @ AHEAD


def test_in_a_replay_that_goes_back_nothing_is_said_that_is_not_yet_found() -> None:
    checks, odometry = PlausibilityChecks(0.12), Pose2()
    kept = pickle.dumps(checks.memory)
    for number in range(30, 35):
        checks.cleared(scan(number, picture=33 if number > 32 else None), odometry)
        assert bool(checks.alerts) == (number > 32)
        odometry = odometry @ AHEAD
    checks.memory = pickle.loads(kept)
    checks.cleared(scan(1), odometry)
    assert not checks.alerts


def test_motors_that_turn_the_other_way_are_told_in_words() -> None:
    checks = PlausibilityChecks(0.12)
    for seen, pose in drive([LEFT] * 60, mirrored=True):
        checks.cleared(seen, pose)
    (alert,) = checks.alerts
    assert alert.cause is Cause.MOTORS and "mirrored" in alert.text


def test_a_robot_that_stands_may_see_the_same_again_and_again() -> None:
    checks = PlausibilityChecks(0.12)
    for number in range(30):
        seen = scan(number, picture=7)
        assert checks.cleared(seen, Pose2(0.5 * STANDS * (number % 2))) is seen
        assert not checks.alerts


class Told:
    """Stands for controls: a robot whose place nobody knows."""

    def __init__(self) -> None:
        self.odometry = self.localization = self
        self.map_from_odom, self.newest, self.belief = Pose2(), None, None
        self.counted_anew, self.said = -np.inf, {}

    def report(self, topic: str, message: str | None) -> None:
        self.said[topic] = message


@pytest.mark.parametrize("since", [0.0, 0.5 * COUNTS_SHOWN, 2 * COUNTS_SHOWN])
def test_a_motor_that_counts_anew_is_said_for_a_while(since: float) -> None:
    companion, told = PlausibilityCompanion(), Told()
    companion.add(Reading(1.0, np.zeros(2), np.zeros(2)), told)
    assert not told.said
    told.counted_anew = 2.0
    companion.add(Reading(2.0 + since, np.zeros(2), np.zeros(2)), told)
    assert told.said == {TOPIC: SAID if since < COUNTS_SHOWN else None}
