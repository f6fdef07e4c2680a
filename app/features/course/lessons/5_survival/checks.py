"""Lesson 5: ``resample(poses, weights, rng)`` draws the particles that survive, by weight."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from app.features.course.grader.case import Case, Checks, Hypothesis, Outcome, Sign
from app.features.course.grader.drawing import draw_bars
from app.features.course.grader.forms import array_of, generator_signs, pair_of
from app.features.course.grader.words import Words
from app.features.course.sandbox.student_process import Answer
from robot.geometry import Array

DRAWS = 60
"""Draws over which the copies of each particle are averaged."""
PAIR_DRAWS = 400
"""Draws of two particles: steps of 1/(n + 1) give 4/3 and 2/3 copies, far beyond chance."""
LIKELY = 6.0
"""Standard errors that no correct sampler differs by."""
STRETCHED = ("to-the-end", "towards-the-end", "to-the-last-step", "to-the-other-side")
"""Numbers that are spread out to another end than theirs."""
OFTEN = 1.5
"""Copies that are due on the average to a particle that has two in many a draw."""
STARTS = (np.arange(500) + 0.5) / 500
"""First numbers over which copies are averaged, as shares of 1/n."""
Indices = NDArray[np.intp]
ORDERS: tuple[Callable[[Array], Indices], ...] = (
    np.argsort,
    lambda weights: np.argsort(weights)[::-1],
    lambda weights: np.arange(len(weights))[::-1],
)
"""Orders in which weights are laid on the line while the particles keep theirs."""
UNLIKE = -1
"""Index of a particle that was not among those given."""
SHARED = Words("Two of the particles that come back are one and the same in memory.")


def cases(seed: int) -> list[Case]:
    """One particle has all the weight; some have none; then many draws."""
    rng = np.random.default_rng(seed)
    made = [_sole(place, 6) for place in (0, 2, 5)]
    made.append(_many(np.array([0.5, 0.0, 0.3, 0.0, 0.2]), seed))
    uneven = np.tile([0.02, 0.18], 5) * rng.uniform(0.8, 1.2, 10)
    made.append(_many(uneven / uneven.sum(), seed + 100))
    small = rng.uniform(size=40) ** 3 * (rng.random(40) < 0.7)
    made.append(_many(small / small.sum(), seed + 200))
    made.append(_many(np.full(2, 0.5), seed + 300, PAIR_DRAWS))  # where a step is the longest
    words = Words("Twice with the same generator's seed, then with others.")
    even = rng.uniform(0.5, 1.5, 40)
    arguments = (_poses(40), even / even.sum())
    seeds = tuple(seed + 1 + index // 2 for index in range(12))
    made.append(Case("resample", arguments, words, "seeds", np.inf, seeds))
    return made


def _poses(count: int) -> Array:
    index = np.arange(count)
    return np.column_stack([0.1 * index, 1 - 0.01 * index, index / count])


def _sole(place: int, count: int) -> Case:
    words = Words(
        "Of {count} particles, number {place} has all the weight (counted from 0).",
        {"count": count, "place": place},
    )
    return Case("resample", (_poses(count), np.eye(count)[place]), words, "sole", 1e-9, (5,))


def _many(weights: Array, seed: int, draws: int = DRAWS) -> Case:
    count = len(weights)
    words = Words(
        "{count} particles with the weights {weights}; {draws} draws.",
        {
            "count": count,
            "weights": ", ".join(f"{weight:.2f}" for weight in weights[:10]),
            "draws": draws,
        },
    )
    # The most that copies vary, by the plainest sampler; better ones vary less.
    error = LIKELY * np.sqrt(count * weights * (1 - weights) / draws) + 1e-9
    seeds = tuple(range(seed, seed + draws))
    return Case("resample", (_poses(count), weights), words, "many", error, seeds)


def features(outcome: Outcome) -> Array:
    """How many copies there are of each particle, on the average."""
    count = len(outcome.case.arguments[1])
    copies = np.zeros(count)
    for answer in outcome.answers:
        drawn = _drawn(answer, outcome.case)
        copies += np.bincount(drawn[drawn != UNLIKE], minlength=count)
    return copies / len(outcome.answers)


def _drawn(answer: Answer, case: Case) -> Indices:
    """Return which particle each copy is of (n,)."""
    given: Array = case.arguments[0]
    poses = array_of(pair_of(answer.result)[0], given.shape)
    apart: Array = np.abs(poses[:, None] - given).max(axis=2)
    nearest = np.asarray(apart.argmin(axis=1), dtype=np.intp)
    nearest[apart.min(axis=1) >= 1e-9] = UNLIKE
    return nearest


def expected(case: Case, mistakes: frozenset[str]) -> Array:
    """How many copies there would be, on the average, with mistakes."""
    weights: Array = case.arguments[1]
    rule = next((rule for name, rule in RULES.items() if name in mistakes), None)
    return len(weights) * (rule(weights) if rule else weights)


def _shifted(weights: Array, shift: int) -> Array:
    moved = np.zeros(len(weights))
    np.add.at(moved, np.clip(np.arange(len(weights)) + shift, 0, len(weights) - 1), weights)
    return moved


def _stepped(weights: Array, parts: float) -> Array:
    """Return the copies' shares where each step is one of as many parts of the line.

    Of infinitely many parts, no step goes anywhere.
    """
    count = len(weights)
    points = STARTS[:, None] / count + np.arange(count) / parts
    drawn = np.searchsorted(np.cumsum(weights), points).clip(0, count - 1)
    return np.bincount(drawn.ravel(), minlength=count) / points.size


def _combed(weights: Array, end: Callable[[Array], Array], *, closed: bool) -> Array:
    """Return the copies' shares where n numbers go from the first one to an end, which is one of
    them or not."""
    count = len(weights)
    first = STARTS / count
    points = np.linspace(first, end(first), count, endpoint=closed)
    drawn = np.searchsorted(np.cumsum(weights), points).clip(0, count - 1)
    return np.bincount(drawn.ravel(), minlength=count) / points.size


def _with_last(weights: Array) -> Array:
    """Return the copies' shares where the last number's survivor gives way to the last particle."""
    count = len(weights)
    points = (STARTS[:, None] + np.arange(count - 1)) / count
    drawn = np.searchsorted(np.cumsum(weights), points).clip(0, count - 1)
    copies = np.bincount(drawn.ravel(), minlength=count) / len(STARTS)
    copies[-1] += 1
    return copies / count


RULES: dict[str, Callable[[Array], Array]] = {
    "next-one": lambda weights: _shifted(weights, 1),
    "one-before": lambda weights: _shifted(weights, -1),
    "next-one-around": lambda weights: np.roll(weights, 1),
    "one-before-around": lambda weights: np.roll(weights, -1),
    "equal": lambda weights: np.full(len(weights), 1 / len(weights)),
    "best": lambda weights: np.eye(len(weights))[int(weights.argmax())],
    "squares": lambda weights: weights**2 / (weights**2).sum(),
    "roots": lambda weights: np.sqrt(weights) / np.sqrt(weights).sum(),
    "longer-steps": lambda weights: _stepped(weights, len(weights) - 1),
    "shorter-steps": lambda weights: _stepped(weights, len(weights) + 1),
    "last-added": _with_last,
    "to-the-end": lambda weights: _combed(weights, np.ones_like, closed=True),
    "towards-the-end": lambda weights: _combed(weights, np.ones_like, closed=False),
    "to-the-last-step": lambda weights: _combed(
        weights, lambda first: np.full_like(first, 1 - 1 / len(weights)), closed=True
    ),
    "to-the-other-side": lambda weights: _combed(weights, lambda first: 1 - first, closed=True),
    "no-steps": lambda weights: _stepped(weights, np.inf),
}


def signs(outcomes: Sequence[Outcome]) -> Iterator[Sign]:
    """What shows by itself: weights that come back, shared memory, survivors without weight."""
    for outcome in outcomes:
        if outcome.answers[0].linked:
            yield Sign("R3", outcome, apart=True, note=SHARED)
        yield from _weights(outcome)
        if outcome.case.kind == "seeds":
            draws = [_drawn(answer, outcome.case) for answer in outcome.answers]
            chance = [] if (draws[0] == UNLIKE).any() else _chance(outcome, draws)
            yield from chance
            if any(sign.cause == "no-chance" for sign in chance):
                return  # who survives without chance follows from that
    yield from _survivors(outcomes)


def _chance(outcome: Outcome, draws: Sequence[Indices]) -> list[Sign]:
    """Compare draws, of pair each with one seed: pair that are not rng's may be alike by chance."""
    pairs = [draws[index : index + 2] for index in range(0, len(draws), 2)]
    apart = next((pair for pair in pairs if not np.array_equal(pair[0], pair[1])), pairs[0])
    return list(generator_signs(outcome, [*apart, *draws[::2]]))


def _survivors(outcomes: Sequence[Outcome]) -> Iterator[Sign]:
    """Name survivors that have nothing to do with the weights, or not enough."""
    many = [item for item in outcomes if item.case.kind == "many"]
    wrong: list[tuple[Outcome, bool]] = []
    copies = [
        np.concatenate([_drawn(answer, item.case) for answer in item.answers]) for item in outcomes
    ]
    invented = [item for item, each in zip(outcomes, copies, strict=True) if UNLIKE in each]
    if invented:
        yield Sign("invented", invented[0])
        return  # how often each survives cannot be told
    if many and (whole := _whole_cloud(many)):
        yield whole
        return
    for outcome, drawn in zip(outcomes, copies, strict=True):
        weightless = (outcome.case.arguments[1][drawn] == 0).sum()
        if weightless and not outcome.answers[0].shared:
            wrong.append((outcome, _beside(outcome, drawn) or _immortal(outcome, drawn)))
    asked = [item for item in outcomes if item.case.kind != "seeds"]
    unlike = [item for item in many if not _as_weighed(item)]
    rule = _rule(unlike, asked)
    if rule:
        yield Sign("by-rank" if rule == "copies-fixed" and wrong else rule, unlike[0])
        return
    if unlike and not wrong:
        light = all(_is_light_lost(item) for item in unlike)
        yield Sign("light-lost" if light else "line", unlike[0], weak=True)
    if wrong:
        beside = all(near for _, near in wrong)
        # An index that is off by one is so always, but where it is cut off at an end.
        always = sum(item.case.kind == "sole" for item, _ in wrong) > 1
        yield Sign("R4" if beside else "line", wrong[0][0], weak=not (beside and always))


def _rule(unlike: Sequence[Outcome], asked: Sequence[Outcome]) -> str:
    """Return the cause where another rule of drawing gives all that was drawn; "" without one."""
    if not unlike:
        return ""
    rules = {
        "order-apart": any(all(_as_weighed(item, order) for item in asked) for order in ORDERS),
        "start-anywhere": all(_starts_anywhere(item) for item in asked),
        "nearest-edge": all(_takes_nearest(item) for item in asked),
        "filled-up": all(_is_filled_up(item) for item in unlike),
        "copies-fixed": all(_is_fixed(item) for item in unlike),
    }
    return next((cause for cause, explains in rules.items() if explains), "")


def _whole_cloud(many: Sequence[Outcome]) -> Sign | None:
    """Name draws in which all particles survive alike, or one alone, another one each time."""
    if all(np.abs(features(item) - 1).max() < LIKELY / DRAWS**0.5 for item in many):
        return Sign("weights-ignored", many[0], weak=True)
    always_one = all((features(item) > 0).sum() == 1 for item in many)
    if all(_is_one_alone(item) for item in many) and not always_one:
        return Sign("one-survivor", many[0])
    return None


def _is_one_alone(outcome: Outcome) -> bool:
    """Return whether all survivors of each draw are copies of one particle."""
    return all(np.ptp(_drawn(each, outcome.case)) == 0 for each in outcome.answers)


def _is_filled_up(outcome: Outcome) -> bool:
    """Return whether no particle but the heaviest ever has a second copy, though others should."""
    count = len(outcome.case.arguments[1])
    copies = np.array(
        [np.bincount(_drawn(each, outcome.case), minlength=count) for each in outcome.answers]
    )
    most = copies.max(axis=0)
    several = most > 1
    due = expected(outcome.case, frozenset())
    alone = several.sum() == 1 and several[due.argmax()]
    return bool(alone and (due[~several] >= OFTEN).any())


def _is_fixed(outcome: Outcome) -> bool:
    """Return whether each draw gives each particle the same number of copies."""
    copies = [np.sort(_drawn(each, outcome.case)) for each in outcome.answers]
    return all(np.array_equal(copies[0], each) for each in copies)


def _starts_anywhere(outcome: Outcome) -> bool:
    """Return whether steps of 1/n from a number between 0 and 1 give each draw: those that end
    beyond the line are the last particle's."""
    line = np.cumsum(outcome.case.arguments[1])
    return _stepped_from(
        outcome, line, 1.0, lambda points: np.searchsorted(line, points).clip(0, len(line) - 1)
    )


def _takes_nearest(outcome: Outcome) -> bool:
    """Return whether each number of a right draw takes the particle whose weight ends nearest."""
    line = np.cumsum(outcome.case.arguments[1])
    middles = (line[:-1] + line[1:]) / 2
    return _stepped_from(
        outcome,
        middles,
        1 / len(line),
        lambda points: np.abs(line - points[..., None]).argmin(axis=-1),
    )


def _stepped_from(
    outcome: Outcome, ends: Array, longest: float, taken: Callable[[Array], Indices]
) -> bool:
    """Return whether steps of 1/n from a number between 0 and the longest give each draw, where
    another particle is taken beyond each of the ends."""
    count = len(outcome.case.arguments[1])
    steps = np.arange(count) / count
    # Between two of these starts, no step comes to another particle.
    bends = np.unique(np.clip(ends[:, None] - steps, 0, longest))
    bends = np.unique([0.0, *bends, longest])
    given = taken((bends[:-1] + np.diff(bends) / 2)[:, None] + steps)
    possible = {tuple(np.bincount(drawn, minlength=count)) for drawn in given}
    draws = [_drawn(answer, outcome.case) for answer in outcome.answers]
    return all(
        tuple(np.bincount(drawn[drawn != UNLIKE], minlength=count)) in possible for drawn in draws
    )


def _is_light_lost(outcome: Outcome) -> bool:
    """Return whether no particle that is lighter than the average survives, though it should."""
    due, copies = expected(outcome.case, frozenset()), features(outcome)
    light = (due < 1) & (due > 0)
    return bool(light.any() and not copies[light].any())


def _immortal(outcome: Outcome, drawn: Indices) -> bool:
    """Return whether the first particle survives once in each draw, and no other without weight."""
    undue = drawn[outcome.case.arguments[1][drawn] == 0]
    return len(undue) <= len(outcome.answers) and not undue.any()


def _as_weighed(outcome: Outcome, order: Callable[[Array], Indices] | None = None) -> bool:
    """Return whether there are as many copies as are due; with the weights in another order."""
    weights = outcome.case.arguments[1]
    due, error = expected(outcome.case, frozenset()), outcome.case.tolerance
    error = np.broadcast_to(error, due.shape)
    if order is not None:
        due, error = due[order(weights)], error[order(weights)]
    return bool((np.abs(features(outcome) - due) <= error).all())


def _beside(outcome: Outcome, drawn: Indices) -> bool:
    """Return whether most survivors sit beside the one that has all the weight, and the others are
    that one: an index that is off by one is so for all but those at an end of the list."""
    if outcome.case.kind != "sole":
        return True  # what is beside what cannot be told
    count = len(outcome.case.arguments[1])
    apart = (drawn - int(outcome.case.arguments[1].argmax())) % count
    return bool(np.isin(apart, (0, 1, count - 1)).all() and (apart != 0).mean() > 0.5)


def _weights(outcome: Outcome) -> Iterator[Sign]:
    """Compare the weights that come back with what they should be, and might be."""
    answer, before = outcome.answers[0], outcome.case.arguments[1]
    count = len(before)
    weights = array_of(pair_of(answer.result)[1], (count,), finite=False)
    drawn = _drawn(answer, outcome.case)
    if np.abs(weights - 1 / count).max() < 1e-9 or outcome.case.kind == "seeds":
        return
    kept = before[drawn]
    text = "The weights that come back are {weights}; {due} each is due."
    values = {"weights": ", ".join(f"{weight:.2f}" for weight in weights[:8]), "due": f"1/{count}"}
    note = Words(text, values)
    for likely, cause in ((before, "R2"), (kept, "R1"), (kept / max(kept.sum(), 1e-300), "R1")):
        if outcome.case.kind == "many" and np.abs(weights - likely).max() < 1e-9:
            yield Sign(cause, outcome, apart=True, note=note)
            return
    if outcome.case.kind == "many":
        yield Sign("weights", outcome, apart=True, note=note)


def show(_case: Case, values: Array) -> str:
    """Return numbers of copies in words."""
    return ", ".join(f"{value:.2g}" for value in values[:10]) + (
        ", ..." if len(values) > 10 else ""
    )


def picture(_outcome: Outcome, due: Array, given: Array) -> str:
    """Draw how many copies of each particle there are."""
    return draw_bars(due[:10], given[:10], [str(index) for index in range(min(10, len(due)))])


ALL = frozenset(RULES)
CHECKS = Checks(
    functions=("resample",),
    cases=cases,
    features=features,
    expected=expected,
    hypotheses=(
        *(Hypothesis(name, "R4", ALL) for name in list(RULES)[:4]),
        Hypothesis("equal", "weights-ignored", ALL, broad=True),
        Hypothesis("best", "best-only", ALL),
        Hypothesis("squares", "weights-changed", ALL),
        Hypothesis("roots", "weights-changed", ALL),
        Hypothesis("longer-steps", "steps", ALL),
        Hypothesis("shorter-steps", "steps", ALL),
        *(Hypothesis(name, "steps-stretched", ALL) for name in STRETCHED),
        Hypothesis("no-steps", "steps-lost", ALL),
        Hypothesis("last-added", "undrawn", ALL, broad=True),
    ),
    signs=signs,
    show=show,
    picture=picture,
)
