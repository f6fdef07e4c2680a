"""How far slip may have led, and what tells it from other errors."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from robot.geometry import Pose2
from robot.localization.monitoring.slip_check import SlipCheck

PERIOD = 1 / 15
STEP = Pose2(0.01, 0.0, 0.05)
BLIND = np.zeros((3, 3))
SEES_ALL = np.diag(np.array([1e8, 1e8, 1e8]))
SLIPPERY = np.array([3.0, 1.0, 5.0])
"""Rest of steps ahead, aside and in heading, in spreads."""
TORN = 2.5


def followed(offsets, information=BLIND) -> SlipCheck:
    """A check of a robot that goes on along x."""
    check = SlipCheck()
    for offset in offsets:
        check.observe(Pose2(), STEP, offset, information, PERIOD)
    return check


def test_slip_lasts_from_one_picture_to_the_next() -> None:
    lasting = followed([Pose2(-0.001, 0.0, 0.01)] * 10)
    assert lasting.explains(SLIPPERY, TORN)


def test_pictures_that_come_late_by_turns_sway() -> None:
    swaying = followed([Pose2(0.002 * (-1) ** k, 0.0, 0.01 * (-1) ** k) for k in range(10)])
    assert not swaying.explains(SLIPPERY, TORN)


def test_a_floor_that_is_not_as_drawn_moves_a_robot_aside_or_does_not_turn_it() -> None:
    lasting = followed([Pose2(-0.001, 0.0, 0.01)] * 10)
    assert not lasting.explains(np.array([3.0, 6.0, 5.0]), TORN)
    assert not lasting.explains(np.array([5.0, 1.0, 2.0]), TORN)


def test_blind_steps_add_up_and_a_scan_that_sees_all_ends_that() -> None:
    blind = followed([Pose2()] * 20)
    along, _, turned = np.sqrt(blind.covariance.diagonal())
    assert along == pytest.approx(0.25 * 20 * STEP.x, rel=0.05)
    assert turned == pytest.approx(0.25 * 20 * STEP.theta, rel=0.05)
    blind.observe(Pose2(), STEP, Pose2(), SEES_ALL, PERIOD)
    assert np.sqrt(blind.covariance.diagonal()).max() < 2e-4


@given(heading=st.floats(-math.pi, math.pi), line=st.floats(-math.pi, math.pi))
def test_along_a_line_that_scans_see_nothing_of_slip_stays_unknown(heading, line) -> None:
    across = np.array([-math.sin(line), math.cos(line), 0.0])
    seen = 1e8 * np.outer(across, across)
    check = SlipCheck()
    for _ in range(20):
        check.observe(Pose2(theta=heading), STEP, Pose2(), seen, PERIOD)
    values = np.linalg.eigvalsh(check.covariance)
    assert values[0] >= 0
    assert across @ check.covariance @ across < 1e-7
    along = np.array([math.cos(line), math.sin(line), 0.0])
    due = 0.25 * 20 * STEP.x * abs(math.cos(heading - line))
    assert math.sqrt(along @ check.covariance @ along) <= 1.1 * due + 1e-3
