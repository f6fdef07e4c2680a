"""Lesson 10: its mistakes are named, right controllers are left alone, and these arrive."""

from __future__ import annotations

import ast
import math

import numpy as np
import pytest
from course.steering import ARRAYS, HEAD, MISTAKES, ODD, source_of

from app.features.course.grader.case import REFERENCE
from app.features.course.grading import SEED, grade, grade_often
from app.features.course.lesson import lesson_of

LESSON = lesson_of(10)
CODES = sorted({writing.code for writing in MISTAKES})


def test_a_right_controller_has_at_most_twelve_lines():
    assert len(ast.unparse(ast.parse(ARRAYS)).splitlines()) - 1 <= 12


@pytest.mark.slow
@pytest.mark.parametrize("style", ODD)
def test_nothing_is_said_about_right_controllers(style):
    results = grade_often(HEAD + ODD[style], "mine.py", LESSON, (3, 4))
    assert [finding.cause for each in results for finding in each.findings] == []


@pytest.mark.slow
@pytest.mark.parametrize("code", CODES)
def test_a_mistake_is_named_in_each_writing(code):
    named = [
        [finding.cause for finding in grade(source_of(writing), "mine.py", LESSON).findings][:1]
        for writing in MISTAKES
        if writing.code == code
    ]
    assert named == [[code]] * 3


def test_no_mistake_that_is_known_passes_all_cases():
    cases = LESSON.checks.cases(SEED)
    right = [LESSON.checks.expected(case, REFERENCE) for case in cases]
    for hypothesis in LESSON.checks.hypotheses:
        wrong = [LESSON.checks.expected(case, frozenset([hypothesis.mistake])) for case in cases]
        assert np.abs(np.subtract(wrong, right)).max() > 1e-3, hypothesis.mistake


def test_the_controller_brings_a_late_robot_to_its_goal_and_a_high_gain_swings():
    space: dict = {}
    exec(HEAD + ARRAYS, space)  # our own text
    turns = np.linspace(0.0, math.pi, 40)
    path = 0.3 * np.column_stack([np.sin(turns), -np.cos(turns)])
    goal = np.array([*path[-1], -2.0])

    def end(factor: float) -> tuple[np.ndarray, float]:
        pose, told, turned = np.array([0.02, -0.35, 0.6]), [(0.0, 0.0)] * 5, 0.0
        for _ in range(900):
            v, omega = space["go_there"](pose, path, goal, 0.2, 0.08, 0.1 / factor)
            told.append((v, omega))
            v, omega = told.pop(0)  # 0.1 s ago
            turned += 0.02 * abs(omega)
            pose = pose + 0.02 * np.array([v * math.cos(pose[2]), v * math.sin(pose[2]), omega])
        return pose, turned

    pose, turned = end(1)
    assert math.dist(pose[:2], goal[:2]) < 0.012
    assert math.remainder(pose[2] - goal[2], math.tau) == pytest.approx(0, abs=0.01)
    assert end(8)[1] > 5 * turned
