"""Particles that move (Table 5.6 of Probabilistic Robotics), with mistakes that are made."""

from __future__ import annotations

import math
from itertools import permutations

import numpy as np

from app.features.course.grader.case import by_mistake
from robot.geometry import Array, wrap_angle

ORDERS = {
    "alphas-" + "".join(str(part + 1) for part in order): order
    for order in (
        *permutations(range(4)),
        *((part,) * 4 for part in range(4)),
        *(tuple(other if part == place else part for part in range(4))
          for place in range(4) for other in range(4)),
    )
    if order != (0, 1, 2, 3)
}  # fmt: skip
"""Alphas that are taken for each other: all orders, and one that stands for two."""

EXCHANGED = {"alphas-of-way": 0, "alphas-of-rot1": 1, "alphas-of-rot2": 2}
"""Of way, first and second rotation: whose two alphas stand for each other."""

OF_NOISE = {
    "way-of-noisy-turns": (True, True, False, False),
    "way-of-noisy-first": (True, False, False, False),
    "turns-of-noisy-way": (False, False, True, True),
    "second-of-noisy-way": (False, False, False, True),
    "one-after-another": (True, False, False, True),
}
"""Variances of values that have their noise already: of the first and second rotation in the way's,
of the way in the first and second rotation's."""

SHARED = {
    "same-draw": (0, 0, 0), "same-rotations": (0, 1, 1), "same-first": (0, 0, 2),
    "same-second": (0, 1, 0),
}  # fmt: skip
"""Of way, first and second rotation: whose random number each takes, where some are alike."""


def sampled(
    poses: Array, moved: Array, alphas: Array, mistakes: frozenset[str], seed: int
) -> Array:
    """Sample the odometry motion model (Probabilistic Robotics, Table 5.6), with mistakes."""
    dx, dy, turn = moved
    if "stays" in mistakes and dx == 0:
        return poses.copy()
    zero_back = mistakes & {"zero-back", "zero-back-whole"}
    back = (dx <= 0 if zero_back else dx < 0) and "reverse-turns" not in mistakes
    way, rot1 = _first_part(dx, dy, mistakes, back=back)
    rot2 = by_mistake(mistakes, {"whole-turn": turn, "turns-added": turn + rot1}, turn - rot1)
    rot2 = rot2 if "zero-back-whole" in mistakes else wrap_angle(rot2)
    ways = {
        "back-ahead": abs(way),
        "ahead-alone": dx,
        "way-summed": dx + dy,
        "way-sizes": math.copysign(abs(dx) + abs(dy), way),
        "way-squared": math.copysign(way**2, way),
    }
    way = by_mistake(mistakes, ways, way)
    way_hat, rot1_hat, rot2_hat = _noisy((way, rot1, rot2), alphas, len(poses), mistakes, seed)
    if "rest-of-noisy" in mistakes:
        rot2_hat = rot2_hat + rot1 - rot1_hat
    heading = poses[:, 2]
    thetas = {
        "turn-plain": wrap_angle(heading + turn),
        "turn-lost": heading,
        "one-rotation": wrap_angle(heading + rot2_hat),
        "first-rotation-alone": wrap_angle(heading + rot1_hat),
    }
    whole = wrap_angle(heading + rot1_hat + rot2_hat)
    theta = by_mistake(mistakes, thetas, whole)
    angles = {
        "direction-plain": heading + rot1,
        "new-heading": whole,
        "old-heading": heading,
        "half-way": heading + (rot1_hat + rot2_hat) / 2,
        "half-way-plain": heading + turn / 2,
    }
    angle = by_mistake(mistakes, angles, heading + rot1_hat)
    if "degrees" in mistakes:
        angle = np.radians(angle)
    if "not-turned" in mistakes:
        angle = angle - poses[:, 2]
    along = {name: angle - poses[:, 2] for name in ("x", "y") if f"not-turned-{name}" in mistakes}
    along |= {name: heading + rot1 for name in ("x", "y") if f"direction-plain-{name}" in mistakes}
    ways_along = {name: way for name in ("x", "y") if f"way-plain-{name}" in mistakes}
    functions = {
        "sine-first": (np.sin, np.cos),
        "cosine-twice": (np.cos, np.cos),
        "sine-twice": (np.sin, np.sin),
    }
    x_of, y_of = by_mistake(mistakes, functions, (np.cos, np.sin))
    x = ways_along.get("x", way_hat) * x_of(along.get("x", angle))
    y = ways_along.get("y", way_hat) * y_of(along.get("y", angle))
    if "ways-apart" in mistakes:
        other = _noisy((way, rot1, rot2), alphas, len(poses), mistakes, seed + 1)[0]
        y = other * y_of(angle)
    if "one-particle" in mistakes:
        return np.column_stack([poses[0, 0] + x, poses[0, 1] + y, theta])
    if "place-lost" in mistakes:
        return np.column_stack([x, y, theta])
    return np.column_stack([poses[:, 0] + x, poses[:, 1] + y, theta])


def _first_part(
    dx: float, dy: float, mistakes: frozenset[str], *, back: bool
) -> tuple[float, float]:
    """Return the way and the rotation towards the step's end."""
    way, rot1 = math.hypot(dx, dy), math.atan2(dy, dx)
    if "direction-swapped" in mistakes:
        rot1 = math.atan2(dx, dy)
    if back and "direction-swapped-back" in mistakes:
        return -way, math.atan2(-dx, -dy)
    if back and "half-turned" in mistakes:
        return -way, math.atan2(dy, dx)
    return (-way, math.atan2(-dy, -dx)) if back else (way, rot1)


def _noisy(
    step: tuple[float, float, float],
    alphas: Array,
    count: int,
    mistakes: frozenset[str],
    seed: int,
) -> tuple[Array, Array, Array]:
    deviations = _deviations(step, _alphas(alphas, mistakes), mistakes)
    for part, name in enumerate(("way", "rot1", "rot2")):
        if f"no-noise-{name}" in mistakes:
            deviations[part] = 0.0
    if "no-noise-rotations" in mistakes:
        deviations[1:] = 0.0
    if "spin-noiseless" in mistakes and step[0] == 0:
        deviations[:] = 0.0
    if "proportional" in mistakes:
        deviations = deviations * np.array(step)
    rng = np.random.default_rng(seed)
    noise = rng.standard_normal((3, count))
    if "uniform" in mistakes:
        noise = rng.uniform(-1, 1, (3, count))
    if "from-zero" in mistakes:
        noise = rng.random((3, count))
    noise = noise[list(by_mistake(mistakes, SHARED, (0, 1, 2)))]
    if "positive" in mistakes:
        noise = np.abs(noise)
    made = np.array(step)[:, None] + deviations[:, None] * noise
    noisy = by_mistake(mistakes, OF_NOISE, None)
    if noisy is not None:
        made = _of_noise(np.array(step), made, noise, alphas, noisy)
    return made[0], made[1], made[2]


def _of_noise(
    step: Array, made: Array, noise: Array, alphas: Array, noisy: tuple[bool, bool, bool, bool]
) -> Array:
    """Return way and rotations whose variances are made of some that have noise already."""
    a1, a2, a3, a4 = alphas
    way, rot1, rot2 = (np.full(made.shape[1], value) for value in step)
    if noisy[0]:
        second = made[2] if noisy[1] else rot2
        spread = np.sqrt(a3 * way**2 + a4 * (made[1] ** 2 + second**2))
        made[0] = way + spread * noise[0]
    for part, plain in ((1, rot1), (2, rot2)):
        if noisy[part + 1]:
            made[part] = plain + np.sqrt(a1 * plain**2 + a2 * made[0] ** 2) * noise[part]
    return made


def _deviations(step: tuple[float, float, float], alphas: Array, mistakes: frozenset[str]) -> Array:
    """Return standard deviations of way and both rotations."""
    way, rot1, rot2 = step
    turned = {
        "first-alone": rot1**2,
        "second-alone": rot2**2,
        "sum-squared": (rot1 + rot2) ** 2,
        "all-of-whole-turn": (rot1 + rot2) ** 2,
    }
    squares = by_mistake(mistakes, turned, rot1**2 + rot2**2)
    whole = (rot1 + rot2) ** 2
    taken = {
        "of-whole-turn": (whole, whole),
        "all-of-whole-turn": (whole, whole),
        "first-of-whole-turn": (whole, rot2**2),
        "second-of-whole-turn": (rot1**2, whole),
        "of-both-turns": (squares, squares),
        "first-twice": (rot1**2, rot1**2),
        "second-twice": (rot2**2, rot2**2),
        "turns-exchanged": (rot2**2, rot1**2),
    }
    turns = by_mistake(mistakes, taken, (rot1**2, rot2**2))
    variances = _sums(alphas, way**2, turns, squares)
    exchanged = by_mistake(mistakes, EXCHANGED, None)
    if exchanged is not None:
        others = _sums(alphas[[1, 0, 3, 2]], way**2, turns, squares)
        variances[exchanged] = others[exchanged]
    sizes = abs(way), (abs(rot1), abs(rot2)), abs(rot1) + abs(rot2)
    variances = by_mistake(
        mistakes,
        {
            "unsquared": _sums(alphas, *sizes),
            "turns-unsquared": _sums(alphas, way**2, sizes[1], squares),
            "turned-unsquared": _sums(alphas, way**2, (rot1**2, rot2**2), sizes[2]),
            "way-unsquared": _sums(alphas, abs(way), (rot1**2, rot2**2), squares),
            "own-way-unsquared": _sums(alphas, (abs(way), way**2), (rot1**2, rot2**2), squares),
            "turned-way-unsquared": _sums(alphas, (way**2, abs(way)), (rot1**2, rot2**2), squares),
        },
        variances,
    )
    if "absolute" in mistakes:
        return _sums(alphas, *sizes)
    if "deviations-summed" in mistakes:
        return _sums(np.sqrt(alphas), *sizes)
    if "turns-rooted" in mistakes:
        return _sums(np.sqrt(alphas), *sizes[:2], math.hypot(rot1, rot2))
    plain = [f"variance-{name}" in mistakes for name in ("way", "rot1", "rot2")]
    deviations: Array = np.where(
        np.array(plain) | ("variance" in mistakes), variances, np.sqrt(variances)
    )
    return np.sqrt(deviations) if "rooted-twice" in mistakes else deviations


def _sums(
    alphas: Array, way: float | tuple[float, float], turns: tuple[float, float], turned: float
) -> Array:
    """Return the three sums of the alphas with sizes of way, for itself and for the rotations, and
    of rotations."""
    a1, a2, a3, a4 = alphas
    own, other = way if isinstance(way, tuple) else (way, way)
    return np.array(
        [a3 * own + a4 * turned, a1 * turns[0] + a2 * other, a1 * turns[1] + a2 * other]
    )


def _alphas(alphas: Array, mistakes: frozenset[str]) -> Array:
    if "no-noise" in mistakes:
        return np.zeros(4)
    taken = next((order for name, order in ORDERS.items() if name in mistakes), None)
    if taken is not None:
        return alphas[list(taken)]
    lost = next((part for part in range(4) if f"alpha{part + 1}-lost" in mistakes), None)
    return alphas if lost is None else np.where(np.arange(4) == lost, 0.0, alphas)
