"""``mend``: the one small change of a student's code with which all its cases pass, if any."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from itertools import islice
from typing import Any

import numpy as np

from app.features.course.grader.case import Case, Checks, FormError, Outcome
from app.features.course.grader.diagnosis import Measured, agree
from app.features.course.grader.edits import Edit, mended
from app.features.course.sandbox.file_clock import FileClock
from app.features.course.sandbox.student_process import (
    CANNOT_USE,
    Answer,
    StudentError,
    StudentProcess,
)

MOST_CHANGES, MOST_SLOW = 8000, 600
"""Changes that are tried; and where one case takes long, as a cloud of particles does."""
SLOW_CALLS, SLOW_NUMBERS = 4, 5000
"""A case with more calls, or with more numbers in what it is given, is slow."""
MOST_ENDS = 8
"""Changed programs that may run without an end."""
CALL_S = 0.5
"""Processor time of one call of a changed program [s]."""
SEARCH_S = 8.0
"""The search ends after this processor time of its own [s]; the student's process takes as much."""
FIRST_SEEDS = 6
"""Where a case has more seeds, a few of them exclude most changes."""


@dataclass(frozen=True)
class Mended:
    """A change that makes all cases pass."""

    cause: str
    words: str
    lines: tuple[int, ...]
    """Where it changes the code: a slip may stand in several lines."""


def answered(process: StudentProcess, case: Case, seconds: float | None = None) -> Outcome:
    """Ask a case of a student's process.

    Raises:
        StudentError: there is no result.
    """
    case.begin()
    offered = case.offered
    if seconds is not None:
        offered = {name: _lenient(function) for name, function in offered.items()}
    if case.play is not None:

        def ask(*arguments: Any, seed: int | None = None) -> Answer:
            return process.call(case.function, arguments, seed, offered, seconds=seconds)

        return Outcome(case, (Answer(case.play(ask)),))
    answers = [
        process.call(case.function, case.arguments, seed, offered, seconds=seconds)
        for seed in case.seeds or (None,)
    ]
    return Outcome(case, tuple(answers))


def _lenient(function: Callable[..., Any]) -> Callable[..., Any]:
    """Return no number for what a function cannot use: an error would end the process, and a
    changed program asks for such things often."""

    def ask(*arguments: Any) -> Any:
        try:
            return function(*arguments)
        except CANNOT_USE:
            return math.nan

    return ask


def mend(
    student: StudentProcess,
    checks: Checks,
    measured: Sequence[Measured],
    clock: FileClock,
    cause: str = "",
) -> Mended | None:
    """Return the first small change with which all measured cases pass; None if there is none.

    Only changes of a cause are tried, if one is given.
    """
    order = _quick_first(measured)
    if not order:
        return None
    try:
        changes = _limited(student.source, checks, order[0], cause)
    except (SyntaxError, ValueError, RecursionError, MemoryError):
        return None
    end = time.thread_time() + SEARCH_S
    for _ in range(MOST_ENDS):
        with suppress(StudentError), StudentProcess(student.path, student.source, clock) as process:
            for edit, source in changes:
                if _passes(process, source, checks, order):
                    return Mended(edit.cause, edit.words, edit.lines)
                if process.broken:
                    break
                if time.thread_time() > end:
                    return None
            else:
                break
    return None


def _quick_first(measured: Sequence[Measured]) -> list[Measured]:
    """Return what failed, with the fewest calls and numbers first; then what passed."""
    return sorted(
        (item for item in measured if item.case.play is None),
        key=lambda item: (item.passed, *_cost(item.case)),
    )


def _cost(case: Case) -> tuple[int, int]:
    sizes = [value.size for value in case.arguments if isinstance(value, np.ndarray)]
    return max(1, len(case.seeds)), sum(sizes)


def _limited(
    source: str, checks: Checks, first: Measured, cause: str
) -> Iterator[tuple[Edit, str]]:
    calls, numbers = _cost(first.case)
    slow = calls > SLOW_CALLS or numbers > SLOW_NUMBERS
    changes = mended(source, checks.functions, cause)
    return islice(changes, MOST_SLOW if slow else MOST_CHANGES)


def _passes(
    process: StudentProcess, source: str, checks: Checks, order: Sequence[Measured]
) -> bool:
    outcomes = []
    try:
        process.replace(source)
        if not _may_pass(process, checks, order[0]):
            return False
        for item in order:
            outcome = answered(process, item.case, CALL_S)
            if not agree(checks.features(outcome), item.expected, item.case.tolerance):
                return False
            outcomes.append(outcome)
        return not any(checks.signs(outcomes))
    except (StudentError, FormError):
        return False


def _may_pass(process: StudentProcess, checks: Checks, item: Measured) -> bool:
    """Return whether a case may pass by its first seeds; by so few, means vary as much more."""
    seeds = item.case.seeds
    if len(seeds) <= FIRST_SEEDS:
        return True
    few = replace(item.case, seeds=seeds[:FIRST_SEEDS])
    wider = item.case.tolerance * math.sqrt(len(seeds) / FIRST_SEEDS)
    return agree(checks.features(answered(process, few, CALL_S)), item.expected, wider)
