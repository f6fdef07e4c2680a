"""Lesson 3: ``log_weight(poses, bearings, ranges, field, sigma)`` says how well a scan fits."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from types import SimpleNamespace

import numpy as np

from app.features.course.grader.case import REFERENCE, Case, Checks, Hypothesis, Outcome, Sign
from app.features.course.grader.drawing import draw_scan
from app.features.course.grader.forms import array_of, headings_apart
from app.features.course.grader.mistaken_weights import (
    HIT,
    INVERSES,
    JOINED,
    MERGED,
    NARROW,
    OFF,
    RANDOM,
    SIGMA,
    WIDE,
    WIDTHS,
    distances,
    ends,
    weights_of,
    within,
)
from app.features.course.grader.tape_field import CELL, ORIGIN, TAPE, tape_field
from app.features.course.grader.words import Words
from robot.geometry import Array

TOLERANCE = 1e-6
SQUARE = np.array([0.7, 0.8, 0.0])
"""Middle of the dashboard's square, whose lower side is where the lesson's is."""
QUARTERS = np.array([0.0, 1.0, 2.0, -1.0]) * math.pi / 2
EACH_OR_ONE = ("", "-x", "-y")
"""A mistake of both coordinates, or of one alone."""
STARTS = frozenset(
    f"origin-{mistake}{axis}"
    for mistake in ("ignored", "added", "swapped", "undivided")
    for axis in EACH_OR_ONE
)
PRODUCTS = ("product", "late-logarithm")
JOINTS = frozenset([*JOINED, *INVERSES])
NEGATIVE_M = 1.4
"""How far a field is put to the left and downwards, so that all its tape is below 0 [m]."""
CUT_ROW, CUT_TOP, CUT_COLUMN = 35, 72, 85
"""Where a field is cut so that its tape lies at its border, at the bottom and at the right; and at
the top a little below it, for those who count on from there."""


def cases(seed: int) -> list[Case]:
    """One ray, several headings, rays without a return, a few rays, and very many.

    All rays end in the middle of a cell, so that it does not matter how one looks between cells.
    """
    rng = np.random.default_rng(seed)
    field = tape_field()
    made = [_one_ray(field, distance) for distance in (0.02, 0.04, 0.08, 0.12)]
    made.append(_headings(field))
    made += [_any_pose(field, rng, rays, kind) for rays, kind in ((3, "few"), (20, "few"))]
    made.append(_any_pose(field, rng, 12, "no-return"))
    made += [_beyond(field, *ray) for ray in ((-math.pi / 2, 0.66), (0.0, 0.46))]
    made.append(_negative(field))
    made.append(_lattice(field, rng, 24, "particles"))
    made.append(_lattice(field, rng, 600, "many"))
    return made


def _case(poses: Array, scan: tuple[Array, Array], field: SimpleNamespace, kind: str) -> Case:
    text = {
        "one": "One guess, one ray, whose end is {distance} mm away from the tape.",
        "headings": "Four guesses in one place that look north, west, south and east.",
        "few": "One guess and {rays} rays.",
        "no-return": "One guess and {rays} rays; some of them saw no tape and are infinite.",
        "beyond": "One guess, one ray, whose end is beyond the field's border, near tape.",
        "negative": "One guess, one ray; the field lies where x and y are negative.",
        "particles": "{count} guesses and {rays} rays.",
        "many": "{count} guesses and {rays} rays, as a good camera has them.",
    }[kind]
    seen = np.isfinite(scan[1])
    away = distances(*ends(poses, scan[0][seen], scan[1][seen], REFERENCE), field, REFERENCE)
    values = {"count": len(poses), "rays": len(scan[0]), "distance": f"{1000 * away[0, 0]:.0f}"}
    arguments = (poses, *scan, field, SIGMA)
    error = "beyond" if kind == "beyond" else ""
    return Case("log_weight", arguments, Words(text, values), kind, TOLERANCE, on_error=error)


def _beyond(field: SimpleNamespace, heading: float, far: float) -> Case:
    """Let a ray end beyond the border of a field that ends at its tape."""
    cut = SimpleNamespace(
        distances=field.distances[CUT_ROW:CUT_TOP, :CUT_COLUMN].copy(),
        origin=field.origin + CELL * np.array([0, CUT_ROW]),
        cell=field.cell,
    )
    pose = np.array([[0.71, 0.81, heading]])
    return _case(pose, (np.zeros(1), np.array([far])), cut, "beyond")


def _negative(field: SimpleNamespace) -> Case:
    """Put a field where x and y are negative: whoever keeps ends above 0 has none of it."""
    shifted = SimpleNamespace(
        distances=field.distances, origin=field.origin - NEGATIVE_M, cell=field.cell
    )
    pose = np.array([[0.71 - NEGATIVE_M, 0.93 - NEGATIVE_M, -math.pi / 2]])
    return _case(pose, (np.zeros(1), np.array([0.58])), shifted, "negative")


def _one_ray(field: SimpleNamespace, distance: float) -> Case:
    end = np.array([0.71, 0.31 + distance])
    pose, bearing, far = np.array([[0.71, 0.93, -math.pi / 2]]), 0.0, 0.62 - distance
    assert abs(pose[0, 1] - far - end[1]) < 1e-9
    return _case(pose, (np.array([bearing]), np.array([far])), field, "one")


def _headings(field: SimpleNamespace) -> Case:
    poses = np.column_stack([np.full(4, 0.77), np.full(4, 0.61), QUARTERS[[1, 2, 3, 0]]])
    bearings, ranges = QUARTERS[[0, 1, 3]], np.array([0.3, 0.2, 0.36])
    return _case(poses, (bearings, ranges), field, "headings")


def _any_pose(field: SimpleNamespace, rng: np.random.Generator, rays: int, kind: str) -> Case:
    """Choose where the rays end first, near the tape, then the scan that a pose has of them."""
    pose = rng.uniform([0.4, 0.4, -3.0], [1.0, 0.8, 3.0])
    ends = ORIGIN + CELL * (rng.integers([36, 26], [96, 76], (rays, 2)) + 0.5)
    x, y = (ends - pose[:2]).T
    bearings: Array = np.arctan2(y, x) - pose[2]
    ranges: Array = np.hypot(x, y)
    if kind == "no-return":
        ranges[::3] = np.inf
    return _case(pose[None], (bearings, ranges), field, kind)


def _lattice(field: SimpleNamespace, rng: np.random.Generator, rays: int, kind: str) -> Case:
    places = ORIGIN + CELL * (rng.integers([45, 35], [85, 60], (8, 2)) + 0.5)
    poses = np.column_stack([places, rng.choice(QUARTERS, 8)])
    bearings: Array = rng.choice(QUARTERS, rays)
    ranges: Array = CELL * rng.integers(3, 22, rays).astype(np.float64)
    return _case(poses, (bearings, ranges), field, kind)


def features(outcome: Outcome) -> Array:
    """The log-weights; what is not finite stays, as it tells something."""
    return array_of(outcome.result, (len(outcome.case.arguments[0]),), finite=False)


def expected(case: Case, mistakes: frozenset[str]) -> Array:
    """The log-weights that formulas with mistakes give."""
    poses, bearings, ranges, field, sigma = case.arguments
    poses = np.repeat(poses[:1], len(poses), axis=0) if "first-guess" in mistakes else poses
    poses = np.repeat(poses[-1:], len(poses), axis=0) if "last-guess" in mistakes else poses
    seen = np.isfinite(ranges)
    if "all-missed" in mistakes:
        return np.full(len(poses), math.log(RANDOM) * seen.sum())
    kept_bearings = bearings[seen]
    if "bearings-from-first" in mistakes:
        kept_bearings = bearings[: seen.sum()]
    if "bearings-to-last" in mistakes:
        kept_bearings = bearings[(~seen).sum() :]
    x, y = _looked_up(poses, kept_bearings, ranges[seen], mistakes)
    away = distances(x, y, field, mistakes)
    if "nearest" in mistakes:
        clearance = distances(poses[:, :1], poses[:, 1:2], field, mistakes)
        away = np.abs(clearance - ranges[seen].min())
    with np.errstate(all="ignore"):
        weights = weights_of(away, sigma, mistakes)
    for name, instead in _counted_beyond(field, sigma).items():
        if name in mistakes:
            logs = weights_of(away.reshape(-1, 1), sigma, REFERENCE).reshape(away.shape)
            weights = np.where(within(x, y, field), logs, instead).sum(axis=1)
    # An infinite range that is kept ends at the map's border, or wherever else no tape is.
    kept = (~seen).sum() if "far-away" in mistakes else 0
    weights += math.log(RANDOM) * kept
    if "zero-range" in mistakes and kept_out(seen):
        clearances = distances(poses[:, :1], poses[:, 1:2], field, REFERENCE)
        weights = weights + weights_of(clearances, sigma, REFERENCE) * (~seen).sum()
    if "accumulated" in mistakes:
        weights = np.cumsum(weights)
    if "stops-early" in mistakes and kept_out(seen):
        first = int(np.flatnonzero(~seen)[0])
        weights = weights_of(away[:, :first], sigma, mistakes) if first else np.zeros(len(poses))
    return weights


def _looked_up(
    poses: Array, bearings: Array, ranges: Array, mistakes: frozenset[str]
) -> tuple[Array, Array]:
    """Return x and y of the places whose distance is looked up: the rays' ends, or the guesses."""
    if not mistakes & {"ends-at-guess", "guess-alone"}:
        return ends(poses, bearings, ranges, mistakes)
    count = 1 if "guess-alone" in mistakes else len(ranges)
    return np.repeat(poses[:, :1], count, axis=1), np.repeat(poses[:, 1:2], count, axis=1)


def _counted_beyond(field: SimpleNamespace, sigma: float) -> dict[str, float]:
    """Return the log-weights that a ray's end beyond the field gets by mistake."""
    farthest = weights_of(np.array([[field.distances.max()]]), sigma, REFERENCE)
    return {
        "beyond-out": 0.0,
        "beyond-missed": math.log(RANDOM),
        "beyond-farthest": float(farthest[0]),
    }


def kept_out(seen: Array) -> bool:
    """Return whether a scan has rays without a return."""
    return not seen.all()


def _right(outcome: Outcome) -> bool:
    due = expected(outcome.case, REFERENCE)
    return bool(np.allclose(features(outcome), due, rtol=0, atol=TOLERANCE))


def signs(outcomes: Sequence[Outcome]) -> Iterator[Sign]:
    """What shows by itself: equal weights, headings that do not count, underflow, sigma."""
    spread = [item for item in outcomes if item.case.kind in ("headings", "particles", "many")]
    if spread and all(np.ptp(features(item)) == 0 for item in spread):
        # A scan that counts in one case and not in others has another cause.
        one_seen = any(np.ptp(features(item)) or features(item)[0] for item in outcomes)
        yield Sign("S7", spread[0], weak=one_seen)
        return
    wrong = [item for item in outcomes if not _right(item)]
    for kind, cause in (
        *(("no-return", "no-return"), ("beyond", "beyond")),
        ("negative", "negative-lost"),
    ):
        if wrong and all(item.case.kind == kind for item in wrong):
            yield Sign(cause, wrong[0])
            return
    one_right = all(item.case.kind != "one" for item in wrong)
    yield from _shares(outcomes)
    yield from _underflow(outcomes)
    for item in outcomes:
        given = features(item)
        alike = np.isfinite(given).all() and np.ptp(given) < 1e-12
        # Where all rays are far from tape, no heading could make a difference.
        far = math.log(RANDOM) * np.isfinite(item.case.arguments[2]).sum()
        if item.case.kind == "headings" and alike and abs(given[0] - far) > TOLERANCE:
            yield Sign("S6", item, weak=not one_right)
        if item.case.kind == "particles" and _is_inverse(item, given):
            yield Sign("S3", item)
        if item.case.kind == "no-return" and not np.isfinite(given).all():
            yield Sign("no-return", item)
    yield from _narrow(outcomes)
    if wrong:
        area = {"one": "curve", "headings": "ends"}.get(wrong[0].case.kind, "joined")
        yield Sign(area, wrong[0], weak=True)


def _underflow(outcomes: Sequence[Outcome]) -> Iterator[Sign]:
    for item in outcomes:
        given = features(item)
        if item.case.kind == "many" and (np.isneginf(given).any() or (given == 0).any()):
            yield Sign("S1", item, weak=True)


def _shares(outcomes: Sequence[Outcome]) -> Iterator[Sign]:
    """Work out which shares of hits and of others single rays mean, if the curve is right."""
    rays = [item for item in outcomes if item.case.kind == "one"]
    if len(rays) < 4:
        return
    fits = np.exp(-((np.array([_one_distance(item) for item in rays]) / SIGMA) ** 2) / 2)
    with np.errstate(all="ignore"):
        given = np.exp(np.array([features(item)[0] for item in rays]))
    if not np.isfinite(given).all():
        return
    model = np.column_stack([fits, np.ones(len(fits))])
    shares, *_ = np.linalg.lstsq(model, given, rcond=None)
    exact = np.abs(model @ shares - given).max() < 1e-9
    if exact and abs(shares[0]) > 1e-3 and np.abs(shares - [HIT, RANDOM]).max() > 1e-6:
        text = "A ray has the likelihood {hit} times the curve plus {other}; 0.95 and 0.05 are due."
        values = {"hit": f"{shares[0]:.3g}", "other": f"{shares[1]:.3g}"}
        lost = abs(shares[1]) < 1e-9
        yield Sign(
            "outliers" if lost else "hit-share", rays[0], note=Words(text, values), weak=True
        )


def _is_inverse(outcome: Outcome, given: Array) -> bool:
    """Return whether weights, or what they are the logarithm of, fall as one over the distances."""
    poses, bearings, ranges, field, _ = outcome.case.arguments
    away = distances(*ends(poses, bearings, ranges, REFERENCE), field, REFERENCE)
    with np.errstate(all="ignore"):
        for total in (away.sum(axis=1), (away**2).sum(axis=1)):
            for weight in (given, np.exp(given)):
                product = weight * total
                if product.min() > 0 and product.max() < 1.02 * product.min():
                    return True
    return False


def _narrow(outcomes: Sequence[Outcome]) -> Iterator[Sign]:
    """Work out which sigma the weights of single rays mean, where they are not all but zero."""
    rays = [item for item in outcomes if item.case.kind == "one"]
    away = np.array([_one_distance(item) for item in rays])
    given = np.array([features(item)[0] for item in rays])
    with np.errstate(all="ignore"):
        shares = (np.exp(given) - RANDOM) / HIT
        clear = (shares > 1e-6) & (shares < 1)
        widths = away[clear] / np.sqrt(-2 * np.log(shares[clear]))
        width = widths.mean() if clear.any() else SIGMA
        fits = np.abs(shares - np.exp(-((away / width) ** 2) / 2)) < 1e-5
    if clear.any() and width < 0.97 * SIGMA and fits.all():
        yield Sign("S8", rays[0], weak=not all(_as_narrow(item, width) for item in outcomes))


def _as_narrow(outcome: Outcome, width: float) -> bool:
    """Return whether log-weights are those of another sigma [m]."""
    poses, bearings, ranges, field, _ = outcome.case.arguments
    seen = np.isfinite(ranges)
    away = distances(*ends(poses, bearings[seen], ranges[seen], REFERENCE), field, REFERENCE)
    return bool(np.allclose(features(outcome), weights_of(away, width, REFERENCE), atol=1e-3))


def _one_distance(outcome: Outcome) -> float:
    poses, bearings, ranges, field, _ = outcome.case.arguments
    return float(distances(*ends(poses, bearings, ranges, REFERENCE), field, REFERENCE)[0, 0])


def show(_case: Case, values: Array) -> str:
    """Return log-weights in words."""
    return ", ".join(f"{value:.3g}" for value in values[:6]) + (", ..." if len(values) > 6 else "")


def picture(outcome: Outcome, _due: Array, _given: Array) -> str:
    """Draw the tape, the guesses, and where the first one's rays end."""
    _, bearings, ranges, _, _ = outcome.case.arguments
    poses = _where_tape_is_drawn(outcome.case)
    x, y = ends(poses[:1], bearings, ranges, REFERENCE)
    return draw_scan(headings_apart(poses[:8]), np.stack([x[0], y[0]], axis=1)[:60], TAPE)


def situation(case: Case) -> dict[str, float]:
    """The first guess, as far from the lower side of the dashboard's square as from its tape."""
    x, y, theta = _where_tape_is_drawn(case)[0] - SQUARE
    return {"guess_x": x, "guess_y": y, "guess_theta": theta}


def _where_tape_is_drawn(case: Case) -> Array:
    """Return a case's guesses (n, 3), also of a field that lies elsewhere, as tape is drawn."""
    shift = NEGATIVE_M if case.kind == "negative" else 0.0
    guesses: Array = case.arguments[0] + [shift, shift, 0.0]
    return guesses


def _of_each_or_one(mistake: str, cause: str) -> Iterator[Hypothesis]:
    yield from (Hypothesis(mistake + axis, cause) for axis in EACH_OR_ONE)


CHECKS = Checks(
    functions=("log_weight",),
    cases=cases,
    features=features,
    expected=expected,
    hypotheses=(
        Hypothesis("sign", "S2", frozenset(INVERSES)),
        *(Hypothesis(f"origin-ignored{axis}", "S5", STARTS) for axis in EACH_OR_ONE),
        *(
            Hypothesis(f"origin-{mistake}{axis}", "origin-wrong", STARTS)
            for mistake in ("added", "swapped", "undivided")
            for axis in EACH_OR_ONE
        ),
        # Cells far away and a curve far too narrow give the same: a line that mends it goes first.
        Hypothesis("all-missed", "all-missed", broad=True),
        *(Hypothesis(name, "S8", frozenset(WIDTHS)) for name in NARROW),
        Hypothesis("multiplied", "sigma-multiplied", frozenset(WIDTHS)),
        *(Hypothesis(name, "sigma", frozenset(WIDTHS)) for name in WIDE if name != "multiplied"),
        Hypothesis("no-heading", "S6", kind="headings"),
        Hypothesis("nearest", "S6", kind="headings"),
        Hypothesis("no-heading-x", "S6"),
        Hypothesis("no-heading-y", "S6"),
        *(Hypothesis(name, "S3", JOINTS) for name in INVERSES),
        *(Hypothesis(name, "S1", JOINTS, "many") for name in PRODUCTS),
        Hypothesis("plain", "no-logarithm", JOINTS),
        Hypothesis("unclipped", "beyond", kind="beyond"),
        Hypothesis("beyond-out", "beyond-skipped", kind="beyond"),
        Hypothesis("beyond-missed", "beyond-skipped", kind="beyond"),
        Hypothesis("beyond-farthest", "beyond-skipped", kind="beyond"),
        *(Hypothesis(name, "distances-joined", frozenset(MERGED)) for name in MERGED),
        *(Hypothesis(name, "no-rays") for name in ("ends-at-guess", "guess-alone")),
        *(Hypothesis(f"{name}-as-degrees", "S4") for name in ("heading", "bearings", "angles")),
        *(Hypothesis(name, "outliers") for name in ("no-outliers", "only-hits", "outliers-inside")),
        Hypothesis("normal-density", "density"),
        Hypothesis("rows", "rows"),
        *_of_each_or_one("rounded", "half-cell"),
        *(Hypothesis(name, "mean", JOINTS) for name in ("mean", "cubed")),
        Hypothesis("sum", "sum", JOINTS),
        Hypothesis("plain-sum", "sum", JOINTS),
        Hypothesis("far-away", "no-return", kind="no-return"),
        Hypothesis("no-square", "square"),
        Hypothesis("first-guess", "one-guess", kind="headings"),
        Hypothesis("last-guess", "one-guess", kind="headings"),
        Hypothesis("accumulated", "accumulated", kind="headings"),
        *_of_each_or_one("bearing-subtracted", "bearing-sign"),
        *_of_each_or_one("heading-subtracted", "heading-sign"),
        *_of_each_or_one("place-lost", "place-lost"),
        *_of_each_or_one("no-bearing", "bearings-lost"),
        Hypothesis("sine-first", "sine"),
        Hypothesis("sine-first-y", "same-function"),
        Hypothesis("sine-first-x", "same-function"),
        *_of_each_or_one("place-exchanged", "place-axes"),
        *_of_each_or_one("ray-backwards", "ray-sign"),
        *(Hypothesis(name, "map-turned") for name in ("upside-down", "row-negative", "mirrored")),
        # With another origin it would explain any shift.
        *(Hypothesis(name, "cell-off", frozenset([*OFF, *STARTS])) for name in OFF),
        Hypothesis("nothing-squared", "square"),
        Hypothesis("no-curve", "no-curve"),
        Hypothesis("negative", "log-sign", JOINTS),
        *(
            Hypothesis(name, "shared", JOINTS)
            for name in ("shares", "log-shares", "from-best", "by-best")
        ),
        Hypothesis("largest", "one-ray", JOINTS),
        Hypothesis("smallest", "one-ray", JOINTS),
        Hypothesis("first-ray", "one-ray", JOINTS),
        Hypothesis("last-ray", "one-ray", JOINTS),
        Hypothesis("log-ten", "log-base", JOINTS),
        Hypothesis("log-two", "log-base", JOINTS),
        Hypothesis("averaged", "sum", JOINTS),
        Hypothesis("plain-mean", "sum", JOINTS),
        Hypothesis("zero-range", "no-return", kind="no-return"),
        Hypothesis("bearings-from-first", "bearings-unpaired", kind="no-return"),
        Hypothesis("bearings-to-last", "bearings-unpaired", kind="no-return"),
        Hypothesis("stops-early", "stops-early", kind="no-return"),
    ),
    signs=signs,
    show=show,
    picture=picture,
    situation=situation,
)
