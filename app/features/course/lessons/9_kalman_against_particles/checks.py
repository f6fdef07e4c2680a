"""Lesson 9: ``kalman(mean, sd, moved, moved_sd, seen, seen_sd)`` filters mean and deviation."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from app.features.course.grader.case import (
    REFERENCE,
    Case,
    Checks,
    Hypothesis,
    Outcome,
    Sign,
    by_mistake,
)
from app.features.course.grader.drawing import draw_bars
from app.features.course.grader.forms import array_of
from app.features.course.grader.words import Words
from robot.geometry import Array

ROUNDS: tuple[tuple[str, tuple[float, ...]], ...] = (
    ("It stands exactly, and looks: belief and look are equally sure.", (0, 0.1, 0, 0, 0.2, 0.1)),
    ("It drives, and the look tells next to nothing.", (0.3, 0.03, 0.5, 0.04, 9.0, 1e6)),
    ("It drives, and the look is exact.", (0.3, 0.05, 0.5, 0.1, 0.7, 1e-9)),
    ("It drives and looks; the look is twice as sure.", (1.0, 0.03, 0.2, 0.04, 1.3, 0.025)),
)

DRAWN = 4
"""Further rounds, of any numbers."""


def cases(seed: int) -> list[Case]:
    """Rounds whose result is seen without computing, then any."""
    rng = np.random.default_rng(seed)
    drawn = rng.uniform([-1, 0.01, -1, 0.01, -1, 0.01], [1, 0.2, 1, 0.2, 1, 0.2], (DRAWN, 6))
    rounds = [*ROUNDS, *(("It drives and looks.", tuple(row)) for row in drawn.tolist())]
    return [_round(text, numbers) for text, numbers in rounds]


def _round(text: str, numbers: tuple[float, ...]) -> Case:
    names = ("mean", "sd", "moved", "moved_sd", "seen", "seen_sd")
    values = {name: f"{value:.3g}" for name, value in zip(names, numbers, strict=True)}
    words = Words(
        "{text} Believed: {mean} ± {sd} m, moved: {moved} ± {moved_sd} m, "
        "seen: {seen} ± {seen_sd} m.",
        {"text": Words(text), **values},
    )
    return Case("kalman", tuple(map(float, numbers)), words, tolerance=1e-6)


def features(outcome: Outcome) -> Array:
    """Mean and standard deviation."""
    return array_of(outcome.result, (2,))


def expected(case: Case, mistakes: frozenset[str]) -> Array:
    """What a filter with mistakes gives."""
    mean, sd, moved, moved_sd, seen, seen_sd = case.arguments
    if "look-first" in mistakes:
        gain = sd**2 / (sd**2 + seen_sd**2)
        after = math.hypot(moved_sd, sd * math.sqrt(1 - gain))
        return np.array([mean + gain * (seen - mean) + moved, after])
    befores = {"deviations-added": sd + moved_sd, "step-sure": sd}
    before = by_mistake(mistakes, befores, math.hypot(sd, moved_sd))
    mean = mean if "step-lost" in mistakes else mean + moved
    gain = _gain((sd, moved_sd, seen_sd), before, mistakes)
    left = (1 - gain) * before**2
    variances = {
        "old-rest": (1 - gain) * sd**2,
        "rest-reversed": gain * before**2,
        "rest-squared": (left / before) ** 2,
        "never-surer": before**2,
        "seen-sd": seen_sd**2,
        "rest-of-seen": (1 - gain) * seen_sd**2,
        "rest-summed": before**2 + seen_sd**2,
        "surer-kept": min(before, seen_sd) ** 2,
        "deviations-joined": (before * seen_sd / (before + seen_sd)) ** 2,
    }
    variance = by_mistake(mistakes, variances, left)
    means = {"mean-reversed": 1 - gain, "mean-halved": 0.5, "seen-taken": 1.0, "seen-ignored": 0.0}
    gain = by_mistake(mistakes, means, gain)
    after = variance if "variance-returned" in mistakes else math.sqrt(variance)
    aheads = {
        "away": mean - seen,
        "old-mean": seen - mean + moved,
        "no-difference": seen,
    }
    belief = np.array([mean + gain * by_mistake(mistakes, aheads, seen - mean), after])
    return belief[::-1] if "exchanged" in mistakes else belief


def _gain(deviations: tuple[float, float, float], before: float, mistakes: frozenset[str]) -> float:
    sd, moved_sd, seen_sd = deviations
    usual = before**2 / (before**2 + seen_sd**2)
    gains = {
        "old-gain": sd**2 / (sd**2 + seen_sd**2),
        "deviations-weigh": before / (before + seen_sd),
        "seen-unsquared": before**2 / (before**2 + seen_sd),
        "gain-reversed": 1 - usual,
        "middle": 0.5,
        "seen-sure": 1.0,
        "step-alone": moved_sd**2 / (moved_sd**2 + seen_sd**2),
    }
    return by_mistake(mistakes, gains, usual)


def signs(outcomes: Sequence[Outcome]) -> Iterator[Sign]:
    """Say which of the two numbers is wrong, where nothing more is known."""
    chosen = _chosen(outcomes)
    if chosen is not None:
        yield Sign("surer-alone", chosen)
        return
    unsurer = next((item for item in outcomes if _is_unsurer(item)), None)
    if unsurer is not None:
        yield Sign("look-widens", unsurer, weak=True)
        return
    for outcome in outcomes:
        right = _right(outcome)
        if not right.all():
            yield Sign("spread-alone" if right[0] else "mean-alone", outcome, weak=True)
            return


def _chosen(outcomes: Sequence[Outcome]) -> Outcome | None:
    """Return what shows that the mean is always what was believed or what was seen, now this and
    now that; None if it does not."""
    chosen = []
    for outcome in outcomes:
        mean, _, moved, _, seen, _ = outcome.case.arguments
        near = np.abs(features(outcome)[0] - [mean, mean + moved, seen]) <= 1e-9
        if not near.any():
            return None
        chosen.append(bool(near[2]))
    unlike = [item for item in outcomes if not _right(item)[0]]
    # Where one of the two is all but exact, that one is due.
    return unlike[0] if unlike and len(set(chosen[-DRAWN:])) == 2 else None


def _right(outcome: Outcome) -> NDArray[np.bool_]:
    """Return of mean and deviation whether they are right."""
    right: NDArray[np.bool_] = np.abs(features(outcome) - expected(outcome.case, REFERENCE)) <= 1e-6
    return right


def _is_unsurer(outcome: Outcome) -> bool:
    """Return whether the mean is right, but less sure than the step or the look alone."""
    _, sd, _, moved_sd, _, seen_sd = outcome.case.arguments
    given, due = features(outcome), expected(outcome.case, frozenset())
    surest = min(math.hypot(sd, moved_sd), seen_sd)
    return bool(abs(given[0] - due[0]) <= 1e-6 and given[1] > surest + 1e-6)


def show(_case: Case, values: Array) -> str:
    """Return mean and standard deviation in words."""
    return f"{values[0]:.4g} ± {values[1]:.3g} m"


def picture(_outcome: Outcome, due: Array, given: Array) -> str:
    """Draw both numbers."""
    return draw_bars(due, given, ["mean", "sd"])


CHECKS = Checks(
    functions=("kalman",),
    cases=cases,
    features=features,
    expected=expected,
    hypotheses=(
        Hypothesis("gain-reversed", "gain-reversed"),
        Hypothesis("mean-reversed", "gain-reversed"),
        Hypothesis("middle", "gain-fixed"),
        Hypothesis("mean-halved", "gain-fixed"),
        Hypothesis("rest-reversed", "rest"),
        Hypothesis("rest-squared", "rest"),
        Hypothesis("away", "away"),
        Hypothesis("old-mean", "old-belief"),
        Hypothesis("seen-unsquared", "deviations-weigh"),
        Hypothesis("deviations-added", "deviations-added"),
        Hypothesis("deviations-weigh", "deviations-weigh"),
        Hypothesis("variance-returned", "variance-returned"),
        Hypothesis("step-lost", "step-lost"),
        Hypothesis("step-sure", "step-sure"),
        Hypothesis("never-surer", "never-surer"),
        Hypothesis("old-gain", "step-late"),
        Hypothesis("old-rest", "step-late"),
        Hypothesis("look-first", "look-first"),
        Hypothesis("seen-taken", "gain-fixed"),
        Hypothesis("seen-ignored", "look-lost"),
        Hypothesis("seen-sure", "seen-sure"),
        Hypothesis("seen-sd", "rest"),
        Hypothesis("rest-of-seen", "rest"),
        Hypothesis("rest-summed", "rest"),
        Hypothesis("surer-kept", "rest"),
        Hypothesis("deviations-joined", "rest"),
        Hypothesis("step-alone", "gain-of-step"),
        Hypothesis("no-difference", "no-difference"),
        Hypothesis("exchanged", "slip-order"),
    ),
    signs=signs,
    show=show,
    picture=picture,
)
