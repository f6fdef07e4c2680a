"""Lesson 9: ``kalman(mean, sd, moved, moved_sd, seen, seen_sd)`` filters mean and deviation."""

from __future__ import annotations

import math

import numpy as np

from app.features.course.grader.case import Case, Checks, Hypothesis, Outcome
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


def cases(seed: int) -> list[Case]:
    """Rounds whose result is seen without computing, then any."""
    rng = np.random.default_rng(seed)
    drawn = rng.uniform([-1, 0.01, -1, 0.01, -1, 0.01], [1, 0.2, 1, 0.2, 1, 0.2], (4, 6))
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
    before = sd + moved_sd if "deviations-added" in mistakes else math.hypot(sd, moved_sd)
    before = sd if "step-sure" in mistakes else before
    mean = mean if "step-lost" in mistakes else mean + moved
    power = 1 if "deviations-weigh" in mistakes else 2
    gain = before**power / (before**power + seen_sd**power)
    if "seen-unsquared" in mistakes:
        gain = before**2 / (before**2 + seen_sd)
    if "gain-reversed" in mistakes:
        gain = 1 - gain
    if "middle" in mistakes:
        gain = 0.5
    variance = (1 - gain) * before**2
    if "mean-reversed" in mistakes:
        gain = 1 - gain
    if "mean-halved" in mistakes:
        gain = 0.5
    if "rest-reversed" in mistakes:
        variance = before**2 - variance
    if "rest-squared" in mistakes:
        variance = (variance / before) ** 2
    if "never-surer" in mistakes:
        variance = before**2
    after = variance if "variance-returned" in mistakes else math.sqrt(variance)
    seen_ahead = mean - seen if "away" in mistakes else seen - mean
    seen_ahead += moved if "old-mean" in mistakes else 0.0
    return np.array([mean + gain * seen_ahead, after])


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
        Hypothesis("old-mean", "step-lost"),
        Hypothesis("seen-unsquared", "deviations-weigh"),
        Hypothesis("deviations-added", "deviations-added"),
        Hypothesis("deviations-weigh", "deviations-weigh"),
        Hypothesis("variance-returned", "variance-returned"),
        Hypothesis("step-lost", "step-lost"),
        Hypothesis("step-sure", "step-sure"),
        Hypothesis("never-surer", "never-surer"),
    ),
    show=show,
    picture=picture,
)
