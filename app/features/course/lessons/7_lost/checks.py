"""Lesson 7: ``init(extent, count, rng)`` and ``estimate(poses, weights)``: lost on a field."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from app.features.course.grader.case import (
    Case,
    Checks,
    Hypothesis,
    Outcome,
    Sign,
    by_mistake,
)
from app.features.course.grader.drawing import Drawing, draw_clouds
from app.features.course.grader.forms import (
    SURELY_DEGREES,
    array_of,
    generator_signs,
    heading_signs,
    headings_apart,
    pose_features,
)
from app.features.course.grader.words import Words
from robot.geometry import Array, wrap_angle

COUNT = 5000
LIKELY = 6.0
"""Standard errors that no even start differs by."""
NEAR_M, NEAR_RAD = 0.1, 0.5
"""Particles this near to the heaviest belong to its place."""
CORNERS = 4
"""Columns, rows and headings into which the field is divided to look for empty places."""
X_WITH_Y, ONE_LINE = 7, 0.99
"""The feature that relates x and y, and where it says that one follows from the other."""
WEIGHTS = np.array([0.4, 0.3, 0.3])
CLOUDS: tuple[tuple[str, str, Array, Array], ...] = (
    ("one", "One particle.", np.array([[0.0, 0.0, 0.0]]), np.ones(1)),
    ("cloud", "Two particles near each other, one with three times the weight.",
     np.array([[0.0, 0.0, 0.0], [0.04, 0.02, 0.2]]), np.array([0.75, 0.25])),
    ("around", "Two particles that look back, one at 3.1 rad and one at -3.1 rad.",
     np.array([[0.0, 0.0, 3.1], [0.02, 0.0, -3.1]]), np.array([0.5, 0.5])),
    ("around", "Three particles whose headings are about π.",
     np.array([[0.0, 0.0, 3.13], [0.02, 0.0, -3.05], [0.0, 0.01, -3.0]]), WEIGHTS),
    ("around", "Three particles whose headings are about -π.",
     np.array([[0.0, 0.0, -3.13], [0.02, 0.0, 3.05], [0.0, 0.01, 3.0]]), WEIGHTS),
    ("places", "Two places that look alike; the heavier particle is at the first.",
     np.array([[0.0, 0.0, 0.0], [0.03, 0.0, 0.1], [1.0, 0.7, 3.0], [1.02, 0.7, -3.1]]),
     np.array([0.3, 0.22, 0.25, 0.23])),
    ("places", "One heavy particle alone; two lighter ones together elsewhere.",
     np.array([[0.0, 0.0, 0.0], [1.0, 0.7, 3.0], [1.02, 0.7, -3.1]]), np.array([0.4, 0.32, 0.28])),
    ("places", "One place, but one particle there looks elsewhere.",
     np.array([[0.0, 0.0, 0.0], [0.03, 0.0, 0.1], [0.01, 0.0, 1.6]]), np.array([0.4, 0.3, 0.3])),
    ("edge", "One particle is 80 mm away, another 120 mm.",
     np.array([[0.0, 0.0, 0.0], [0.08, 0.0, 0.0], [0.0, 0.12, 0.0]]), np.array([0.4, 0.3, 0.3])),
    ("edge", "One particle is 120 mm away, another 80 mm.",
     np.array([[0.0, 0.0, 0.0], [0.12, 0.0, 0.0], [0.0, 0.08, 0.0]]), np.array([0.4, 0.3, 0.3])),
    ("edge", "One particle is 80 mm away along x and along y.",
     np.array([[0.0, 0.0, 0.0], [0.08, 0.08, 0.0], [0.02, 0.0, 0.1]]), np.array([0.4, 0.3, 0.3])),
    ("edge", "One particle is turned by 0.4 rad, another by -0.6 rad.",
     np.array([[0.0, 0.0, 0.0], [0.0, 0.0, 0.4], [0.0, 0.0, -0.6]]), np.array([0.4, 0.3, 0.3])),
    ("edge", "One particle is turned by -0.4 rad, another by 0.6 rad.",
     np.array([[0.0, 0.0, 0.0], [0.0, 0.0, -0.4], [0.0, 0.0, 0.6]]), np.array([0.4, 0.3, 0.3])),
)  # fmt: skip
AXES = ("x", "y", "heading")
SIDES = (
    *("width-twice", "height-twice", "left-twice", "bottom-twice", "left-lowest"),
    *("bottom-leftmost", "right-highest", "top-rightmost", "x-range-twice", "y-range-twice"),
)
"""Sides of the field that are taken for each other, as in a line that was copied."""
ELSEWHERE = 0.02
"""Particles that lie evenly, but begin or end so much beside the field's side, lie on another field
[shares of its size]."""
STARTS = frozenset(
    {
        *SIDES,
        *("front-half", "xy-exchanged", "size-alone", "one-number"),
        *("from-zero", "size-from-zero", "right-as-width", "pairs", "diagonal"),
        *("half-circle", "heading-small", "heading-zero", "heading-unsigned"),
    }
)


def cases(seed: int) -> list[Case]:
    """Where particles start, on three fields; then estimates, from one particle on."""
    rng = np.random.default_rng(seed)
    made = [_start(extent, seed + n) for n, extent in enumerate(_extents(rng))]
    words = Words("Twice with the same generator's seed, then with another.")
    arguments = (np.array([0.0, 0.0, 1.0, 1.0]), 20)
    made.append(Case("init", arguments, words, "seeds", np.inf, (seed, seed, seed + 1)))
    made += [_estimate(*given, rng) for given in CLOUDS]
    made += [_estimate(*given, rng) for given in CLOUDS]
    return made


def _extents(rng: np.random.Generator) -> list[Array]:
    drawn = np.concatenate([rng.uniform(-2, 0.5, 2), rng.uniform(1, 3, 2)])
    # Whoever takes the sides in another order gets a field of the first, too, and no error.
    return [np.array([0.0, 0.5, 1.0, 2.0]), np.array([0.5, -1.0, 1.5, 0.2]), drawn]


def _start(extent: Array, seed: int) -> Case:
    names = ("left", "bottom", "right", "top")
    values = {name: f"{value:.2f}" for name, value in zip(names, extent, strict=True)}
    text = "{count} particles on a field from x {left} to {right} m, y {bottom} to {top} m."
    words = Words(text, {"count": COUNT, **values})
    error = 1.4 * np.array([0.29] * 3 + [0.13] * 3 + [1.0] * 5)
    tolerance = np.concatenate([LIKELY / math.sqrt(COUNT) * error, [0.3]])
    return Case("init", (extent, COUNT), words, "start", tolerance, (seed,))


def _estimate(kind: str, text: str, poses: Array, weights: Array, rng: np.random.Generator) -> Case:
    """Make a case somewhere on the field; the headings stay, where they matter."""
    shift = np.round(rng.uniform(-1, 1, 2), 2)
    turn = 0.0 if kind == "around" else round(float(rng.uniform(-3, 3)), 2)
    placed = np.column_stack([poses[:, :2] + shift, wrap_angle(poses[:, 2] + turn)])
    order = rng.permutation(len(poses))
    words = Words("{text} {poses}", {"text": Words(text), "poses": _in_words(placed[order])})
    return Case("estimate", (placed[order], weights[order]), words, kind, 4e-3)


def _in_words(poses: Array) -> str:
    return "; ".join(f"({x:.2f}, {y:.2f}, {theta:.2f})" for x, y, theta in poses)


def features(outcome: Outcome) -> Array:
    """Of a start, how evenly it lies; of an estimate, the pose."""
    case = outcome.case
    if case.function == "estimate":
        return pose_features(array_of(outcome.result, (3,)))
    poses = array_of(outcome.result, (int(case.arguments[1]), 3))
    if case.kind == "seeds":
        return np.zeros(1)
    return _evenness(poses, case.arguments[0])


def _evenness(poses: Array, extent: Array) -> Array:
    """Return means, deviations and relations of shares of the field, and the emptiest part."""
    low, high = np.array([*extent[:2], -math.pi]), np.array([*extent[2:], math.pi])
    shares = (poses - low) / (high - low)
    scaled = (shares - shares.mean(axis=0)) / np.maximum(shares.std(axis=0), 1e-9)
    related = (scaled * np.roll(scaled, 1, axis=1)).mean(axis=0)
    serial = (scaled[1:, :2] * scaled[:-1, :2]).mean(axis=0)
    parts = np.clip((shares * CORNERS).astype(int), 0, CORNERS - 1)
    counts = np.bincount(parts @ [CORNERS**2, CORNERS, 1], minlength=CORNERS**3)
    emptiest = counts.min() * CORNERS**3 / len(poses)
    return np.concatenate([shares.mean(axis=0), shares.std(axis=0), related, serial, [emptiest]])


def expected(case: Case, mistakes: frozenset[str]) -> Array:
    """What functions with mistakes give."""
    if case.function == "estimate":
        return pose_features(_mean(case.arguments[0], case.arguments[1], mistakes))
    if case.kind == "seeds":
        return np.zeros(1)
    even = [0.5] * 3 + [12**-0.5] * 3 + [0.0] * 5 + [0.65]
    drawn = _spread(case.arguments[0], mistakes)
    return np.array(even) if drawn is None else _evenness(drawn, case.arguments[0])


def _spread(extent: Array, mistakes: frozenset[str]) -> Array | None:
    """Return particles that lie as a mistake puts them; None without one."""
    left, bottom, right, top = extent
    rng = np.random.default_rng(1)
    width, height = right - left, top - bottom
    corners = {
        "from-zero": ((0.0, 0.0), (right, top)),
        "size-from-zero": ((0.0, 0.0), (width, height)),
        "size-alone": ((0.0, 0.0), (width, height)),
        "right-as-width": ((left, bottom), (left + right, bottom + top)),
        "xy-exchanged": ((bottom, left), (top, right)),
        "pairs": ((left, right), (bottom, top)),
        "width-twice": ((left, bottom), (right, bottom + width)),
        "height-twice": ((left, bottom), (left + height, top)),
        "left-twice": ((left, left), (right, left + height)),
        "bottom-twice": ((bottom, bottom), (bottom + width, top)),
        "left-lowest": ((left, left), (right, top)),
        "bottom-leftmost": ((bottom, bottom), (right, top)),
        "right-highest": ((left, bottom), (right, right)),
        "top-rightmost": ((left, bottom), (top, top)),
        "x-range-twice": ((left, left), (right, right)),
        "y-range-twice": ((bottom, bottom), (top, top)),
    }
    headings = {
        "half-circle": (0.0, math.pi),
        "heading-small": (-1.0, 1.0),
        "heading-zero": (0.0, 0.0),
        "heading-unsigned": (0.0, 2 * math.pi),
        "front-half": (-math.pi / 2, math.pi / 2),
        "size-alone": (0.0, 2 * math.pi),
    }
    low_xy, high_xy = by_mistake(mistakes, corners, ((left, bottom), (right, top)))
    low_theta, high_theta = by_mistake(mistakes, headings, (-math.pi, math.pi))
    low, high = [*low_xy, low_theta], [*high_xy, high_theta]
    shares = rng.random((COUNT, 3))
    if "diagonal" in mistakes:
        shares[:, 1] = shares[:, 0]
    if "one-number" in mistakes:
        shares[:] = shares[:, :1]
    return low + shares * np.subtract(high, low) if mistakes & STARTS else None


def _mean(poses: Array, weights: Array, mistakes: frozenset[str]) -> Array:
    best = poses[_heaviest(poses, weights, mistakes)]
    offsets = poses - best
    if "not-wrapped" not in mistakes:
        offsets[:, 2] = wrap_angle(offsets[:, 2])
    away = np.hypot(offsets[:, 0], offsets[:, 1])
    ways = {
        "x-alone": np.abs(offsets[:, 0]),
        "box": np.abs(offsets[:, :2]).max(axis=1),
        "squared-away": away**2,
        "wide": 0.1 * away,
    }
    away = next((each for name, each in ways.items() if name in mistakes), away)
    near = away < NEAR_M
    if "place-apart" in mistakes:
        near[:] = True
    if "headings-apart" not in mistakes:
        turns = offsets[:, 2] if "one-way" in mistakes else np.abs(offsets[:, 2])
        near &= turns < NEAR_RAD
    if "all" in mistakes:
        near[:] = True
    if "best" in mistakes:
        return np.array(best)
    if "median" in mistakes:
        turned = best[2] + float(np.median(wrap_angle(poses[near, 2] - best[2])))
        return np.array([*np.median(poses[near, :2], axis=0), turned])
    share = _parts(weights, near, mistakes)
    place = share @ poses[:, :2]
    if "plain-mean" in mistakes:
        mean: Array = share @ poses
        return mean
    toward = share @ np.exp(1j * poses[:, 2])
    if "swapped" in mistakes:
        toward = toward.imag + 1j * toward.real
    headings = {
        "heading-best": best[2],
        "heading-even": float(np.angle(near @ np.exp(1j * poses[:, 2]))),
        "half-arctan": math.atan(toward.imag / toward.real) if toward.real else 0.0,
        "heading-largest": poses[near, 2].max(),
        "turn-alone": float(share @ offsets[:, 2]),
        "heading-all": float(np.angle(weights @ np.exp(1j * poses[:, 2]))),
    }
    place = best[:2] if "place-best" in mistakes else place
    place = near @ poses[:, :2] / near.sum() if "place-even" in mistakes else place
    place = weights @ poses[:, :2] / weights.sum() if "place-all" in mistakes else place
    place = place[::-1] if "xy" in mistakes else place
    return np.array([*place, by_mistake(mistakes, headings, math.atan2(toward.imag, toward.real))])


def _heaviest(poses: Array, weights: Array, mistakes: frozenset[str]) -> int:
    """Return the index of the particle that makes the place."""
    others = {
        "lightest": int(weights.argmin()),
        "crowd": int(_together(poses).sum(axis=1).argmax()),
        "heaviest-crowd": int((_together(poses) @ weights).argmax()),
        "first": 0,
        "last": len(poses) - 1,
        "largest-row": max(range(len(poses)), key=lambda place: tuple(poses[place])),
        "smallest-row": min(range(len(poses)), key=lambda place: tuple(poses[place])),
        **{f"largest-{name}": int(poses[:, axis].argmax()) for axis, name in enumerate(AXES)},
        **{f"smallest-{name}": int(poses[:, axis].argmin()) for axis, name in enumerate(AXES)},
    }
    return by_mistake(mistakes, others, int(weights.argmax()))


def _together(poses: Array) -> NDArray[np.bool_]:
    """Return of each two particles whether they are at one place (n, n)."""
    apart = poses[:, None] - poses
    away = np.hypot(apart[..., 0], apart[..., 1])
    together: NDArray[np.bool_] = (away < NEAR_M) & (np.abs(wrap_angle(apart[..., 2])) < NEAR_RAD)
    return together


def _parts(weights: Array, near: Array, mistakes: frozenset[str]) -> Array:
    """Return how much each particle counts in the mean."""
    share = near if "unweighted" in mistakes else weights * near
    share = share**2 if "squares" in mistakes else share
    sums = {"by-count": near.sum(), "of-all": weights.sum(), "not-shared": 1.0}
    parts: Array = share / by_mistake(mistakes, sums, share.sum())
    return parts


def signs(outcomes: Sequence[Outcome]) -> Iterator[Sign]:
    """What shows by itself: headings out of range, a mean of headings, the generator."""
    yield from _uneven(outcomes)
    yield from heading_signs(outcomes, [_given_poses(item) for item in outcomes])
    yield from _others(outcomes)
    near = all(_toward(item) > 0.5 for item in outcomes if item.case.kind in ("one", "cloud"))
    for outcome in outcomes:
        if outcome.case.kind == "seeds":
            starts = [np.asarray(answer.result) for answer in outcome.answers]
            chance = list(generator_signs(outcome, starts))
            yield from chance
            if chance and not _field_missed(outcomes):
                return  # how evenly they lie follows from that
    for outcome in outcomes:
        if near and outcome.case.kind == "around" and _toward(outcome) < 0.5:
            yield Sign("E1", outcome)
    yield from _areas(outcomes)


def _field_missed(outcomes: Sequence[Outcome]) -> bool:
    """Return whether an estimate is wrong, or a start beyond what is counted off evenly."""
    for outcome in outcomes:
        apart = np.abs(features(outcome) - expected(outcome.case, frozenset()))
        far = outcome.case.function == "estimate" or apart[:6].max() > ELSEWHERE
        if far and (apart > outcome.case.tolerance).any():
            return True
    return False


def _given_poses(outcome: Outcome) -> Array:
    if outcome.case.function == "estimate":
        return array_of(outcome.result, (3,))[None]
    return np.asarray(outcome.result)


def _uneven(outcomes: Sequence[Outcome]) -> Iterator[Sign]:
    """Name starts that fill the field, but not evenly; and starts in one place."""
    for outcome in outcomes:
        if outcome.case.kind != "start":
            continue
        poses = np.asarray(outcome.result)
        if np.abs(poses[:, 2]).max() > SURELY_DEGREES:
            return  # where they lie follows from that
        if np.ptp(poses, axis=0).max() == 0:
            yield Sign("all-alike", outcome)
            return
        values, due = features(outcome), expected(outcome.case, frozenset())
        middle = np.abs(values[:3] - 0.5).max() < 0.05
        if middle and np.abs(values[3:6] - due[3:6]).max() > 0.02:
            wide = np.ptp(poses[:, 2]) > 1.6 * math.pi
            uneven = "field-size" if _on_another_field(outcome) else "not-even"
            yield Sign(uneven if wide else "half-circle", outcome)
            return


def _on_another_field(outcome: Outcome) -> bool:
    """Return whether particles lie evenly from side to side, but of a field with other sides."""
    left, bottom, right, top = outcome.case.arguments[0]
    places = np.asarray(outcome.result)[:, :2]
    shares = (places - [left, bottom]) / [right - left, top - bottom]
    low, high = shares.min(axis=0), shares.max(axis=0)
    even = np.abs(shares.std(axis=0) / np.maximum(high - low, 1e-9) - 12**-0.5) < ELSEWHERE
    other = np.maximum(np.abs(low), np.abs(high - 1)) > ELSEWHERE
    return bool(even.all() and other.any())


def _others(outcomes: Sequence[Outcome]) -> Iterator[Sign]:
    """Name estimates that are means of other particles than those of the place."""
    sizes = []
    for outcome in outcomes:
        if outcome.case.function == "estimate" and outcome.case.kind != "one":
            poses, weights = outcome.case.arguments
            chosen = _subset(poses, weights, features(outcome), outcome.case.tolerance)
            if chosen is None:
                return
            due = _subset(poses, weights, expected(outcome.case, frozenset()), 1e-9)
            sizes.append((outcome, chosen - (due or 0)))
    wrong = [(outcome, more) for outcome, more in sizes if more]
    if wrong:
        yield Sign("middle" if wrong[0][1] > 0 else "too-few", wrong[0][0], weak=True)


def _subset(poses: Array, weights: Array, given: Array, tolerance: float | Array) -> int | None:
    """Return of how many particles a pose is the weighted mean; None if of none."""
    for count in range(1, len(poses) + 1):
        for chosen in combinations(range(len(poses)), count):
            share = weights[list(chosen)] / weights[list(chosen)].sum()
            toward = share @ np.exp(1j * poses[list(chosen), 2])
            mean = np.array([*(share @ poses[list(chosen), :2]), toward.real, toward.imag])
            mean[2:] /= max(abs(toward), 1e-9)
            if np.abs(mean - given).max() < tolerance:
                return count
    return None


def _toward(outcome: Outcome) -> float:
    """Return the cosine of how far a heading is off."""
    given, due = features(outcome), expected(outcome.case, frozenset())
    return float(given[2] * due[2] + given[3] * due[3])


def _areas(outcomes: Sequence[Outcome]) -> Iterator[Sign]:
    """Say which part is wrong, where nothing more is known."""
    for outcome in outcomes:
        due = expected(outcome.case, frozenset())
        right = np.abs(features(outcome) - due) <= outcome.case.tolerance
        if not right.all():
            if outcome.case.function == "init":
                together = abs(features(outcome)[X_WITH_Y]) > ONE_LINE
                uneven = "field-size" if _on_another_field(outcome) else "not-even"
                yield Sign("diagonal" if together else uneven, outcome, weak=True)
            else:
                area = "place" if right[2:].all() else "estimate"
                yield Sign("heading" if right[:2].all() else area, outcome, weak=True)
            return


def show(case: Case, values: Array) -> str:
    """Return an estimate, or where particles lie, in words."""
    if case.function == "estimate":
        heading = math.atan2(values[3], values[2])
        return f"x {values[0]:.3f} m, y {values[1]:.3f} m, {heading:.2f} rad"
    left, bottom, right, top = case.arguments[0]
    x, y = left + values[0] * (right - left), bottom + values[1] * (top - bottom)
    heading = (values[2] - 0.5) * 2 * math.pi
    spread = [values[3] * (right - left), values[4] * (top - bottom), values[5] * 2 * math.pi]
    return (
        f"x {x:.2f} ± {spread[0]:.2f} m, y {y:.2f} ± {spread[1]:.2f} m, "
        f"{heading:.2f} ± {spread[2]:.2f} rad"
    )


def picture(outcome: Outcome, due: Array, given: Array) -> str:
    """Draw the particles, and of an estimate where it is due and given."""
    if outcome.case.function == "init":
        rng = np.random.default_rng(0)
        left, bottom, right, top = outcome.case.arguments[0]
        even = rng.uniform([left, bottom], [right, top], (150, 2))
        return draw_clouds({"due": even, "given": np.asarray(outcome.result)[:150]})
    poses, _ = outcome.case.arguments
    drawing = Drawing(np.concatenate([poses[:, :2], due[None, :2], given[None, :2]]))
    for pose in headings_apart(poses):
        drawing.arrow(pose, "start")
    drawing.arrow(due, "due", "due")
    drawing.arrow(given, "given", "your code")
    return str(drawing)


CHECKS = Checks(
    functions=("init", "estimate"),
    cases=cases,
    features=features,
    expected=expected,
    hypotheses=(
        Hypothesis("plain-mean", "E1", kind="around"),
        Hypothesis("not-wrapped", "E2", kind="around"),
        Hypothesis("all", "middle", kind="places"),
        Hypothesis("headings-apart", "middle", kind="places"),
        Hypothesis("one-way", "middle"),
        Hypothesis("best", "best-only", broad=True),
        Hypothesis("lightest", "heaviest"),
        *(Hypothesis(name, "heaviest", kind="places") for name in ("crowd", "heaviest-crowd")),
        Hypothesis("median", "weights-ignored"),
        Hypothesis("first", "heaviest"),
        Hypothesis("last", "heaviest"),
        *(
            Hypothesis(f"{end}-{name}", "heaviest")
            for end in ("largest", "smallest")
            for name in (*AXES, "row")
        ),
        Hypothesis("not-shared", "shares"),
        Hypothesis("swapped", "arctan"),
        Hypothesis("right-as-width", "field-size", STARTS),
        Hypothesis("pairs", "field-size", STARTS),
        *(Hypothesis(name, "field-size", STARTS, broad=True) for name in SIDES),
        Hypothesis("diagonal", "diagonal", STARTS),
        Hypothesis("unweighted", "weights-ignored"),
        Hypothesis("from-zero", "S5", STARTS),
        Hypothesis("size-from-zero", "S5", STARTS),
        Hypothesis("half-circle", "half-circle", STARTS),
        Hypothesis("heading-small", "half-circle", STARTS),
        Hypothesis("heading-zero", "half-circle", STARTS),
        Hypothesis("heading-unsigned", "E2", STARTS),
        Hypothesis("front-half", "half-circle", STARTS),
        Hypothesis("xy-exchanged", "xy", STARTS),
        Hypothesis("size-alone", "S5", STARTS),
        Hypothesis("one-number", "diagonal", STARTS),
        Hypothesis("place-apart", "middle", kind="places"),
        *(Hypothesis(name, "middle") for name in ("x-alone", "box", "squared-away", "wide")),
        Hypothesis("squares", "weights-changed"),
        Hypothesis("by-count", "shares"),
        Hypothesis("of-all", "shares"),
        Hypothesis("xy", "xy"),
        *(Hypothesis(name, "heading-of-one") for name in ("heading-best", "heading-largest")),
        Hypothesis("turn-alone", "turn-alone"),
        Hypothesis("place-best", "place-of-one"),
        Hypothesis("heading-all", "part-of-all", kind="places"),
        Hypothesis("place-all", "part-of-all", kind="places"),
        Hypothesis("heading-even", "weights-ignored"),
        Hypothesis("place-even", "weights-ignored"),
        Hypothesis("half-arctan", "half-arctan"),
    ),
    signs=signs,
    show=show,
    picture=picture,
)
