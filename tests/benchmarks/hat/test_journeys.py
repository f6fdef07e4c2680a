"""The real robot's driver comes to goals, by wheels that stick as real ones do."""

import math

import pytest

from benchmarks.hat.journeys import drive

pytestmark = pytest.mark.slow


@pytest.mark.parametrize(("name", "seed"), [("square", 8), ("town", 2)])
def test_a_robot_on_the_board_arrives(name, seed):
    """Wheels that crept were taken for blocked, so hardly one of these goals was reached; and a
    place that was confirmed had rivals again, once only a straight piece of tape was in sight."""
    journeys = drive(name, seed, goals=3)
    assert [journey.state for journey in journeys] == ["arrived"] * 3, journeys
    assert max(journey.error for journey in journeys) < 0.002
    assert max(journey.turn for journey in journeys) < math.radians(1)


def test_a_drive_is_the_same_however_busy_the_computer_is():
    assert drive("square", 3, goals=1) == drive("square", 3, goals=1)
