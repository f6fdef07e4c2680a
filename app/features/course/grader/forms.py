"""Forms of results: what a function returns has to be poses, weights or a number."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from app.features.course.grader.case import FormError, NoNumberError, Outcome, Sign
from app.features.course.grader.words import Words
from robot.geometry import Array

LONGEST_WORDS = 200
"""What a function gives in place of numbers is shown up to here [characters]."""
SURELY_DEGREES = 30.0
"""No heading in radians is as large by a forgotten wrap alone."""


def array_of(value: Any, shape: tuple[int, ...], *, finite: bool = True) -> Array:
    """Return a result as an array of a shape.

    Raises:
        FormError: it is none.
    """
    _demand_value(value)
    if isinstance(value, str):
        raise FormError("The function gives a {what}.", what=value[:LONGEST_WORDS])
    try:
        result = np.asarray(value, dtype=np.float64)
    except (TypeError, ValueError, OverflowError):
        raise _wanted(shape, "parts of different lengths") from None
    if result.shape != shape:
        raise _wanted(shape, str(result.shape))
    if finite and not np.isfinite(result).all():
        wrong = result[~np.isfinite(result)].flat[0]
        raise NoNumberError("The function gives {wrong} where a number is due.", wrong=wrong)
    return result


def pair_of(value: Any) -> tuple[Any, Any]:
    """Return a result of two parts.

    Raises:
        FormError: it has not two parts.
    """
    _demand_value(value)
    if isinstance(value, np.ndarray) and value.ndim and len(value) == 2:
        return value[0], value[1]
    if not isinstance(value, tuple) or len(value) != 2:
        raise FormError("The function has to give two things: return first, second.")
    return value[0], value[1]


def _demand_value(value: Any) -> None:
    if value is None:
        raise FormError("The function gives None. Is its return missing?")


def _wanted(shape: tuple[int, ...], given: str) -> FormError:
    text = "The function gives the shape {given}; {wanted} is due."
    return FormError(text, given=given, wanted=str(shape))


def pose_features(pose: Array) -> Array:
    """Return a pose (3,) as (4,): x, y and the heading's cosine and sine."""
    x, y, theta = pose
    return np.array([x, y, math.cos(theta), math.sin(theta)])


def headings_apart(poses: Array) -> Array:
    """Return poses (n, 3) as (n, 4): x, y and the heading's cosine and sine, which do not jump."""
    x, y, theta = poses.T
    return np.column_stack([x, y, np.cos(theta), np.sin(theta)])


def heading_sign(outcome: Outcome, poses: Array) -> Iterator[Sign]:
    """Yield E2 if a heading of poses (n, 3) lies outside of -pi to pi; S4 if it is in degrees."""
    wrong = poses[np.abs(poses[:, 2]) > math.pi + 1e-9]
    if len(wrong):
        text = "The heading is given as {heading} rad; -π to π is due."
        note = Words(text, {"heading": f"{wrong[0, 2]:.3f}"})
        degrees = np.abs(wrong[:, 2]).max() > SURELY_DEGREES
        yield Sign("S4" if degrees else "E2", outcome, apart=True, note=note, weak=True)


def heading_signs(outcomes: Sequence[Outcome], poses: Sequence[Array]) -> Iterator[Sign]:
    """Yield what ``heading_sign`` says of outcomes, with their poses (n, 3); S4 explains E2."""
    pairs = zip(outcomes, poses, strict=True)
    signs = [sign for item, each in pairs for sign in heading_sign(item, each)]
    degrees = [sign for sign in signs if sign.cause == "S4"]
    yield from degrees or signs


def generator_signs(outcome: Outcome, results: Sequence[NDArray[Any]]) -> Iterator[Sign]:
    """Name chance that is not the generator's.

    Args:
        outcome: a case with several seeds.
        results: what each call gave: two with the same seed first, then others.
    """
    first, repeated, *others = results
    if not np.array_equal(first, repeated):
        note = Words("The same seed gives two different results: the chance is not rng's.")
        yield Sign("generator", outcome, apart=True, note=note)
    elif all(np.array_equal(first, other) for other in others):
        note = Words("Each seed gives the same result: nothing is drawn from rng.")
        yield Sign("no-chance", outcome, apart=True, note=note, weak=True)
