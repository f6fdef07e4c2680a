"""Lesson 4: ``motion(poses, moved, alphas, rng)`` moves the particles, each with its own noise."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from app.features.course.grader.case import REFERENCE, Case, Checks, Hypothesis, Outcome, Sign
from app.features.course.grader.drawing import draw_clouds, draw_poses
from app.features.course.grader.forms import (
    array_of,
    generator_signs,
    heading_signs,
    headings_apart,
)
from app.features.course.grader.mistaken_motion import EXCHANGED, OF_NOISE, ORDERS, SHARED, sampled
from app.features.course.grader.words import Words
from robot.geometry import Array, compose, wrap_angle

COUNT, MANY, FEW = 6000, 20_000, 1000
"""Particles of a cloud whose spread is measured, of the reference's, and of a quick look at it."""
LIKELY = 6.0
"""Standard errors that a correct cloud never differs by, and no seed of the checks comes near."""
ALIKE = 2e-6
"""Deviations [m or rad] that are none."""
ONE_FACTOR = 0.25
"""Logarithms of deviations that differ less from what is due have one factor: each varies by chance
by 0.03, and noise on one part alone changes it by 0.5 and more."""
OPPOSITE = 0.5
"""Directions so near to the opposite one are those of a way whose noise made it negative [rad]."""
NOISELESS = np.zeros(4)
ALPHA3_ALONE = (False, False, True, False)
"""Which alphas are above 0 where ways differ and nothing else does."""
STEPS = (
    ("straight", "A step of 50 mm straight ahead, without noise.", (0.05, 0.0, 0.0)),
    ("spin", "A turn of 30° on the spot, without noise.", (0.0, 0.0, math.radians(30))),
    ("arc", "A step on an arc to the left, without noise.", (0.06, 0.02, math.radians(40))),
    ("back", "A step of 40 mm backwards, without noise.", (-0.04, 0.0, 0.0)),
    ("back", "A step backwards on an arc, without noise.", (-0.05, 0.01, math.radians(-20))),
)
NOISES = (
    ("noise", "Straight ahead, alpha2 alone: driving turns.", (0.1, 0.0, 0.0), (0, 0.3, 0, 0)),
    ("noise", "Straight ahead, alpha3 alone: ways differ.", (0.1, 0.0, 0.0), (0, 0, 0.02, 0)),
    ("noise", "Straight ahead for 1 m, all but alpha1.", (1.0, 0.0, 0.0), (0, 0.02, 0.02, 0.5)),
    ("turn", "On an arc, alpha1 alone: turns differ.", (0.08, 0.03, 0.9), (0.02, 0, 0, 0)),
    ("spin-noise", "A turn on the spot, alpha1 alone.", (0.0, 0.0, 0.6), (0.02, 0, 0, 0)),
    ("turn", "On an arc, alpha4 alone: turning shifts.", (0.08, 0.03, 0.9), (0, 0, 0, 0.0005)),
    ("reverse", "Straight back, alpha1 alone: nothing turns.", (-0.1, 0.0, 0.0), (0.02, 0, 0, 0)),
    ("reverse", "Back on an arc, all four.", (-0.1, 0.01, -0.2), (0.01, 0.2, 0.01, 0.001)),
)
HALF_WAY = ("half-way", "half-way-plain")
ANGLES = frozenset(["new-heading", "old-heading", *HALF_WAY])
PLAIN_AXES = tuple(f"{part}-plain-{axis}" for part in ("direction", "way") for axis in "xy")
SWAPS = tuple(ORDERS)
LOST = tuple(f"alpha{part}-lost" for part in (1, 2, 3, 4))
TURNS = ("first-twice", "second-twice", "turns-exchanged")
TURNS_TOGETHER = (
    *("of-whole-turn", "all-of-whole-turn", "first-of-whole-turn", "second-of-whole-turn"),
    "of-both-turns",
)
PARTS = ("way", "rot1", "rot2")
WAYS_UNSQUARED = ("way-unsquared", "own-way-unsquared", "turned-way-unsquared")
HALF_SQUARED = ("turns-unsquared", "turned-unsquared", *WAYS_UNSQUARED)
SUMS = ("first-alone", "second-alone", "sum-squared", "unsquared", *HALF_SQUARED, *LOST, *TURNS)
SIZES = frozenset(
    [
        "variance",
        "absolute",
        "no-noise",
        "uniform",
        "positive",
        "from-zero",
        *SWAPS,
        *SUMS,
        *EXCHANGED,
        *OF_NOISE,
        *TURNS_TOGETHER,
        "rest-of-noisy",
    ]
)


def cases(seed: int) -> list[Case]:
    """Steps without noise for particles that look everywhere, then clouds, then the generator."""
    rng = np.random.default_rng(seed)
    looking = np.column_stack([np.zeros((4, 2)), np.array([0.0, 1.0, -1.0, 2.0]) * math.pi / 2])
    some = rng.uniform([-1, -1, -math.pi], [1, 1, math.pi], (5, 3))
    made = [_exact(poses, step) for poses in (looking, some) for step in STEPS]
    made.append(_exact(np.array([[0.2, 0.1, 3.1], [0.2, 0.1, -3.0]]), STEPS[1]))
    made.append(_exact(np.array([[0.2, 0.1, -3.1]]), (*STEPS[1][:2], (0.0, 0.0, -0.5))))
    made += [_cloud(noise, seed + 100 * index) for index, noise in enumerate(NOISES)]
    poses, alphas = np.tile(looking, (5, 1)), np.array([0.01, 0.01, 0.01, 0.001])
    words = Words("Twice with the same generator's seed, then with another.")
    arguments = (poses, np.array(STEPS[2][2]), alphas)
    seeds = (seed + 1, seed + 1, seed + 2)
    made.append(Case("motion", arguments, words, "seeds", math.inf, seeds))
    return made


def _exact(poses: Array, step: tuple[str, str, tuple[float, float, float]]) -> Case:
    kind, text, moved = step
    words = Words("{step} {count} particles.", {"step": Words(text), "count": len(poses)})
    return Case("motion", (poses, np.array(moved), NOISELESS), words, kind, 1e-7, (7,))


def _cloud(
    noise: tuple[str, str, tuple[float, float, float], tuple[float, float, float, float]], seed: int
) -> Case:
    kind, text, moved, alphas = noise
    words = Words("{step} {count} particles in one place.", {"step": Words(text), "count": COUNT})
    arguments = (np.zeros((COUNT, 3)), np.array(moved), np.array(alphas, dtype=float))
    errors = LIKELY / math.sqrt(COUNT) * np.array([1] * 3 + [0.72] * 3 + [1] * 4 + [1.8] * 2)
    return Case("motion", arguments, words, kind, errors, (seed,))


def _is_cloud(case: Case) -> bool:
    return case.kind in ("noise", "turn", "reverse", "spin-noise")


def features(outcome: Outcome) -> Array:
    """Poses, their headings as cosine and sine; of a cloud, how it is shifted and spread."""
    case = outcome.case
    poses = array_of(outcome.result, case.arguments[0].shape)
    if not _is_cloud(case):
        return headings_apart(poses)
    return _spread(poses, case)


def _spread(poses: Array, case: Case) -> Array:
    """Return of way, direction and turn: shifts in deviations, their logarithms, correlations:
    of each particle with the next, of the way with direction and turn, and with how much both
    rotations vary.

    The error of each is the same whatever the spread is. A shift that is large is as uncertain as
    the deviation it is told in, so its inverse hyperbolic sine is given: of small ones that is the
    shift itself.
    """
    _, moved, _ = case.arguments
    due = _steps(compose(np.zeros((1, 3)), moved), moved)
    errors = _steps(poses, moved) - due
    errors[:, 1:] = wrap_angle(errors[:, 1:])
    # A short way may come out negative by its noise: one such particle would look the other way.
    middle = np.angle(np.exp(1j * errors[:, 1]).mean())
    middle = abs(middle) if abs(middle) > 0.9 * math.pi else middle
    errors[:, 1] = middle + wrap_angle(errors[:, 1] - middle)
    turned = np.abs(errors[:, 1] - middle) > math.pi - OPPOSITE
    errors[turned, 0] = -errors[turned, 0] - 2 * due[0, 0]
    errors[turned, 1] = middle + wrap_angle(errors[turned, 1] + math.pi - middle)
    deviations = np.maximum(errors.std(axis=0), 1e-6)
    scaled = (errors - errors.mean(axis=0)) / deviations
    # Where there is no spread there is no correlation either.
    related = [float((scaled[:-1, axis] * scaled[1:, axis]).mean()) for axis in (0, 2)]
    shifts = np.arcsinh(errors.mean(axis=0) / deviations)
    related += [float((scaled[:, 0] * scaled[:, axis]).mean()) for axis in (1, 2)]
    related += [float((scaled[:, 0] * square).mean()) for square in _squares(errors)]
    return np.concatenate([shifts, np.log(deviations), related])


def _squares(errors: Array) -> Iterator[Array]:
    """Return the squares of what both rotations are off by, in deviations."""
    for rotation in (errors[:, 1], errors[:, 2] - errors[:, 1]):
        apart = rotation - rotation.mean()
        yield (apart / max(apart.std(), 1e-6)) ** 2


def _steps(poses: Array, moved: Array) -> Array:
    """Return way, its direction and the turn (n, 3) of particles that began at the origin."""
    sign = -1.0 if moved[0] < 0 else 1.0
    x, y, theta = poses.T
    return np.column_stack([sign * np.hypot(x, y), np.arctan2(sign * y, sign * x), theta])


def expected(case: Case, mistakes: frozenset[str]) -> Array:
    """The features that formulas with mistakes give."""
    poses, moved, alphas = case.arguments
    if not _is_cloud(case):
        return headings_apart(sampled(poses, moved, alphas, mistakes, 7))
    return _reference_spread(tuple(moved), tuple(alphas), mistakes, MANY)


def rough(case: Case, mistakes: frozenset[str]) -> tuple[Array, Array]:
    """The features of a small cloud, and how far those of a large one may be from them."""
    if not _is_cloud(case):
        return expected(case, mistakes), np.asarray(case.tolerance)
    _, moved, alphas = case.arguments
    # The tolerance is that of COUNT particles against a reference without an error of its own.
    wider = np.asarray(case.tolerance) * math.sqrt(1 + COUNT / FEW)
    return _reference_spread(tuple(moved), tuple(alphas), mistakes, FEW), wider


@lru_cache(maxsize=8192)
def _reference_spread(
    moved: tuple[float, ...], alphas: tuple[float, ...], mistakes: frozenset[str], count: int
) -> Array:
    case = Case("motion", (np.zeros((count, 3)), np.array(moved), np.array(alphas)), Words(""))
    return _spread(sampled(*_given(case), mistakes, 1), case)


def _given(case: Case) -> tuple[Array, Array, Array]:
    poses, moved, alphas = case.arguments
    return poses, moved, alphas


def signs(outcomes: Sequence[Outcome]) -> Iterator[Sign]:
    """What shows by itself: no spread, a spin that moves, a generator that is not asked."""
    yield from heading_signs(outcomes, [np.asarray(item.result) for item in outcomes])
    clouds = [item for item in outcomes if item.case.kind == "noise"]
    if clouds and all(np.asarray(item.result).std(axis=0).max() < 1e-9 for item in clouds):
        yield Sign("M5", clouds[0])
    yield from _without_noise(outcomes)
    backs = [item for item in outcomes if item.case.kind == "reverse"]
    if backs and all(_wider(item) for item in backs) and not any(_wider(item) for item in clouds):
        yield Sign("M3", backs[0], weak=True)
    straight = all(_right(item) for item in outcomes if item.case.kind == "straight")
    for outcome in outcomes:
        poses = np.asarray(outcome.result)
        if outcome.case.kind == "spin" and straight:
            moved = np.abs(poses[:, :2] - outcome.case.arguments[0][:, :2])
            if moved.max() > 1e-6:
                yield Sign("spin-moves", outcome, weak=True)
        if outcome.case.kind == "straight" and _is_parallel(outcome):
            yield Sign("M1", outcome, weak=True)
        if outcome.case.kind == "seeds":
            drawn = [np.asarray(answer.result) for answer in outcome.answers]
            if np.ptp(drawn[0][::4], axis=0).max() > 0:  # every fourth particle starts alike
                yield from generator_signs(outcome, drawn)
    yield from _areas(outcomes)


def _without_noise(outcomes: Sequence[Outcome]) -> Iterator[Sign]:
    """Name a part of the step that all particles of a cloud have alike: due, or by one draw."""
    clouds = [item for item in outcomes if _is_cloud(item.case)]
    ways = [item for item in clouds if tuple(item.case.arguments[2] > 0) == ALPHA3_ALONE]
    if any(features(item)[4] > math.log(100 * ALIKE) for item in ways):
        yield Sign("noise-on-place", ways[0], weak=True)
        return
    noisy = [_noisy_parts(np.asarray(item.result), item.case) for item in clouds]
    due = [_noisy_parts(sampled(*_given(item.case), REFERENCE, 1), item.case) for item in clouds]
    for part in range(len(PARTS)):
        wanted = [number for number, parts in enumerate(due) if parts[part]]
        if wanted and not any(noisy[number][part] for number in wanted):
            outcome = clouds[wanted[0]]
            given = features(outcome)
            shifts = np.abs(np.sinh(given[:3]) * np.exp(given[3:6]))[given[3:6] < math.log(ALIKE)]
            shifted = shifts.size and shifts.max() > 100 * ALIKE
            yield Sign("M5" if shifted else "noise-lost", outcome, weak=True)
            return


def _noisy_parts(poses: Array, case: Case) -> NDArray[np.bool_]:
    """Return of way, first and second rotation whether they differ from particle to particle."""
    way, toward, turn = _steps(poses, case.arguments[1]).T
    apart = [np.ptp(way), *(np.ptp(wrap_angle(each - each[0])) for each in (toward, turn - toward))]
    return np.array(apart) > 100 * ALIKE


def _areas(outcomes: Sequence[Outcome]) -> Iterator[Sign]:
    """Say whether it is the step or its noise, where nothing more is known."""
    wrong = [item for item in outcomes if item.case.kind != "seeds" and not _right(item)]
    if wrong and _is_scaled(outcomes, wrong):
        yield Sign("noise-scaled", wrong[0], weak=True)
    elif wrong:
        yield Sign("noise-of-step" if _is_cloud(wrong[0].case) else "step", wrong[0], weak=True)


def _is_scaled(outcomes: Sequence[Outcome], wrong: Sequence[Outcome]) -> bool:
    """Return whether nothing but the clouds is wrong, and all deviations are so by one factor."""
    clouds = [item for item in outcomes if _is_cloud(item.case)]
    if not all(_is_cloud(item.case) for item in wrong):
        return False
    factors = []
    for cloud in clouds:
        given, due = features(cloud), expected(cloud.case, REFERENCE)
        spread = due[3:6] > math.log(100 * ALIKE)
        factors += list((given - due)[3:6][spread])
    return bool(np.ptp(factors) < ONE_FACTOR)


def _right(outcome: Outcome) -> bool:
    due = expected(outcome.case, REFERENCE)
    return bool((np.abs(features(outcome) - due) <= outcome.case.tolerance).all())


def _wider(outcome: Outcome) -> bool:
    given, due = features(outcome), expected(outcome.case, REFERENCE)
    return bool((given[3:6] - due[3:6]).max() > 0.5)


def _is_parallel(outcome: Outcome) -> bool:
    """Return whether all particles shift alike, though they look into different directions."""
    shifts = np.asarray(outcome.result)[:, :2] - outcome.case.arguments[0][:, :2]
    return bool(np.ptp(shifts, axis=0).max() < 1e-9 and np.abs(shifts).max() > 1e-6)


def show(case: Case, values: Array) -> str:
    """Return poses, or a cloud's spread, in words."""
    if _is_cloud(case):
        way, toward, turn = 1000 * math.exp(values[3]), *np.degrees(np.exp(values[4:6]))
        return f"way ± {way:.1f} mm, direction ± {toward:.1f}°, heading ± {turn:.1f}°"
    shown = values.reshape(-1, 4)[:4]
    return "; ".join(
        f"x {1000 * x:.0f} mm, y {1000 * y:.0f} mm, {math.degrees(math.atan2(s, c)):.0f}°"
        for x, y, c, s in shown
    )


def picture(outcome: Outcome, due: Array, given: Array) -> str:
    """Draw the clouds, or the first particle that is elsewhere than it should be."""
    case = outcome.case
    if _is_cloud(case):
        small = np.zeros((150, 3))
        cloud = sampled(small, *_given(case)[1:], REFERENCE, 3)
        return draw_clouds({"due": cloud, "given": np.asarray(outcome.result)[:150]})
    rows = due.reshape(-1, 4), given.reshape(-1, 4)
    worst = int(np.abs(rows[0] - rows[1]).max(axis=1).argmax())
    start = headings_apart(case.arguments[0])[worst]
    return draw_poses({"start": start, "due": rows[0][worst], "given": rows[1][worst]})


def situation(case: Case) -> dict[str, float]:
    """The first particle's heading, in the middle of the field, and the cloud there."""
    theta = case.arguments[0][0, 2]
    return {"x": 0, "y": 0, "theta": theta, "guess_x": 0, "guess_y": 0, "guess_theta": theta}


CHECKS = Checks(
    functions=("motion",),
    cases=cases,
    features=features,
    expected=expected,
    rough=rough,
    hypotheses=(
        *(Hypothesis(name, "M1") for name in ("not-turned", "not-turned-x", "not-turned-y")),
        Hypothesis("reverse-turns", "M3", kind="reverse"),
        Hypothesis("no-noise", "M5", SIZES, "noise"),
        Hypothesis("new-heading", "after-turn", ANGLES),
        Hypothesis("old-heading", "before-rotation", ANGLES),
        *(Hypothesis(name, "half-way", ANGLES) for name in HALF_WAY),
        *(Hypothesis(name, "axes-apart", kind="turn") for name in PLAIN_AXES),
        Hypothesis("degrees", "S4"),
        Hypothesis("variance", "variance", SIZES),
        Hypothesis("rooted-twice", "rooted-twice", SIZES),
        Hypothesis("absolute", "variances", SIZES),
        *(Hypothesis(name, "alphas", SIZES) for name in SWAPS),
        *(Hypothesis(name, "alphas", SIZES) for name in EXCHANGED),
        *(Hypothesis(name, "noise-of-noise", SIZES, "noise") for name in OF_NOISE),
        Hypothesis("rest-of-noisy", "noises-cancel", SIZES, "noise"),
        *(Hypothesis(name, "rotations-of-turn", SIZES, "turn") for name in TURNS_TOGETHER),
        *(Hypothesis(name, "variances", SIZES) for name in SUMS),
        Hypothesis("uniform", "noise-form", SIZES),
        Hypothesis("positive", "noise-form", SIZES),
        Hypothesis("from-zero", "noise-form", SIZES),
        *(Hypothesis(name, "same-draw", kind="turn") for name in SHARED),
        Hypothesis("one-rotation", "rotation-lost"),
        Hypothesis("first-rotation-alone", "rotation-lost"),
        Hypothesis("whole-turn", "second-turn"),
        Hypothesis("direction-swapped", "arctan"),
        Hypothesis("sine-first", "sine"),
        Hypothesis("stays", "standing"),
        Hypothesis("place-lost", "start-lost"),
        Hypothesis("one-particle", "one-particle"),
        Hypothesis("spin-noiseless", "spin-noiseless", kind="spin-noise"),
        Hypothesis("deviations-summed", "variances", SIZES),
        Hypothesis("turns-rooted", "variances", SIZES),
        *(Hypothesis(f"variance-{name}", "variance", SIZES) for name in PARTS),
        *(Hypothesis(f"no-noise-{name}", "noise-lost", SIZES) for name in (*PARTS, "rotations")),
        Hypothesis("turn-plain", "noise-lost", ANGLES),
        Hypothesis("direction-plain", "noise-lost", ANGLES),
        Hypothesis("turn-lost", "turn-lost"),
        Hypothesis("turns-added", "second-turn"),
        Hypothesis("back-ahead", "back-ahead"),
        Hypothesis("zero-back", "zero-back", kind="spin-noise"),
        Hypothesis("zero-back-whole", "zero-back", kind="spin-noise"),
        *(
            Hypothesis(name, "way-length")
            for name in ("ahead-alone", "way-summed", "way-sizes", "way-squared")
        ),
        Hypothesis("cosine-twice", "same-function"),
        Hypothesis("sine-twice", "same-function"),
        Hypothesis("ways-apart", "axes-apart", kind="turn"),
        Hypothesis("direction-swapped-back", "arctan"),
        Hypothesis("half-turned", "back-twice", kind="back"),
        Hypothesis("proportional", "variances", SIZES),
    ),
    signs=signs,
    show=show,
    picture=picture,
    situation=situation,
)
