"""Whether a place that was lost and found again is where wheels led."""

from __future__ import annotations

import pytest

from app.features.plausibility.displacement import FAR, FAR_SHARE, LASTS, Displacement
from robot.geometry import Pose2
from robot.localization.estimate import State

STEP = Pose2(0.01, 0.0, 0.02)


def found(states: list[State], pushed: Pose2, at: int, others: tuple[Pose2, ...] = ()) -> list[int]:
    """Return when the place was found elsewhere, of a robot that is pushed at one of the states."""
    displacement, odometry, pose = Displacement(), Pose2(), Pose2(1.0, 2.0, 0.5)
    said = []
    for number, state in enumerate(states):
        if number == at:
            pose = pose @ pushed
        if displacement.was_displaced(state, (pose, *others), odometry):
            said.append(number)
        odometry, pose = odometry @ STEP, pose @ STEP
    return said


KNOWN, LOST = [State.CERTAIN] * 20, [State.LOST] * 10
PUSH = Pose2(FAR + FAR_SHARE * 10 * STEP.x + 0.01)


@pytest.mark.parametrize("push", [PUSH, PUSH.inverse(), Pose2(theta=0.5), Pose2(theta=-3.0)])
@pytest.mark.parametrize("before", [State.CERTAIN, State.GIVEN])
def test_a_robot_that_was_pushed_hears_so_once_it_is_found(push: Pose2, before: State) -> None:
    states = [*[before] * 20, *LOST, State.AMBIGUOUS, State.APPROXIMATE, *KNOWN]
    assert found(states, push, 20) == [32]


@pytest.mark.parametrize("push", [Pose2(), Pose2(0.03), Pose2(theta=0.1)])
def test_one_that_wheels_led_there_hears_nothing(push: Pose2) -> None:
    assert not found([*KNOWN, *LOST, *KNOWN], push, 20)


@pytest.mark.parametrize("state", [State.AMBIGUOUS, State.APPROXIMATE])
def test_one_that_is_at_none_of_several_places_where_wheels_led_hears_so(state: State) -> None:
    """A robot that was lifted on a square: it has driven to none of four places that look alike."""
    states = [*KNOWN, *LOST, *[state] * 30]
    push = Pose2(PUSH.x + FAR_SHARE * 30 * STEP.x)
    assert found(states, push, 20, (Pose2(5.0),)) == [30 + LASTS - 1]


def test_one_that_may_be_where_wheels_led_hears_nothing() -> None:
    there = Pose2(1.0, 2.0, 0.5)
    for _ in range(35):
        there = there @ STEP
    assert not found([*KNOWN, *LOST, *[State.AMBIGUOUS] * 30], PUSH, 20, (there,))


def test_one_that_was_never_lost_hears_nothing_until_it_is_certain() -> None:
    assert not found([*KNOWN, *[State.AMBIGUOUS] * 30], PUSH, 20)


@pytest.mark.parametrize("told", [State.GIVEN, State.SEARCHING])
def test_one_whose_place_is_told_anew_hears_nothing(told: State) -> None:
    assert not found([*KNOWN, *LOST, *[told] * 3, *KNOWN], PUSH, 30)


def test_a_place_that_is_known_all_the_time_is_where_the_filter_says() -> None:
    assert not found(KNOWN * 2, PUSH, 20)
