"""The diagnosis: which mistakes in the reference give the student's results?"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from app.features.course.grader.case import REFERENCE, Case, Checks, Hypothesis, Outcome
from app.features.course.grader.words import Words
from robot.geometry import Array

MOST_MISTAKES = 2
"""Most mistakes that are tried together."""
PARTLY = 0.5
"""If no mistake explains all failed cases, one that explains this share of them is named."""
UNKNOWN = "differs"
"""The cause when none is known."""


@dataclass(frozen=True, eq=False)
class Measured:
    """An outcome, with its features and the reference's."""

    outcome: Outcome
    given: Array
    expected: Array

    @property
    def case(self) -> Case:
        """The case."""
        return self.outcome.case

    @property
    def passed(self) -> bool:
        """Whether the features equal the reference's."""
        return agree(self.given, self.expected, self.case.tolerance)


@dataclass(frozen=True, eq=False)
class Diagnosis:
    """A cause, and the smallest outcome that shows it."""

    cause: str
    measured: Measured
    certain: bool = True
    """Whether it explains all failed cases, and nothing else looks alike."""
    note: Words | None = None
    """What shows the cause, if the features do not."""


def agree(given: Array, expected: Array, tolerance: float | Array) -> bool:
    """Return whether features are equal up to a tolerance; nan equals nan, and inf equals inf."""
    if given.shape != expected.shape:
        return False
    with np.errstate(invalid="ignore"):
        near = np.abs(given - expected) <= tolerance
    same = (given == expected) | (np.isnan(given) & np.isnan(expected))
    return bool((near | same).all())


def diagnose(checks: Checks, measured: Sequence[Measured]) -> list[Diagnosis]:
    """Return what is wrong, the most certain first; empty if nothing is wrong."""
    by_outcome = {id(item.outcome): item for item in measured}
    signs = [
        (sign, by_outcome[id(sign.outcome)])
        for sign in checks.signs([item.outcome for item in measured])
    ]
    failed = [item for item in measured if not item.passed]
    explained = list(_explained(checks, measured, failed, 1)) if failed else []
    strong = [sign for sign, _ in signs if not (sign.weak or sign.apart)]
    for count in range(2, MOST_MISTAKES + 1):
        if failed and not explained and not strong:
            explained = list(_explained(checks, measured, failed, count))
    # Beside results that nothing explains yet, what shows by itself may follow from their cause.
    alone = not failed or bool(explained)
    named = [
        Diagnosis(sign.cause, item, alone or not sign.weak, sign.note)
        for sign, item in signs
        if sign.apart
    ]
    if not explained:
        explained = [
            Diagnosis(sign.cause, item, not failed or not sign.weak, sign.note)
            for sign, item in signs
        ]
    if not failed:
        return _by_cause([*named, *explained])
    if not explained:
        explained = list(_partly_explained(checks, measured, failed))
    return _by_cause([*explained, *named]) or [Diagnosis(UNKNOWN, failed[0], certain=False)]


def _by_cause(named: list[Diagnosis]) -> list[Diagnosis]:
    first: dict[str, Diagnosis] = {}
    for item in named:
        first.setdefault(item.cause, item)
    return list(first.values())


def _explained(
    checks: Checks, measured: Sequence[Measured], failed: Sequence[Measured], count: int
) -> Iterator[Diagnosis]:
    """Find as many mistakes that give all the features of the student's code."""
    for mistakes in _sets(checks.hypotheses, count):
        # The failed cases first: one of them already excludes most hypotheses.
        asked = (*failed, *measured)
        if not all(_may_give(checks, item, mistakes) for item in asked):
            continue
        if all(_gives(checks, item, mistakes) for item in asked):
            yield from _named(checks, mistakes, failed)
            return


def _sets(hypotheses: tuple[Hypothesis, ...], count: int) -> Iterator[tuple[Hypothesis, ...]]:
    for chosen in combinations(hypotheses, count):
        names = {item.mistake for item in chosen}
        if not any(item.excludes & (names - {item.mistake}) for item in chosen):
            yield chosen


def _may_give(checks: Checks, item: Measured, chosen: tuple[Hypothesis, ...]) -> bool:
    if checks.rough is None or len(chosen) == 1:  # of pairs there are thousands
        return True
    mistakes = frozenset(hypothesis.mistake for hypothesis in chosen)
    return agree(item.given, *checks.rough(item.case, mistakes))


def _gives(checks: Checks, item: Measured, chosen: tuple[Hypothesis, ...]) -> bool:
    mistakes = frozenset(hypothesis.mistake for hypothesis in chosen)
    return agree(item.given, checks.expected(item.case, mistakes), item.case.tolerance)


def _named(
    checks: Checks, mistakes: tuple[Hypothesis, ...], failed: Sequence[Measured]
) -> Iterator[Diagnosis]:
    for mistake in mistakes:
        for item in sorted(failed, key=lambda item: item.case.kind != mistake.kind):
            alone = checks.expected(item.case, frozenset([mistake.mistake]))
            if not agree(alone, item.expected, item.case.tolerance):
                # One slip in a line that explains all is likelier than two mistakes.
                certain = not mistake.broad and len(mistakes) == 1
                yield Diagnosis(mistake.cause, item, certain)
                break


def _partly_explained(
    checks: Checks, measured: Sequence[Measured], failed: Sequence[Measured]
) -> Iterator[Diagnosis]:
    """Find the mistake that explains most failed cases, and fails no case that passed."""
    scores = []
    passed = [item for item in measured if item.passed]
    for hypothesis in checks.hypotheses:
        hits = [item for item in failed if _gives(checks, item, (hypothesis,))]
        kept = sum(_gives(checks, item, (hypothesis,)) for item in passed)
        scores.append((len(hits) + kept - len(passed), hypothesis, hits))
    best = max(scores, key=lambda score: score[0], default=None)
    if best is not None and best[0] >= max(1, PARTLY * len(failed)):
        yield Diagnosis(best[1].cause, best[2][0], certain=False)


def expected_features(checks: Checks, case: Case) -> Array:
    """Return the features of the reference."""
    return checks.expected(case, REFERENCE)
