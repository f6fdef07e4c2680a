"""All causes by code."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

from app.features.course.grader.causes.areas import AREAS
from app.features.course.grader.causes.cause import Cause
from app.features.course.grader.causes.filter import FILTER
from app.features.course.grader.causes.kalman import KALMAN
from app.features.course.grader.causes.motion import MOTION
from app.features.course.grader.causes.sensor import SENSOR
from app.features.course.grader.causes.slips import SLIPS
from app.features.course.grader.causes.steering import STEERING

ANY = {
    "altered": Cause(
        "Something else in the program changes as well.",
        "The function writes into the arrays that it was given.",
        "Work on a copy: poses = poses.copy().",
    ),
    "same-array": Cause(
        "What was to be kept changes as well.",
        "Two names stand for one array: what is written into one is in the other, too.",
        "new = poses makes no copy, and neither does a part of an array; poses.copy() does.",
    ),
    "remembered": Cause(
        "The same question gets another answer the second time.",
        "The function keeps something between its calls: in a global variable, or in a list that "
        "stands in its first line as a default.",
        "All that the result depends on is in the arguments; begin with those at each call.",
    ),
    "form": Cause(
        "The result cannot be used.",
        "It has another form than the lesson asks for.",
        "Compare what you return with the stub's description.",
    ),
    "no-number": Cause(
        "The result cannot be used: it is infinite, or not a number.",
        "Something is divided by 0 or grows without an end, or a root or a logarithm is taken of "
        "what has none.",
        "Which value of this case is 0? Follow it to where it is divided by: a direction, for one, "
        "is arctan2(y, x), which divides by nothing.",
    ),
    "error": Cause(
        "Python stops with an error.",
        "The function does not get to its return.",
        "Read the error's last line, then look at the line that it names.",
    ),
    "not-written": Cause(
        "This function is not written yet.",
        "It still raises NotImplementedError, as its stub does.",
        "Write it, and take that line out.",
    ),
    "misused": Cause(
        "A function of the lesson gets what it cannot use.",
        "Its arguments are exchanged, or one of them is something else than it wants.",
        "Compare that call with the stub, argument by argument.",
    ),
    "stopped": Cause(
        "The function had to be stopped.",
        "It does something that no lesson needs, or does not end.",
        "Look for loops without an end, very large arrays, and anything about files or networks.",
    ),
    "differs": Cause(
        "The result differs.",
        "No mistake that is known explains it.",
        "Work the case out on paper, and print what your code has at each step.",
    ),
}

CAUSES: Mapping[str, Cause] = MappingProxyType(
    MOTION | SENSOR | FILTER | KALMAN | STEERING | SLIPS | AREAS | ANY
)
"""All causes by code."""


def cause_of(code: str) -> Cause:
    """Return a cause; a code of a teacher's own lesson says itself."""
    return CAUSES.get(code) or Cause(code, code, ANY["differs"].advice)
