"""Mending: the line of a slip is told, and loops without an end do not hold it up."""

from __future__ import annotations

import pytest

from app.features.course.grading import grade
from app.features.course.lesson import lesson_of

WRONG = """
import math

def wrap(angle):
    while angle >= math.pi:
        angle -= 2 * math.pi
    while angle < -math.pi:
        angle += 2 * math.pi
    return angle

def odometry(pose, left, right, track):
    x, y, theta = pose
    way, turn = (left + right) / 2, (right - left) / track
    middle = theta + turn / 3
    return x + way * math.cos(middle), y + way * math.sin(middle), wrap(theta + turn)
"""


@pytest.mark.slow
def test_the_line_of_a_slip_is_told():
    (finding,) = grade(WRONG, "mine.py", lesson_of(1)).findings
    assert finding.cause == "slip-number"
    assert finding.line == 14
    assert "Line 14" in finding.case.say()
    assert "another number" in finding.case.say()


@pytest.mark.slow
def test_what_no_small_change_mends_is_named_by_the_part_that_is_wrong():
    source = WRONG.replace("theta + turn / 3", "theta + math.sin(7 * turn + 3 * theta)")
    (finding,) = grade(source, "mine.py", lesson_of(1)).findings
    assert finding.cause == "place"
    assert finding.line is None
