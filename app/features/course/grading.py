"""Grades a file: runs a lesson's cases in a process of their own, and names what is wrong."""

from __future__ import annotations

import ast
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace

import numpy as np

from app.features.course.grader.case import Case, Checks, FormError, Outcome, numbers
from app.features.course.grader.causes.causes import cause_of
from app.features.course.grader.diagnosis import (
    Diagnosis,
    Measured,
    agree,
    diagnose,
    expected_features,
)
from app.features.course.grader.finding import Flaw, LessonResult
from app.features.course.grader.words import Words
from app.features.course.lesson import Lesson
from app.features.course.mending import Mended, answered, mend
from app.features.course.sandbox.file_clock import FileClock
from app.features.course.sandbox.student_process import StudentError, StudentProcess

SEED = 20_240_229
"""Default seed of the cases, so that the same file always gets the same result."""
MOST_FAILURES = 4
"""No further cases are run after this number of calls without a result."""


def grade_lessons(
    source: str, path: str, chosen: Iterable[Lesson], seed: int = SEED
) -> list[LessonResult]:
    """Grade lessons of a file, all by one clock: what is begun after its end has failed."""
    clock = FileClock(source)
    return [grade(source, path, lesson, seed, clock) for lesson in chosen]


def grade(
    source: str, path: str, lesson: Lesson, seed: int = SEED, clock: FileClock | None = None
) -> LessonResult:
    """Grade one lesson of a file.

    Args:
        source: the file's text.
        path: its name, for messages.
        lesson: the lesson that is checked.
        seed: of the cases.
        clock: the time that is left for the file; None gives it all the time of a file.
    """
    return grade_often(source, path, lesson, (seed,), clock)[0]


def grade_often(
    source: str, path: str, lesson: Lesson, seeds: Sequence[int], clock: FileClock | None = None
) -> list[LessonResult]:
    """Grade one lesson of a file with several seeds, in one process as long as it survives."""
    clock = clock or FileClock(source, len(seeds))
    checks = lesson.checks
    if not _written(source, checks):
        return [LessonResult(lesson.number, lesson.name, started=False)] * len(seeds)
    results: list[LessonResult] = []
    while len(results) < len(seeds):
        try:
            # Absurd numbers are told as such; NumPy's own warnings about them help nobody.
            with np.errstate(all="ignore"), StudentProcess(path, source, clock) as process:
                for seed in seeds[len(results) :]:
                    findings = tuple(_findings(process, lesson, seed, checks, clock))
                    results.append(LessonResult(lesson.number, lesson.name, findings))
                    if process.broken:
                        break  # what it says next may answer an earlier question
        except StudentError as error:
            results.append(LessonResult(lesson.number, lesson.name, (_failure(lesson, error),)))
    return results


def _findings(
    process: StudentProcess, lesson: Lesson, seed: int, checks: Checks, clock: FileClock
) -> Iterator[Flaw]:
    missing = [name for name in checks.functions if name not in process.names]
    if missing:
        yield _failure(lesson, StudentError(f"there is no function {missing[0]}"))
        return
    cases = checks.cases(seed)
    measured, failures = measure(process, lesson, cases)
    altered = list(_altered(lesson, measured))
    try:
        named, sure = _named(process, lesson, measured, clock, altered=bool(altered))
    except FormError as error:  # what only the search for causes looks at
        named, sure = [_finding(lesson, error.cause, measured[0].case, error.words)], True
    # What is not known for sure may follow from arrays that were written over.
    yield from (*named, *altered) if sure else (*altered, *named)
    causes = {flaw.cause for flaw in named}
    for flaw in failures[:1]:
        if flaw.cause in ("form", "no-number", "misused") and not causes:
            yield _usable(process, lesson, cases, clock, flaw)
        elif flaw.cause not in causes:
            yield flaw


def measure(
    process: StudentProcess, lesson: Lesson, cases: Iterable[Case]
) -> tuple[list[Measured], list[Flaw]]:
    """Run all cases; end after a few calls without a result, or when the process is gone."""
    measured: list[Measured] = []
    failures: list[Flaw] = []
    for case in cases:
        if case.play is not None and not all(item.passed for item in measured):
            break  # whole drives only confirm what the small cases have shown
        try:
            outcome = answered(process, case)
            given = lesson.checks.features(outcome)
            measured.append(Measured(outcome, given, expected_features(lesson.checks, case)))
        except StudentError as error:
            failures.append(_failure(lesson, error, case))
            if error.fatal:
                break
        except FormError as error:
            failures.append(_finding(lesson, error.cause, case, error.words))
        if len(failures) >= MOST_FAILURES:
            break
    return measured, failures


def _named(
    process: StudentProcess,
    lesson: Lesson,
    measured: Sequence[Measured],
    clock: FileClock,
    *,
    altered: bool,
) -> tuple[list[Flaw], bool]:
    """Return what is named, and whether it is known for sure."""
    failed = [item for item in measured if not item.passed]
    if failed and altered:
        # Whatever the results look like may follow from an array that has two names.
        change = mend(process, lesson.checks, measured, clock, "same-array")
        if change is not None:
            return [_slip(lesson, change, failed[0])], True
    diagnoses = diagnose(lesson.checks, measured)
    sure = not failed or any(item.certain for item in diagnoses)
    if not sure:
        remembered = _remembered(process, lesson, measured)
        if remembered is not None:
            return [remembered], True
        change = mend(process, lesson.checks, measured, clock)
        if change is not None:
            return [_slip(lesson, change, failed[0])], True
    return [_explained(lesson, lesson.checks, item) for item in diagnoses], sure


def _remembered(
    process: StudentProcess, lesson: Lesson, measured: Sequence[Measured]
) -> Flaw | None:
    """Ask the first case once more: whoever answers otherwise keeps something between calls."""
    first = measured[0]
    if first.case.play is not None:
        return None
    try:
        second = lesson.checks.features(answered(process, first.case))
    except (StudentError, FormError):
        return None
    if agree(second, first.given, first.case.tolerance):
        return None
    words = Words(
        "Your code: {given}. Asked the same once more: {again}.",
        {
            "given": lesson.checks.show(first.case, first.given),
            "again": lesson.checks.show(first.case, second),
        },
    )
    return _finding(lesson, "remembered", first.case, words)


def _usable(
    process: StudentProcess, lesson: Lesson, cases: Iterable[Case], clock: FileClock, flaw: Flaw
) -> Flaw:
    """Return what is wrong with results or arguments of another form than asked for: a line, if one
    change of it mends all, as a return that stands in the loop."""
    asked = [
        Measured(Outcome(case, ()), np.empty(0), expected_features(lesson.checks, case))
        for case in cases
        if case.play is None
    ]
    change = mend(process, lesson.checks, asked, clock)
    if change is None:
        return flaw
    # What divides by 0 is no other operator's line, though any other would do without it.
    divided = (flaw.cause, change.cause) == ("no-number", "slip-operator")
    code = flaw.cause if divided else change.cause
    cause = cause_of(code)
    return replace(
        flaw,
        cause=code,
        symptom=Words(cause.symptom),
        case=_where(change, flaw.case),
        seems=Words(cause.seems),
        advice=Words(cause.advice),
        line=change.lines[0],
    )


def _slip(lesson: Lesson, change: Mended, measured: Measured) -> Flaw:
    """Return the finding of a slip that one small change mends: its line, and what it needs."""
    words = _where(change, _compared(lesson.checks, measured))
    picture = _drawn(lesson.checks, measured)
    flaw = _finding(lesson, change.cause, measured.case, words, picture)
    return replace(flaw, line=change.lines[0])


def _where(change: Mended, compared: Words) -> Words:
    *others, last = change.lines
    values = {"compared": compared, "line": last, "change": Words(change.words)}
    if others:
        text = (
            "{compared} Lines {lines} and {line} are where it happens: with {change} in each of "
            "them all is right."
        )
        return Words(text, values | {"lines": ", ".join(map(str, others))})
    text = "{compared} Line {line} is where it happens: with {change} there all is right."
    return Words(text, values)


def _explained(lesson: Lesson, checks: Checks, diagnosis: Diagnosis) -> Flaw:
    measured = diagnosis.measured
    compared = diagnosis.note or _compared(checks, measured)
    return _finding(lesson, diagnosis.cause, measured.case, compared, _drawn(checks, measured))


def _compared(checks: Checks, measured: Measured) -> Words:
    return Words(
        "Expected: {due}. Your code: {given}.",
        {
            "due": checks.show(measured.case, measured.expected),
            "given": checks.show(measured.case, measured.given),
        },
    )


def _drawn(checks: Checks, measured: Measured) -> str:
    if checks.picture is None:
        return ""
    return checks.picture(measured.outcome, measured.expected, measured.given)


def _finding(lesson: Lesson, code: str, case: Case, compared: Words, picture: str = "") -> Flaw:
    cause = cause_of(code)
    situation = lesson.checks.situation
    return Flaw(
        lesson.number,
        case.function,
        code,
        Words(cause.symptom),
        Words("{case} {compared}", {"case": case.words, "compared": compared}),
        Words(cause.seems),
        Words(cause.advice),
        picture,
        situation(case) if situation else {},
    )


def _altered(lesson: Lesson, measured: Iterable[Measured]) -> Iterator[Flaw]:
    """Find the first case whose arguments the function has changed although it must not."""
    for item in measured:
        arrays = [value for value in item.case.arguments if isinstance(value, np.ndarray)]
        kept = [value for value in item.outcome.answers[0].after if isinstance(value, np.ndarray)]
        for before, after in zip(arrays, kept, strict=False):
            if before.shape != after.shape or not np.array_equal(before, after, equal_nan=True):
                words = Words("It was called with {before}, and left {after} there.")
                values = {"before": numbers(before), "after": numbers(after)}
                yield _finding(lesson, "altered", item.case, Words(words.text, values))
                return


def _failure(lesson: Lesson, error: StudentError, case: Case | None = None) -> Flaw:
    code = "stopped" if error.fatal else (case.on_error if case else "") or "error"
    code = "misused" if error.misused else code
    code = "not-written" if str(error).startswith("NotImplementedError") else code
    cause = cause_of(code)
    function = lesson.checks.functions[0] if case is None else case.function
    where = Words("line {line}:", {"line": error.line})
    complaint = Words(
        "{where} {error}" if error.line else "{error}", {"where": where, "error": str(error)}
    )
    words = (
        complaint
        if case is None
        else Words("{case} {complaint}", {"case": case.words, "complaint": complaint})
    )
    return Flaw(
        lesson.number,
        function,
        code,
        Words(cause.symptom),
        words,
        Words(cause.seems),
        Words(cause.advice),
        line=error.line,
    )


def _written(source: str, checks: Checks) -> bool:
    """Return whether a file has more than stubs of a lesson; a file that is not Python has more."""
    try:
        tree = ast.parse(source)
    except (SyntaxError, ValueError, RecursionError, MemoryError):
        return True
    stubs = {
        item.name for item in tree.body if isinstance(item, ast.FunctionDef) and _is_stub(item.body)
    }
    named = {item.name for item in tree.body if isinstance(item, ast.FunctionDef)}
    assigned = {
        target.id
        for item in tree.body
        if isinstance(item, ast.Assign)
        for target in item.targets
        if isinstance(target, ast.Name)
    }
    return any(name in (named | assigned) - stubs for name in checks.functions)


def _is_stub(body: list[ast.stmt]) -> bool:
    left = [item for item in body if not isinstance(item, ast.Pass) and not _is_text(item)]
    return all(isinstance(item, ast.Raise) and _says_not_written(item) for item in left)


def _says_not_written(item: ast.Raise) -> bool:
    # Walked, not dumped: an expression may be deeper than Python's stack.
    return any(
        isinstance(part, ast.Name) and part.id.startswith("NotImplemented")
        for part in ast.walk(item)
    )


def _is_text(item: ast.stmt) -> bool:
    """Return whether a statement is a docstring, or three dots."""
    return isinstance(item, ast.Expr) and isinstance(item.value, ast.Constant)
