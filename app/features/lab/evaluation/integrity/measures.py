"""Measures of one robot's claims."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from app.features.lab.evaluation.integrity.claims import Claims
from app.features.lab.evaluation.runs import (
    Mask,
    first_sustained,
    in_place,
    lost_again,
    right_to_the_end,
)
from app.features.lab.trajectories.metrics import rms
from robot.geometry import Array
from robot.localization.estimate import Cause, State

FIRST = 1.0
"""For this time after the robot was carried off, nobody can know about it [s]."""
SETTLE = 1.0
"""Covariances are compared with errors from this time after the start on [s]."""
USEFUL = 0.02
"""A claim is useful if its radius is less than this [m]."""
ELLIPSE = 5.991
"""Squared Mahalanobis radius of the ellipse that holds 95 % in two dimensions."""

Measures = dict[str, Any]


def right(claims: Claims) -> Mask:
    """Return which estimates (n,) are right."""
    return in_place(claims.distances, claims.turns)


def certain(claims: Claims) -> Mask:
    """Return which pictures (n,) claim to be certain."""
    return _in_state(claims, State.CERTAIN)


def outside(claims: Claims) -> Mask:
    """Return at which pictures (n,) the truth lies outside the claimed bounds."""
    beyond: Mask = (claims.distances > claims.radius) | (claims.turns > claims.heading_bound)
    return beyond


def misleading(claims: Claims) -> Mask:
    """Return which pictures (n,) claim to be certain while the truth lies outside the bounds."""
    return certain(claims) & outside(claims)


def measures(claims: Claims) -> Measures:
    """Return all measures of one robot, in the form of ``results.json``: m, rad, s, shares."""
    is_right, wrong_claim = right(claims), misleading(claims)
    alarm = _in_state(claims, State.LOST) | _in_state(claims, State.SEARCHING)
    within = is_right & ~outside(claims)
    after = _after_carry(claims)
    return {
        "pictures": len(claims.stamps),
        "right": _share(is_right),
        "sure": _share(certain(claims)),
        "given": _share(_in_state(claims, State.GIVEN)),
        "misleading": _share(wrong_claim),
        "misleading_of_certain": _mean(outside(claims)[certain(claims)]),
        "misleading_longest_s": longest(claims.stamps, wrong_claim),
        "sure_wrong": _share(certain(claims) & ~is_right),
        "sure_wrong_longest_s": longest(claims.stamps, certain(claims) & ~is_right),
        "lost_again": bool(_lost_again(claims)),
        "right_to_the_end": right_to_the_end(claims.stamps[after], is_right[after]),
        "alarm_while_right": _share(alarm & within),
        "time_to_right_s": _finite(time_to_right(claims.stamps[after], is_right[after])),
        "ate_rmse_m": _rms(claims.distances),
        "available": _share(certain(claims) & (claims.radius < USEFUL)),
        "bound_mean_m": _mean(claims.radius[certain(claims)]),
        "sure_while_right": _mean(certain(claims)[is_right]),
        **_consistency(claims),
        **_carry_measures(claims, wrong_claim),
        **_cause_measures(claims),
    }


def time_to_right(stamps: Array, is_right: Mask) -> float:
    """Return the time [s] from the first stamp until it is right for a second; inf if never."""
    first = first_sustained(stamps, is_right)
    return math.inf if first is None else float(stamps[first] - stamps[0])


def longest(stamps: Array, some: Mask) -> float:
    """Return the longest unbroken time [s]; each picture's claim holds until the next picture."""
    ends = np.append(stamps[1:], stamps[-1] + np.median(np.diff(stamps)))
    longest_yet, begin = 0.0, math.inf
    for stamp, end, current in zip(stamps, ends, some, strict=True):
        begin = min(begin, stamp) if current else math.inf
        if current:
            longest_yet = max(longest_yet, float(end - begin))
    return longest_yet


def _lost_again(claims: Claims) -> bool:
    """Whether it was lost again before or after the carry; the carry itself does not count."""
    is_right, sure, after = right(claims), certain(claims), _after_carry(claims)
    parts = (after,) if claims.carry_stamp is None else (~after, after)
    return any(lost_again(claims.stamps[p], is_right[p], sure[p]) for p in parts)


def _after_carry(claims: Claims) -> Mask:
    """Return which pictures (n,) come after the robot was carried off; all if it never was."""
    stamp = -math.inf if claims.carry_stamp is None else claims.carry_stamp
    later: Mask = claims.stamps > stamp + 1e-6
    return later


def _carry_measures(claims: Claims, wrong_claim: Mask) -> Measures:
    """Return the misleading shares before the carry, in the first second after it, and later."""
    if claims.carry_stamp is None:
        return {}
    since = claims.stamps - claims.carry_stamp
    later = since > FIRST + 1e-6
    first = (since > 1e-6) & ~later
    before = since <= 1e-6
    return {
        "misleading_before_carry": _share(wrong_claim[before]),
        "misleading_first_second": _share(wrong_claim[first]),
        "misleading_later": _share(wrong_claim[later]),
        "misleading_later_longest_s": longest(claims.stamps, wrong_claim & later),
        "time_to_right_before_carry_s": _finite(
            time_to_right(claims.stamps[before], right(claims)[before])
        ),
    }


def _consistency(claims: Claims) -> Measures:
    """Return the NEES (3 is consistent) and the share within the position's 95 % ellipse.

    Only pictures that claim one place count, from a second after the start on.
    """
    one_place = certain(claims) | _in_state(claims, State.APPROXIMATE)
    used = one_place & (claims.stamps >= claims.stamps[0] + SETTLE)
    offset, covariance = claims.errors[used], claims.covariance[used]
    sound = np.isfinite(offset).all(axis=1) & np.isfinite(covariance).all(axis=(1, 2))
    offset, covariance = offset[sound], covariance[sound]
    sound = np.linalg.det(covariance) > 0
    if not sound.any():
        return {"nees_mean": None, "nees_median": None, "inside_95": None}
    nees = _squared(offset[sound], covariance[sound])
    place = _squared(offset[sound, :2], covariance[sound, :2, :2])
    return {
        "nees_mean": float(nees.mean()),
        "nees_median": float(np.median(nees)),
        "inside_95": float((place < ELLIPSE).mean()),
    }


def _squared(offset: Array, covariance: Array) -> Array:
    """Return e' P^-1 e (n,)."""
    solved = np.linalg.solve(covariance, offset[..., None])[..., 0]
    result: Array = (offset * solved).sum(axis=1)
    return result


def _cause_measures(claims: Claims) -> Measures:
    """Return which causes were named first and most, how soon, and in which share of pictures.

    Only pictures before the carry count: after it doubt is justified, whatever cause is named.
    """
    until = math.inf if claims.carry_stamp is None else claims.carry_stamp
    count = int(np.searchsorted(claims.stamps, until, side="right"))
    causes = claims.causes[:count]
    doubts = [index for index, cause in enumerate(causes) if cause is not None]
    first = doubts[0] if doubts else None
    counted = {cause: causes.count(cause) for cause in Cause}
    most = max(counted, key=counted.__getitem__)
    return {
        "alert": len(doubts) / max(count, 1),
        "first_alert_s": None if first is None else float(claims.stamps[first] - claims.stamps[0]),
        "first_cause": None if first is None else str(causes[first]),
        "main_cause": str(most) if counted[most] else None,
    }


def _in_state(claims: Claims, state: State) -> Mask:
    return np.array([item is state for item in claims.states], dtype=bool)


def _share(some: Mask) -> float:
    return float(some.mean()) if len(some) else 0.0


def _mean(values: Array | Mask) -> float | None:
    finite = values[np.isfinite(values)]
    return float(finite.mean()) if len(finite) else None


def _rms(values: Array) -> float | None:
    finite = values[np.isfinite(values)]
    return rms(finite) if len(finite) else None


def _finite(value: float) -> float | None:
    return value if math.isfinite(value) else None
