"""Lesson 8: ``inject(poses, fit, memory, anywhere, rng)`` puts new particles where the fit fell."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from types import SimpleNamespace

import numpy as np

from app.features.course.grader.case import (
    REFERENCE,
    Ask,
    Case,
    Checks,
    FormError,
    Hypothesis,
    Outcome,
    Sign,
)
from app.features.course.grader.drawing import draw_bars
from app.features.course.grader.forms import array_of, generator_signs
from app.features.course.grader.small_world import SmallWorld
from app.features.course.grader.words import Words
from robot.geometry import Array

SLOW, FAST = 0.05, 0.5
"""Shares of the newest fit that the two memories take."""
COUNT = 3000
LIKELY = 6.0
AWAY = 100.0
"""Where new particles are put in single calls, so that they can be told [m]."""
NEW_POSE = np.array([7.0, 1.0])
"""Their y [m] and heading [rad]."""
FITS = (
    ("steady", "The fit is as it always was: 0.8.", 0.8, 0.8, 0.8),
    ("worse", "The fit falls from 0.8 to 0.2.", 0.2, 0.8, 0.8),
    ("worse", "The fit has been low for a while: 0.1.", 0.1, 0.7, 0.25),
    ("worse", "The fit falls to nothing.", 0.0, 0.9, 0.9),
    ("gone", "The fit has been next to nothing for long.", 1e-12, 0.8, 1e-12),
    ("better", "The fit rises from 0.3 to 0.9.", 0.9, 0.3, 0.35),
)
"""Fit, and the memories before: slow, fast."""
RUNS, BEFORE, AFTER, PARTICLES = 20, 6, 20, 250
NEAR_M = 0.15
RULES = ("either-way", "upside-down", "difference", "newest", "half")
MIXED = (
    *("fast-of-slow", "fast-of-new-slow", "fast-of-both"),
    *("slow-of-fast", "slow-of-new-fast", "slow-of-both"),
)
KEEPINGS = {
    "grows": "memory-grows",
    "shares-exchanged": "memory-shares",
    "slow-kept": "memory-unstored",
    "fast-kept": "memory-unstored",
    "falls-alone": "memory-falls-alone",
    "slow-falls-alone": "memory-falls-alone",
    "fast-falls-alone": "memory-falls-alone",
    "alike-slow": "memory-shares",
    "shares-alone": "memory-forgets",
    "slow-share-alone": "memory-forgets",
    "fast-share-alone": "memory-forgets",
    "fast-all": "memory-shares",
    "slow-all": "memory-shares",
    "alike-fast": "memory-shares",
    **dict.fromkeys(MIXED, "memory-mixed"),
}
SHARES = {"never": 0.0, "always": 0.1, "all": 1.0}
ONE_PLACE = Words("All particles that are new are the same one.")
ALL, PLACES = (
    frozenset(
        [*SHARES, *RULES, "with-repetition", "all-if-any", "other-ratio", "old-memory", "fit-alone"]
    ),
    frozenset(["first-ones", "last-ones"]),
)


class AppendedError(FormError):
    """More particles come back than were given."""

    cause = "appended"


class LeftOutError(FormError):
    """Fewer particles come back than were given."""

    cause = "left-out"


def cases(seed: int) -> list[Case]:
    """Single calls whose share is known, then robots that are carried off."""
    made = [_call(fit, seed + 10 * index) for index, fit in enumerate(FITS)]
    words = Words("Twice with the same generator's seed, then with another.")
    seeds = (seed, seed, seed + 1)
    made.append(_asked(words, "seeds", (0.2, 0.8, 0.5), 40, seeds, np.inf))
    made.append(_carried(seed))
    return made


def _call(fit: tuple[str, str, float, float, float], seed: int) -> Case:
    kind, text, *memory = fit
    words = Words("{text} {count} particles.", {"text": Words(text), "count": COUNT})
    share = LIKELY * math.sqrt(0.25 / COUNT)
    # Where none is due a single new one is a sign, see below.
    tolerance = np.array([share, 1e-9, 1e-9, 3 * share, 0.5, 0.5])
    fit_slow_fast = (memory[0], memory[1], memory[2])
    return _asked(words, kind, fit_slow_fast, COUNT, (seed,), tolerance)


def _asked(
    words: Words,
    kind: str,
    memory: tuple[float, float, float],
    count: int,
    seeds: tuple[int, ...],
    tolerance: float | Array,
) -> Case:
    fit, slow, fast = memory
    poses = np.column_stack([np.arange(count) / count, np.zeros(count), np.zeros(count)])
    kept = SimpleNamespace(slow=slow, fast=fast)
    marked = np.column_stack([AWAY + np.arange(COUNT), np.tile(NEW_POSE, (COUNT, 1))])
    arguments = (poses, fit, kept, SimpleNamespace(supply=marked))
    return Case("inject", arguments, words, kind, tolerance, seeds)


def _carried(seed: int) -> Case:
    words = Words(
        "{runs} robots are carried off; after {rounds} rounds the cloud should be there.",
        {"runs": RUNS, "rounds": AFTER},
    )
    world = SmallWorld(seed)

    def play(ask: Ask) -> float:
        return sum(_recovers(world, seed + run, ask) for run in range(RUNS)) / RUNS

    return Case("inject", (), words, "carried", 0.11, play=play)


def _recovers(world: SmallWorld, seed: int, ask: Ask) -> bool:
    world.begin(seed)
    poses = world.pose + world.rng.normal(0, [0.05, 0.05, 0.1], (PARTICLES, 3))
    memory: SimpleNamespace | None = None
    weights = np.full(PARTICLES, 1 / PARTICLES)
    for step in range(BEFORE + AFTER):
        if step == BEFORE:
            world.pose = np.array([1.5, 0.9, -2.0])
        poses = world.motion(poses, world.drive())
        fits = world.log_weight(poses, world.measure())
        weights = np.exp(fits - fits.max())
        fit = float(np.exp(fits / 8).mean())
        poses, _ = world.resample(poses, weights)
        memory = memory or SimpleNamespace(slow=fit, fast=fit)
        anywhere = SimpleNamespace(supply=world.anywhere(PARTICLES))
        answer = ask(poses, fit, memory, anywhere, seed=seed + 1000 * step)
        poses = array_of(answer.result, poses.shape)
        memory = _memory(answer.after)
    middle = np.median(poses[:, :2], axis=0)
    return bool(np.hypot(*(middle - world.pose[:2])) < NEAR_M)


def _memory(after: Sequence[object]) -> SimpleNamespace:
    for value in after:
        if isinstance(value, SimpleNamespace):
            slow, fast = getattr(value, "slow", None), getattr(value, "fast", None)
            if isinstance(slow, int | float) and isinstance(fast, int | float):
                return SimpleNamespace(slow=float(slow), fast=float(fast))
    raise FormError("memory.slow and memory.fast have to stay numbers.")


def features(outcome: Outcome) -> Array:
    """Share of new particles, both memories, where the new ones are, how many are lost, and whether
    all are new: where all are due, a single one that stays shows.
    """
    case = outcome.case
    if case.kind == "carried":
        return np.array([outcome.result])
    _demand_as_many(outcome)
    given = array_of(outcome.result, case.arguments[0].shape)
    memory = _memory(outcome.answers[0].after)
    new = given[:, 0] >= AWAY
    place = np.flatnonzero(new).mean() / len(new) if new.any() else 0.5
    lost = (~new & (np.abs(given - case.arguments[0]).max(axis=1) > 1e-9)).sum()
    lost += (new & (np.abs(given[:, 1:] - NEW_POSE).max(axis=1) > 1e-9)).sum()
    return np.array([new.mean(), memory.slow, memory.fast, place, lost, float(new.all())])


def _demand_as_many(outcome: Outcome) -> None:
    """Raise a FormError of its own if new particles come beside the old ones, or old ones go and
    none comes in their place."""
    due = len(outcome.case.arguments[0])
    given = outcome.result
    if not isinstance(given, np.ndarray | list) or len(given) == due:
        return
    old = array_of(given, (len(given), 3))[:, 0] < AWAY
    text = "{count} particles were given; {back} come back: {old} old ones, {new} new ones."
    values = {"count": due, "back": len(old), "old": int(old.sum()), "new": int((~old).sum())}
    raise (AppendedError if len(old) > due else LeftOutError)(text, **values)


def expected(case: Case, mistakes: frozenset[str]) -> Array:
    """What formulas with mistakes give."""
    if case.kind == "carried":
        return np.ones(1)
    _, fit, memory, _ = case.arguments
    slow_rate, fast_rate = (FAST, SLOW) if "rates-swapped" in mistakes else (SLOW, FAST)
    slow = memory.slow + slow_rate * (fit - memory.slow)
    fast = memory.fast + fast_rate * (fit - memory.fast)
    if "old-memory" in mistakes:
        share = 1 - memory.fast / memory.slow
    elif "other-ratio" in mistakes:
        share = 1 - slow / fast if fast else 0.0
    elif "fit-alone" in mistakes:
        share = 1 - fit
    else:
        share = 1 - fast / slow
    slow, fast = _kept_wrongly(memory, fit, (slow, fast), mistakes)
    if mistakes & set(KEEPINGS):
        share = 1 - fast / slow if slow else 0.0
    share = _otherwise(share, slow, fast, fit, mistakes)
    share = next((rule for name, rule in SHARES.items() if name in mistakes), share)
    kept = (memory.slow, memory.fast) if "memory-kept" in mistakes else (slow, fast)
    share = float(np.clip(share, 0.0, 1.0))
    place = 0.5
    if "first-ones" in mistakes and share > 0:
        place = share / 2
    if "last-ones" in mistakes and share > 0:
        place = 1 - share / 2
    return np.array([share, *kept, place, 0.0, float(share > 1 - 1e-9)])


def _kept_wrongly(
    memory: SimpleNamespace, fit: float, due: tuple[float, float], mistakes: frozenset[str]
) -> tuple[float, float]:
    """Return the memories by another rule, if it is a mistake of these."""
    slow, fast = memory.slow, memory.fast
    rules = {
        "grows": (slow + SLOW * fit, fast + FAST * fit),
        "shares-exchanged": (fit + SLOW * (slow - fit), fit + FAST * (fast - fit)),
        "slow-kept": (slow, due[1]),
        "fast-kept": (due[0], fast),
        "slow-falls-alone": (min(slow, due[0]), due[1]),
        "fast-falls-alone": (due[0], min(fast, due[1])),
        "falls-alone": (min(slow, due[0]), min(fast, due[1])),
        "alike-slow": (due[0], fast + SLOW * (fit - fast)),
        "alike-fast": (slow + FAST * (fit - slow), due[1]),
        "shares-alone": (SLOW * fit, FAST * fit),
        "slow-share-alone": (SLOW * fit, due[1]),
        "fast-share-alone": (due[0], FAST * fit),
        "fast-all": (due[0], fit),
        "slow-all": (fit, due[1]),
        "fast-of-slow": (due[0], slow + FAST * (fit - slow)),
        "fast-of-new-slow": (due[0], due[0] + FAST * (fit - due[0])),
        "fast-of-both": (due[0], fast + FAST * (due[0] - fast)),
        "slow-of-fast": (fast + SLOW * (fit - fast), due[1]),
        "slow-of-new-fast": (due[1] + SLOW * (fit - due[1]), due[1]),
        "slow-of-both": (slow + SLOW * (due[1] - slow), due[1]),
    }
    return next((rule for name, rule in rules.items() if name in mistakes), due)


def _otherwise(
    share: float, slow: float, fast: float, fit: float, mistakes: frozenset[str]
) -> float:
    """Return the share by another rule, if it is a mistake of these."""
    rules = {
        "either-way": abs(share),
        "upside-down": 1 - share,
        "difference": slow - fast,
        "half": share / 2,
        "with-repetition": 1 - (1 - 1 / COUNT) ** (COUNT * max(share, 0.0)),
        "newest": 1 - fit / slow if slow else 0.0,
        "all-if-any": float(share > 0),
    }
    return next((rule for name, rule in rules.items() if name in mistakes), share)


def signs(outcomes: Sequence[Outcome]) -> Iterator[Sign]:
    """What shows by itself: particles that change though they stay, and the generator."""
    for outcome in outcomes:
        if outcome.case.kind == "carried":
            continue
        values = features(outcome)
        if values[4] > 0:
            yield Sign("half-replaced" if _is_mixed(outcome) else "invented", outcome)
        if outcome.case.kind == "seeds" and 0 < values[0] < 1:
            yield from generator_signs(
                outcome, [np.asarray(answer.result) for answer in outcome.answers]
            )
    worse = [item for item in outcomes if item.case.kind == "worse"]
    shares = [features(item)[0] for item in worse]
    all_or_none = bool(shares) and set(shares) <= {0.0, 1.0} and any(shares)
    if all_or_none:
        yield Sign("all-new", worse[shares.index(1.0)])
    for item in worse:
        places = np.asarray(item.result)[:, 0]
        if (places >= AWAY).sum() > 1 and np.ptp(places[places >= AWAY]) == 0:
            yield Sign("one-place", item, apart=True, note=ONE_PLACE)
            break
    memories = [item for item in outcomes if item.case.kind not in ("carried", "seeds")]
    wrong = [item for item in memories if not _remembers(item, REFERENCE)]
    if wrong:
        swapped = all(_remembers(item, frozenset(["rates-swapped"])) for item in memories)
        yield Sign("rates" if swapped else "memory", wrong[0], weak=not swapped)
        return
    fine = [item for item in memories if item.case.kind in ("steady", "better")]
    yield from (Sign("ratio", item) for item in fine if features(item)[0] > 0)
    if not all_or_none:  # each share is wrong by that alone
        yield from _shares(worse)


def _is_mixed(outcome: Outcome) -> bool:
    """Return whether each number of each particle is the old one or a new one, but not together."""
    given, old = np.asarray(outcome.result), outcome.case.arguments[0]
    new = np.column_stack([given[:, 0] >= AWAY, np.abs(given[:, 1:] - NEW_POSE) < 1e-9])
    return bool((new | (np.abs(given - old) < 1e-9)).all())


def _shares(worse: Sequence[Outcome]) -> Iterator[Sign]:
    """Name shares of new particles that are not what is due, where nothing more is known."""
    new = [round(features(item)[0] * COUNT) for item in worse]
    if 1 in new and max(new) == 1:
        yield Sign("one-replaced", worse[new.index(1)], weak=True)
        return
    for item in worse:
        share, due = features(item)[0], expected(item.case, REFERENCE)[0]
        if abs(share - due) > LIKELY * math.sqrt(0.25 / COUNT):
            yield Sign("ratio", item, weak=True)


def _remembers(outcome: Outcome, mistakes: frozenset[str]) -> bool:
    """Return whether both memories are what they are with some mistakes."""
    apart = features(outcome)[1:3] - expected(outcome.case, mistakes)[1:3]
    return bool(np.abs(apart).max() <= 1e-9)


def show(case: Case, values: Array) -> str:
    """Return the share of new particles and the memories in words."""
    if case.kind == "carried":
        return f"{round(RUNS * values[0])}/{RUNS}"
    nearly_all = 0.995 <= values[0] < 1.0
    share = f"{100 * values[0]:.{2 if nearly_all else 0}f}"
    return f"{share} %, slow {values[1]:.3f}, fast {values[2]:.3f}"


def picture(outcome: Outcome, due: Array, given: Array) -> str:
    """Draw the share of new particles and both memories."""
    if outcome.case.kind == "carried":
        return ""
    return draw_bars(due[:3], given[:3], ["new", "slow", "fast"])


def situation(_case: Case) -> dict[str, float]:
    """A robot that was carried off, and the cloud where it was."""
    return {"x": 0.25, "y": 0.25, "theta": 2, "guess_x": 0, "guess_y": 0, "guess_theta": 0}


CHECKS = Checks(
    functions=("inject",),
    cases=cases,
    features=features,
    expected=expected,
    hypotheses=(
        Hypothesis("never", "no-injection", ALL),
        Hypothesis("other-ratio", "ratio", ALL),
        Hypothesis("fit-alone", "ratio", ALL),
        *(Hypothesis(name, "ratio", ALL) for name in RULES),
        Hypothesis("with-repetition", "chosen-twice", ALL),
        Hypothesis("old-memory", "memory-late", ALL),
        Hypothesis("memory-kept", "memory-unstored"),
        *(
            Hypothesis(name, cause, broad=cause == "memory-forgets")
            for name, cause in KEEPINGS.items()
        ),
        Hypothesis("rates-swapped", "rates"),
        Hypothesis("all", "all-new", ALL),
        Hypothesis("all-if-any", "all-new", ALL, broad=True),
        Hypothesis("first-ones", "same-places", PLACES),
        Hypothesis("last-ones", "same-places", PLACES),
    ),
    signs=signs,
    show=show,
    picture=picture,
    situation=situation,
)
