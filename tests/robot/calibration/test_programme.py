"""The programme that a calibration drives."""

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from robot.calibration.programme import LONGEST_S, rest_after, velocity
from robot.geometry import Pose2

STEP = 0.01


@given(st.floats(0.0, LONGEST_S))
@example(45.0)
@example(54.8)
@example(99.8)
def test_between_two_parts_the_robot_stands(elapsed: float) -> None:
    rest = rest_after(elapsed)
    assert elapsed < rest <= elapsed + 6.0
    for stamp in (rest - 1e-6, rest + 1e-6):
        twist = velocity(stamp)
        assert abs(twist.v) + abs(twist.omega) < 1e-4


@pytest.mark.parametrize("seconds", [19.6, LONGEST_S])
def test_what_leads_away_leads_back(seconds: float) -> None:
    pose, farthest = Pose2(), 0.0
    for stamp in np.arange(0.0, seconds, STEP).tolist():
        twist = velocity(stamp)
        pose = pose @ twist.integrate(STEP)
        farthest = max(farthest, float(np.hypot(pose.x, pose.y)))
    assert farthest < 0.4
    assert np.hypot(pose.x, pose.y) < 0.05
