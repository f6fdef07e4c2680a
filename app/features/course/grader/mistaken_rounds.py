"""Weights, standing and sample sizes of a filter's round, with mistakes that are made."""

from __future__ import annotations

import math

import numpy as np

from app.features.course.grader.case import by_mistake
from robot.geometry import Array

STILL_M, STILL_RAD = 0.001, 0.01
"""The robot stands if it moved less, both ways."""
STANDS = (
    "either",
    "way-alone",
    "signed",
    "ahead-alone",
    "ahead-size",
    "side-lost",
    "larger",
    "sizes",
)
SIZES = (*("one-over-largest", "entropy", "heavy", "not-light", "largest-half", "sum-of-squares"),)
SCALED = (
    *("over-largest", "over-largest-size", "over-size", "over-sum", "over-sizes", "over-count"),
    *("over-spread", "over-deviation"),
)
UNITS = ("all-three", "all-summed", "turn-as-way")


def weighed(prior: Array, fits: Array, mistakes: frozenset[str]) -> Array:
    """Return weights by old weights and log-weights, and by what they are divided."""
    ratios = fits - (0.0 if "underflow" in mistakes else fits.max())
    likely = np.exp(by_mistake(mistakes, scaled_fits(fits), ratios))
    rules = {
        "no-exponential": prior + ratios,
        "log-added": prior + fits,
        "log-log": np.log(prior) + fits,
        "log-times": prior * fits,
        "ratios-times": prior * ratios,
        "prior-squared": prior**2 * likely,
        "scan-twice": prior * likely**2,
        "worse-more": prior / likely,
        "added": prior + likely,
        "averaged": prior + likely / likely.sum(),
        "exp-of-product": np.exp(prior * ratios),
        "exp-of-sum": np.exp(prior + ratios),
        "fits-alone": fits,
        "ratios-alone": ratios,
        "spread-times": prior * scaled_fits(fits)["over-spread"],
    }
    weights = by_mistake(mistakes, rules, prior * likely)
    sums = {
        "by-largest": weights.max(),
        "by-count": len(weights),
        "not-normalized": 1.0,
        "normalized-late": 1.0,
    }
    divided: Array = weights / by_mistake(mistakes, sums, weights.sum())
    return divided


def scaled_fits(fits: Array) -> dict[str, Array]:
    """Return log-weights divided by something, where the largest is to be subtracted."""
    sizes = np.abs(fits)
    return {
        "over-largest": fits / fits.max(),
        "over-largest-size": fits / abs(fits.max()),
        "over-size": fits / sizes.max(),
        "over-sum": fits / fits.sum(),
        "over-sizes": fits / sizes.sum(),
        "over-count": fits / len(fits),
        "over-spread": (fits - fits.min()) / np.ptp(fits),
        "over-deviation": (fits - fits.mean()) / fits.std(),
    }


def stands(moved: Array, mistakes: frozenset[str]) -> bool:
    """Return whether the robot counts as standing after a step."""
    dx, dy, turn = moved
    ways = {
        "ahead-alone": dx,
        "ahead-size": abs(dx),
        "side-lost": dx + dy,
        "larger": max(abs(dx), abs(dy)),
        "sizes": abs(dx) + abs(dy),
    }
    way = next((each for name, each in ways.items() if name in mistakes), math.hypot(dx, dy))
    if "all-three" in mistakes:
        return math.hypot(way, turn) < STILL_M
    if "all-summed" in mistakes:
        return bool(abs(dx) + abs(dy) + abs(turn) < STILL_M)
    short = way < STILL_M
    straight = (turn if "signed" in mistakes else abs(turn)) < STILL_RAD
    if "turn-in-degrees" in mistakes:
        straight = math.degrees(abs(turn)) < STILL_RAD
    if "turn-as-way" in mistakes:
        straight = abs(turn) < STILL_M
    if "either" in mistakes:
        return bool(short or straight)
    return bool(short and (straight or "way-alone" in mistakes))


def effective_sizes(shares: Array) -> dict[str, float]:
    """Return what is taken for the effective sample size."""
    count = len(shares)
    return {
        "one-over-largest": 1 / max(float(shares.max()), 1e-300),
        "entropy": math.exp(-float(np.sum(shares * np.log(np.maximum(shares, 1e-300))))),
        "heavy": float((shares > shares.mean()).sum()),
        "not-light": float((shares >= shares.mean()).sum()),
        "largest-half": 0.0 if shares.max() > 0.5 else float(count),
        "sum-of-squares": float((shares**2).sum()) * count,
    }
