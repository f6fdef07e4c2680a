"""Lesson 6: ``loop(poses, weights, moved, scan, parts)`` is one round of the whole filter."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from types import SimpleNamespace
from typing import Any
from weakref import WeakKeyDictionary

import numpy as np

from app.features.course.grader.case import (
    REFERENCE,
    Ask,
    Case,
    Checks,
    Hypothesis,
    Outcome,
    Sign,
    by_mistake,
)
from app.features.course.grader.drawing import draw_bars
from app.features.course.grader.forms import array_of, pair_of
from app.features.course.grader.mistaken_rounds import (
    SCALED,
    SIZES,
    STANDS,
    UNITS,
    effective_sizes,
    stands,
    weighed,
)
from app.features.course.grader.small_world import SmallWorld
from app.features.course.grader.words import Words
from app.features.course.sandbox.student_process import OFFERED
from robot.geometry import Array

PARTS = SimpleNamespace(
    motion=OFFERED + "motion", log_weight=OFFERED + "log_weight", resample=OFFERED + "resample"
)
EVEN, UNEVEN = np.full(4, 0.25), np.array([0.4, 0.3, 0.2, 0.1])
FLAT, SHARP, LOW = np.full(4, -2.0), np.array([0.0, -6.0, -9.0, -5.0]), np.full(4, -900.0)
MILD = np.array([0.0, -0.7, -0.4, -0.9])
LONE = np.array([0.0, -2000.0, -2001.0, -2005.0])
HEAVY = np.array([0.91, 0.03, 0.03, 0.03])
RARE, RARE_GOOD = np.array([0.7, 0.1, 0.12, 0.08]), np.array([-2.0, 0.0, -0.1, -0.2])
GOOD, BAD = np.log([0.6, 0.25, 0.1, 0.05]), np.log([0.71, 0.2, 0.05, 0.04])
MANY = np.full(10, 0.1)
MANY_GOOD = np.log([0.33, 0.2, 0.1, 0.1, 0.07, 0.06, 0.05, 0.04, 0.03, 0.02])
MANY_BAD = np.log([0.4, 0.2, 0.1, 0.08, 0.06, 0.05, 0.04, 0.03, 0.02, 0.02])
STEP = (0.05, 0, 0)
MOVES = (
    ("flat", "It moved 50 mm; all fit alike; the weights were uneven.", STEP, UNEVEN, FLAT),
    ("move", "It moved 50 mm; the particles fit a little differently.", STEP, EVEN, MILD),
    ("move", "It moved 50 mm; weights and fits are uneven.", (0.05, 0, 0.1), UNEVEN, MILD),
    ("stand", "It stands.", (0.0, 0, 0), UNEVEN, MILD),
    ("stand", "It stands: it moved 0.8 mm.", (0.0008, 0, 0), UNEVEN, MILD),
    ("stand", "It stands: it turned 0.008 rad.", (0.0, 0, 0.008), UNEVEN, MILD),
    ("stand", "It stands: it turned 0.0005 rad.", (0.0, 0, 0.0005), UNEVEN, MILD),
    ("stand", "It stands: it moved 0.8 mm, and turned 0.0008 rad.", (0.0008, 0, 0.0008), UNEVEN,
     MILD),
    ("stand", "It stands: it moved 0.6 mm ahead and 0.6 mm to the side.", (0.0006, 0.0006, 0),
     UNEVEN, MILD),
    ("move", "It moved 0.8 mm ahead and 0.8 mm to the side.", (0.0008, 0.0008, 0), UNEVEN, MILD),
    ("move", "It moved 1.2 mm.", (0.0012, 0, 0), UNEVEN, MILD),
    ("move", "It moved 1.2 mm, nearly all of it to the side.", (0.0002, 0.0012, 0), UNEVEN, MILD),
    ("move", "It turned 0.012 rad on the spot.", (0.0, 0, 0.012), UNEVEN, MILD),
    ("move", "It turned 0.012 rad to the right on the spot.", (0.0, 0, -0.012), UNEVEN, MILD),
    ("move", "It moved 50 mm backwards.", (-0.05, 0, 0), UNEVEN, MILD),
    ("survive", "It moved 50 mm; one particle fits far better.", STEP, EVEN, SHARP),
    ("heavy", "It moved 50 mm; one particle had nearly all the weight.", STEP, HEAVY, MILD),
    ("low", "It moved 50 mm; all log-weights are about -900.", STEP, UNEVEN, LOW + MILD),
    ("survive", "It moved 50 mm; log-weights are about -900, one fits far better.", STEP, UNEVEN,
     LOW + SHARP),
    ("survive", "It moved 50 mm; one particle fits, the others not at all.", STEP, UNEVEN, LONE),
    ("edge", "It moved 50 mm; the weights were uneven, and the scan makes up for it.", STEP, RARE,
     RARE_GOOD),
    ("edge", "The effective sample size is 2.2 of 4.", STEP, EVEN, GOOD),
    ("edge", "The effective sample size is 1.8 of 4.", STEP, EVEN, BAD),
    ("edge", "The effective sample size is 5.5 of 10.", STEP, MANY, MANY_GOOD),
    ("edge", "The effective sample size is 4.4 of 10.", STEP, MANY, MANY_BAD),
)  # fmt: skip
RUNS, ROUNDS, COUNT = 20, 8, 150
"""Drives through the small world, each with its own seed."""
NEAR_M = 0.12
TIMES = frozenset(["never-resamples", "always-resamples", "the-other-way"])
_TOLD: WeakKeyDictionary[Outcome, Array] = WeakKeyDictionary()


@dataclass(eq=False)
class CountedParts:
    """The parts of a filter, so simple that their results are known; counts its calls."""

    fits: Array
    calls: dict[str, int] = field(default_factory=dict)
    drawn: float = 0.0
    """The sum of the weights that resample was given last; 0 before."""

    def reset(self) -> None:
        """Count from zero."""
        self.calls = {"motion": 0, "log_weight": 0, "resample": 0}
        self.drawn = 0.0

    def motion(self, poses: Array, moved: Array) -> Array:
        """Add the step."""
        self.calls["motion"] += 1
        return np.asarray(poses) + np.asarray(moved)

    def log_weight(self, poses: Array, scan: float) -> Array:
        """Return the fits; they depend on the poses, so that the order shows."""
        self.calls["log_weight"] += 1
        x, y, _ = np.asarray(poses).T
        fits: Array = self.fits + 4 * y + 100 * (x - scan) * (1 + y)  # a step alters their ratios
        return fits

    def resample(self, poses: Array, weights: Array) -> tuple[Array, Array]:
        """Draw the heaviest twice, and forget the lightest."""
        self.calls["resample"] += 1
        known = np.nan_to_num(np.asarray(weights))
        self.drawn = float(known.sum())
        order = np.argsort(-known, kind="stable")
        drawn = np.append(order[0], order[:-1])
        return np.asarray(poses)[drawn], np.full(len(drawn), 1 / len(drawn))

    @property
    def offered(self) -> dict[str, Callable[..., Any]]:
        """The functions by name."""
        return {
            "motion": self.motion,
            "log_weight": self.log_weight,
            "resample": self.resample,
        }


def cases(seed: int) -> list[Case]:
    """Single rounds whose result is known; then whole drives."""
    rng = np.random.default_rng(seed)
    made = [_round(move, rng) for move in MOVES]
    words = Words("{runs} drives of {rounds} rounds.", {"runs": RUNS, "rounds": ROUNDS})
    made.append(_drives(words, seed))
    return made


def _round(move: tuple[str, str, Any, Array, Array], rng: np.random.Generator) -> Case:
    kind, text, moved, weights, fits = move
    recorder = CountedParts(fits)
    count = len(weights)
    poses = np.column_stack(
        [np.full(count, 0.3), rng.uniform(-0.02, 0.02, count), rng.uniform(-1, 1, count)]
    )
    if kind in ("flat", "edge"):
        poses[:, 1] = 0.0
    arguments = (poses, weights.copy(), np.array(moved, dtype=float), 0.3, PARTS)
    return Case(
        "loop", arguments, Words(text), kind, 1e-9, offered=recorder.offered, begin=recorder.reset
    )


def _drives(words: Words, seed: int) -> Case:
    world = SmallWorld(seed)

    def play(ask: Ask) -> float:
        near = 0
        for run in range(RUNS):
            world.begin(seed + run)
            poses = world.pose + world.rng.normal(0, [0.1, 0.1, 0.2], (COUNT, 3))
            weights = np.full(COUNT, 1 / COUNT)
            for _ in range(ROUNDS):
                moved, scan = world.drive(), world.measure()
                poses, weights = _valid(ask(poses, weights, moved, scan, PARTS).result, COUNT)
            near += world.error(poses, weights) < NEAR_M
        return near / RUNS

    offered = {
        "motion": world.motion,
        "log_weight": world.log_weight,
        "resample": world.resample,
    }
    return Case("loop", (), words, "drives", 0.11, offered=offered, play=play)


def _valid(result: Any, count: int) -> tuple[Array, Array]:
    poses, weights = pair_of(result)
    return array_of(poses, (count, 3)), array_of(weights, (count,), finite=False)


def features(outcome: Outcome) -> Array:
    """Weights and poses after the round, the sum of what was drawn from, which parts were asked."""
    if outcome.case.kind == "drives":
        return np.array([outcome.result])
    if outcome not in _TOLD:  # the case's counts are those of its last round alone
        _TOLD[outcome] = _features(*_valid(outcome.result, _count(outcome.case)), outcome.case)
    return _TOLD[outcome]


def _count(case: Case) -> int:
    return len(case.arguments[1])


def _features(poses: Array, weights: Array, case: Case) -> Array:
    recorder: CountedParts = case.offered["motion"].__self__  # type: ignore[attr-defined]
    asked = [min(1, count) for count in recorder.calls.values()]
    return np.concatenate([weights, poses.ravel(), np.array([recorder.drawn, *asked])])


def expected(case: Case, mistakes: frozenset[str]) -> Array:
    """What a round with mistakes gives."""
    if case.kind == "drives":
        return np.ones(1)
    recorder: CountedParts = case.offered["motion"].__self__  # type: ignore[attr-defined]
    recorder.reset()
    with np.errstate(all="ignore"):
        before, prior, moved, scan, _ = case.arguments
        poses, weights = _loop(before, prior, moved, scan, recorder, mistakes)
    return _features(poses, weights, case)


def _loop(
    poses: Array,
    weights: Array,
    moved: Array,
    scan: float,
    parts: CountedParts,
    mistakes: frozenset[str],
) -> tuple[Array, Array]:
    standing = stands(moved, mistakes)
    if standing and "only-motion-stands" not in mistakes and "updates" not in mistakes:
        return (parts.motion(poses, moved) if "moves-standing" in mistakes else poses), weights
    before = poses
    if not (standing and "only-motion-stands" in mistakes):
        poses = parts.motion(poses, moved)
    if "motion-lost" in mistakes:
        poses = before
    if "moves-twice" in mistakes:
        poses = parts.motion(poses, moved)
    early = "draws-early" in mistakes and 1 / (weights**2).sum() < len(poses) / 2
    if "draws-first" in mistakes or early:
        poses, weights = parts.resample(poses, weights)
    fits = parts.log_weight(before if "weighs-first" in mistakes else poses, scan)
    prior = np.full(len(poses), 1 / len(poses)) if "prior-lost" in mistakes else weights
    weights = weighed(prior, fits, mistakes)
    if "draws-old" in mistakes:
        drawn, even = _survivors(before, weights, parts, mistakes)
        return (poses, weights) if drawn is before else (drawn, even)
    if "draws-early" in mistakes:
        return poses, weights
    if "not-kept" in mistakes:
        drawn, _ = _survivors(poses, weights, parts, REFERENCE)
        return (poses, prior) if drawn is poses else parts.resample(poses, prior)
    raw = weighed(prior, fits, mistakes | {"not-normalized"})
    raw = weighed(np.ones(len(poses)), fits, REFERENCE) if "draws-by-scan" in mistakes else raw
    drawn, weights = _survivors(poses, weights, parts, mistakes, raw)
    return drawn, np.log(weights) if "log-returned" in mistakes and drawn is poses else weights


def _survivors(
    poses: Array,
    weights: Array,
    parts: CountedParts,
    mistakes: frozenset[str],
    raw: Array | None = None,
) -> tuple[Array, Array]:
    """Return what is left of particles, by their weights or by those whose sum is another yet."""
    shares = weights / weights.sum() if "normalized-late" in mistakes else weights
    of_raw = mistakes & {"size-unnormalized", "draws-by-scan"}
    shares = raw if raw is not None and of_raw else shares
    effective = 1 / (shares**2).sum()
    if mistakes & set(SIZES):
        effective = by_mistake(mistakes, effective_sizes(shares), effective)
    wanted = effective < len(poses) / 2
    if "never-resamples" in mistakes:
        wanted = np.bool_(False)
    if "always-resamples" in mistakes:
        wanted = np.bool_(True)
    if "the-other-way" in mistakes:
        wanted = effective > len(poses) / 2
    if not wanted:
        return poses, weights
    of_raw = mistakes & {"draws-unnormalized", "draws-by-scan"}
    shares = raw if raw is not None and of_raw else weights
    drawn, even = parts.resample(poses, shares)
    if "survivors-lost" in mistakes:
        return poses, weights
    return drawn, weights if "weights-kept" in mistakes else even


def signs(outcomes: Sequence[Outcome]) -> Iterator[Sign]:
    """What shows by itself: a scan that counts while standing, a past that is forgotten, nan."""
    even = all(_right(item) for item in outcomes if item.case.words.text == MOVES[1][1])
    for outcome in outcomes:
        if outcome.case.kind == "drives":
            continue
        given, due = features(outcome), expected(outcome.case, REFERENCE)
        weights = slice(_count(outcome.case))
        if outcome.case.kind == "stand" and np.abs(given[weights] - due[weights]).max() > 1e-9:
            yield Sign("R5", outcome)
        if even and not np.isfinite(given[weights]).all():
            yield Sign("S1", outcome, weak=True)
        if even and outcome.case.kind == "flat" and np.ptp(given[weights]) < 1e-9 and not given[-1]:
            yield Sign("R6", outcome)
    yield from _areas(outcomes)


def _right(outcome: Outcome) -> bool:
    due = expected(outcome.case, REFERENCE)
    return bool((np.abs(features(outcome) - due) <= outcome.case.tolerance).all())


def _areas(outcomes: Sequence[Outcome]) -> Iterator[Sign]:
    """Say which part is wrong, where nothing more is known: standing, weights, or when to draw."""
    for outcome in outcomes:
        if outcome.case.kind == "drives":
            continue
        given, due = features(outcome), expected(outcome.case, REFERENCE)
        if np.abs(given - due).max() <= outcome.case.tolerance:
            continue
        poses, weights = outcome.case.arguments[:2]
        kept = np.concatenate([weights, poses.ravel()])
        if outcome.case.kind != "stand" and np.array_equal(given[: len(kept)], kept):
            yield Sign("standing", outcome, weak=True)
        elif given[-1] != due[-1]:
            yield Sign("threshold", outcome, weak=True)
        elif given[-1]:
            yield Sign("after-drawing", outcome, weak=True)
        else:
            shared = _as_shared(given[: len(weights)], due[: len(weights)])
            yield Sign("not-normalized" if shared else "new-weights", outcome, weak=True)
        return


def _as_shared(given: Array, due: Array) -> bool:
    """Return whether weights are right but for their sum."""
    with np.errstate(all="ignore"):
        return bool(np.allclose(given / given.sum(), due, rtol=0, atol=1e-9))


def show(case: Case, values: Array) -> str:
    """Return weights in words, or how many drives ended at the robot."""
    if case.kind == "drives":
        return f"{round(RUNS * values[0])}/{RUNS}"
    asked = values[-3:] > 0
    names = [name for name, was in zip(vars(PARTS), asked, strict=True) if was]
    weights = ", ".join(f"{weight:.3f}" for weight in values[: _count(case)])
    called = ", ".join(names) or "–"
    return f"{weights}; called: {called}"


def picture(outcome: Outcome, due: Array, given: Array) -> str:
    """Draw the weights."""
    if outcome.case.kind == "drives":
        return ""
    count = _count(outcome.case)
    return draw_bars(due[:count], given[:count], [str(number) for number in range(count)])


CHECKS = Checks(
    functions=("loop",),
    cases=cases,
    features=features,
    expected=expected,
    hypotheses=(
        Hypothesis("updates", "R5", frozenset(["only-motion-stands"]), "stand"),
        Hypothesis("only-motion-stands", "R5", frozenset(["updates"]), "stand"),
        Hypothesis("prior-lost", "R6"),
        Hypothesis("underflow", "S1", kind="low"),
        Hypothesis("weights-kept", "R1", kind="survive"),
        Hypothesis("weighs-first", "order", frozenset(["motion-lost"])),
        Hypothesis("motion-lost", "motion-lost", frozenset(["weighs-first"])),
        Hypothesis("not-normalized", "not-normalized"),
        Hypothesis("normalized-late", "not-normalized"),
        Hypothesis("size-unnormalized", "size-unnormalized"),
        Hypothesis("no-exponential", "exponential"),
        Hypothesis("log-added", "exponential"),
        Hypothesis("log-log", "exponential"),
        Hypothesis("log-times", "exponential"),
        *(
            Hypothesis(name, "exponential")
            for name in (
                *("ratios-times", "exp-of-product", "exp-of-sum", "fits-alone", "ratios-alone"),
                "spread-times",
            )
        ),
        *(Hypothesis(name, "logs-divided", frozenset(SCALED)) for name in SCALED),
        Hypothesis("added", "added"),
        Hypothesis("averaged", "added"),
        *(Hypothesis(name, "size-formula", TIMES, "edge") for name in SIZES),
        Hypothesis("not-kept", "S7"),
        Hypothesis("draws-by-scan", "R6", kind="edge"),
        Hypothesis("never-resamples", "no-resampling", TIMES, broad=True),
        Hypothesis("always-resamples", "resampling-always", TIMES, broad=True),
        Hypothesis("the-other-way", "resampling-reversed", TIMES),
        Hypothesis("by-largest", "not-normalized"),
        Hypothesis("by-count", "not-normalized"),
        Hypothesis("survivors-lost", "survivors-lost"),
        Hypothesis("draws-first", "resampling-early"),
        Hypothesis("draws-early", "resampling-early"),
        Hypothesis("draws-old", "motion-lost"),
        Hypothesis("moves-standing", "moves-standing"),
        Hypothesis("moves-twice", "counts-twice"),
        Hypothesis("prior-squared", "counts-twice"),
        Hypothesis("scan-twice", "counts-twice"),
        Hypothesis("worse-more", "slip-sign", broad=True),
        Hypothesis("log-returned", "log-returned"),
        *(Hypothesis(name, "standing", frozenset(STANDS)) for name in STANDS),
        Hypothesis("turn-in-degrees", "S4", frozenset(STANDS)),
        *(Hypothesis(name, "standing-units", frozenset(STANDS), broad=True) for name in UNITS),
        Hypothesis("draws-unnormalized", "drawn-unnormalized", kind="survive"),
    ),
    signs=signs,
    show=show,
    picture=picture,
)
