"""Programs as students write them: wrong ones are named by their cause, right ones pass.

One of several is graded here, by turns; ``grader_trials.py programs`` grades all.
"""

from __future__ import annotations

import pytest
from course.student_programs import SETS, programs

from app.features.course.grader.causes.areas import AREAS
from app.features.course.grading import grade
from app.features.course.lesson import lesson_of

WRONG = [program for name in SETS for program in programs(name)]
RIGHT = list(programs("right"))
EVERY = 8


@pytest.mark.slow
@pytest.mark.parametrize("program", WRONG[3::EVERY], ids=lambda program: program.name)
def test_what_is_wrong_is_named(program):
    findings = grade(program.source, "mine.py", lesson_of(program.lesson)).findings
    assert [finding.cause for finding in findings][:1] == [program.cause], program.about


@pytest.mark.slow
@pytest.mark.parametrize("program", RIGHT[::5], ids=lambda program: program.name)
def test_nothing_is_said_of_a_right_program(program):
    assert grade(program.source, "mine.py", lesson_of(program.lesson)).passed


def test_nearly_all_causes_say_more_than_a_part():
    vague = [program.name for program in WRONG if program.cause in (*AREAS, "differs", "")]
    assert len(WRONG) > 220
    assert len(RIGHT) >= 40
    assert len(vague) <= 0.05 * len(WRONG), vague
