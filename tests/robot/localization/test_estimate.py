"""What is claimed of an estimate, and what reasons for doubt change about it."""

import math

import pytest

from robot.localization.estimate import Alert, Cause, Integrity, State


@pytest.mark.parametrize("state", [State.CERTAIN, State.GIVEN])
def test_nothing_is_claimed_while_motors_are_plugged_in_wrongly(state):
    """Where the robot is compares the field with motion, and that is none: *town*, seed 18100."""
    alerts = (Alert(Cause.MOTORS, "the other way round"),)
    claim = Integrity(state, 0.01, 0.02).because_of(alerts)
    assert claim == Integrity(State.APPROXIMATE, math.inf, math.pi, alerts)


@pytest.mark.parametrize("state", [State.SEARCHING, State.AMBIGUOUS, State.LOST])
def test_what_claims_nothing_stays_as_it_is(state):
    alerts = (Alert(Cause.MOTORS, "the other way round"),)
    assert Integrity(state).because_of(alerts) == Integrity(state, alerts=alerts)


def test_other_reasons_are_told_beside_the_claim():
    alerts = (Alert(Cause.PICTURES_LATE, "late"),)
    claim = Integrity(State.CERTAIN, 0.01, 0.02).because_of(alerts)
    assert claim == Integrity(State.CERTAIN, 0.01, 0.02, alerts)
