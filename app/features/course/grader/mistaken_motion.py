"""Particles that move (Table 5.6 of Probabilistic Robotics), with mistakes that are made."""

from __future__ import annotations

import math

import numpy as np

from robot.geometry import Array, wrap_angle


def sampled(
    poses: Array, moved: Array, alphas: Array, mistakes: frozenset[str], seed: int
) -> Array:
    """Sample the odometry motion model (Probabilistic Robotics, Table 5.6), with mistakes."""
    dx, dy, turn = moved
    back = dx < 0 and "reverse-turns" not in mistakes
    way, rot1 = _first_part(dx, dy, mistakes, back=back)
    rot2 = wrap_angle(turn if "whole-turn" in mistakes else turn - rot1)
    way_hat, rot1_hat, rot2_hat = _noisy((way, rot1, rot2), alphas, len(poses), mistakes, seed)
    if "spin-moves" in mistakes:
        way_hat = way_hat + 0.05 * abs(turn)
    theta = wrap_angle(poses[:, 2] + rot1_hat + rot2_hat)
    angle = poses[:, 2] + rot1_hat
    if "new-heading" in mistakes:
        angle = theta
    if "old-heading" in mistakes:
        angle = poses[:, 2]
    if "degrees" in mistakes:
        angle = np.radians(angle)
    if "not-turned" in mistakes:
        angle = angle - poses[:, 2]
    if "one-rotation" in mistakes:
        theta = wrap_angle(poses[:, 2] + (rot1_hat if "second-lost" in mistakes else rot2_hat))
    x, y = way_hat * np.cos(angle), way_hat * np.sin(angle)
    if "sine-first" in mistakes:
        x, y = y, x
    return np.column_stack([poses[:, 0] + x, poses[:, 1] + y, theta])


def _first_part(
    dx: float, dy: float, mistakes: frozenset[str], *, back: bool
) -> tuple[float, float]:
    """Return the way and the rotation towards the step's end."""
    way, rot1 = math.hypot(dx, dy), math.atan2(dy, dx)
    if "direction-swapped" in mistakes:
        rot1 = math.atan2(dx, dy)
    return (-way, math.atan2(-dy, -dx)) if back else (way, rot1)


def _noisy(
    step: tuple[float, float, float],
    alphas: Array,
    count: int,
    mistakes: frozenset[str],
    seed: int,
) -> tuple[Array, Array, Array]:
    way, rot1, rot2 = step
    a1, a2, a3, a4 = _alphas(alphas, mistakes)
    turned_square = rot1**2 + rot2**2
    if "first-alone" in mistakes:
        turned_square = rot1**2
    if "second-alone" in mistakes:
        turned_square = rot2**2
    if "sum-squared" in mistakes:
        turned_square = (rot1 + rot2) ** 2
    variances = np.array(
        [
            a3 * way**2 + a4 * turned_square,
            a1 * rot1**2 + a2 * way**2,
            a1 * rot2**2 + a2 * way**2,
        ]
    )
    if "unsquared" in mistakes:
        turned = abs(rot1) + abs(rot2)
        variances = np.array(
            [
                a3 * abs(way) + a4 * turned,
                a1 * abs(rot1) + a2 * abs(way),
                a1 * abs(rot2) + a2 * abs(way),
            ]
        )
    deviations = variances if "variance" in mistakes else np.sqrt(variances)
    if "absolute" in mistakes:
        turned = abs(rot1) + abs(rot2)
        deviations = np.array(
            [
                a3 * abs(way) + a4 * turned,
                a1 * abs(rot1) + a2 * abs(way),
                a1 * abs(rot2) + a2 * abs(way),
            ]
        )
    rng = np.random.default_rng(seed)
    noise = rng.standard_normal((3, count))
    if "uniform" in mistakes:
        noise = rng.uniform(-1, 1, (3, count))
    if "from-zero" in mistakes:
        noise = rng.random((3, count))
    if "same-draw" in mistakes:
        noise[:] = noise[0]
    if "positive" in mistakes:
        noise = np.abs(noise)
    made = np.array(step)[:, None] + deviations[:, None] * noise
    return made[0], made[1], made[2]


def _alphas(alphas: Array, mistakes: frozenset[str]) -> Array:
    if "no-noise" in mistakes:
        return np.zeros(4)
    if "alphas-swapped" in mistakes:
        return alphas[[2, 3, 0, 1]]
    if "first-two-swapped" in mistakes:
        return alphas[[1, 0, 2, 3]]
    if "last-two-swapped" in mistakes:
        return alphas[[0, 1, 3, 2]]
    return alphas
