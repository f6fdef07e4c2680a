"""Summaries of runs: counts for Stanford diagrams, by error and claimed bound, and tables' rows."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from app.features.lab.evaluation.integrity.claims import Claims
from app.features.lab.evaluation.integrity.measures import certain
from robot.geometry import Array
from robot.localization.estimate import Cause, State

PLACE_BINS: Array = np.geomspace(1e-4, 10.0, 61)
"""Bin borders of errors and of radii [m]."""
HEADING_BINS: Array = np.geomspace(1e-4, 3.2, 61)
"""Bin borders of heading errors and of heading bounds [rad]."""
Row = dict[str, Any]
OTHER_FLOORS = ("enlarged", "shrunk", "hand-laid", "piece-elsewhere", "piece-missing")
EXPECTED: dict[str, tuple[Cause, ...]] = {
    "askew": (Cause.CAMERA_ASKEW,),
    **{f"bumped-{axis}": (Cause.CAMERA_ASKEW,) for axis in ("roll", "pitch", "yaw")},
    "late": (Cause.PICTURES_LATE,),
    "worn": (Cause.WHEEL_SIZE,),
    "slippery": (Cause.WHEEL_SLIP,),
    "stretched": (Cause.MAP,),
    **dict.fromkeys(OTHER_FLOORS, (Cause.MAP,)),
    "stuck": (Cause.WHEEL_SLIP,),
    "wheels-swapped": (Cause.MOTORS,),
    "wheel-reversed": (Cause.MOTORS,),
    "mirrored": (Cause.MOTORS,),
    "frozen": (Cause.FROZEN,),
    "lifted": (Cause.WHEEL_SLIP,),
    "pushed-along": (Cause.WHEEL_SLIP,),
    "late-for-a-while": (Cause.PICTURES_LATE,),
    "late-by-turns": (Cause.PICTURES_LATE,),
    "all-at-once": (
        Cause.CAMERA_ASKEW, Cause.PICTURES_LATE, Cause.WHEEL_SLIP, Cause.WHEEL_SIZE,
    ),
    "as-real": (Cause.CAMERA_ASKEW, Cause.PICTURES_LATE, Cause.WHEEL_SLIP),
    "hand-built": (Cause.CAMERA_ASKEW, Cause.PICTURES_LATE, Cause.WHEEL_SIZE),
}  # fmt: skip
"""The correct causes of each condition; in other conditions every named cause is a false alarm."""
NO_ALERT = "none"


@dataclass(frozen=True, eq=False)
class Stanford:
    """Number of pictures by error and claimed bound."""

    place: Array
    """(60, 60) by error and by radius; values beyond the bins count in the outermost bin."""
    heading: Array
    """(60, 60) the same for the heading."""
    unavailable: int
    """Pictures without a claimed bound."""

    @classmethod
    def empty(cls) -> Stanford:
        """Return zero counts."""
        bins = (len(PLACE_BINS) - 1, len(HEADING_BINS) - 1)
        return cls(np.zeros((bins[0], bins[0])), np.zeros((bins[1], bins[1])), 0)

    def __add__(self, other: Stanford) -> Stanford:
        return Stanford(
            self.place + other.place,
            self.heading + other.heading,
            self.unavailable + other.unavailable,
        )


def trade(stanford: Stanford, pictures: int) -> tuple[Array, Array]:
    """Return what a limit on the claimed radius costs and saves.

    The limit takes the value of each upper border of the radius bins.

    Returns:
        Two shares of all pictures (60,): those that claim a radius below the limit, and those of
        them whose error is in a bin above that of the radius.
    """
    claimed = stanford.place.sum(axis=0)
    outside = np.tril(stanford.place, -1).sum(axis=0)
    return np.cumsum(claimed) / max(pictures, 1), np.cumsum(outside) / max(pictures, 1)


def counted(claims: Claims) -> Stanford:
    """Count one robot's pictures that claim one place with a finite bound."""
    approximate = np.array([state is State.APPROXIMATE for state in claims.states], dtype=bool)
    shown = (certain(claims) | approximate) & np.isfinite(claims.radius)
    return Stanford(
        _histogram(claims.distances[shown], claims.radius[shown], PLACE_BINS),
        _histogram(claims.turns[shown], claims.heading_bound[shown], HEADING_BINS),
        int((~shown).sum()),
    )


def _histogram(errors: Array, bounds: Array, bins: Array) -> Array:
    low, high = bins[0] * 1.0001, bins[-1] * 0.9999
    counts, _, _ = np.histogram2d(np.clip(errors, low, high), np.clip(bounds, low, high), bins)
    return counts


def summary_of(rows: Sequence[Row]) -> dict[str, Any]:
    """Return the part ``summary`` of ``results.json``."""
    groups = grouped(rows, ("condition", "start"))
    conditions = grouped(rows, ("condition",))
    return {
        "all": group_summary(rows),
        "groups": [
            {"condition": condition, "start": start} | group_summary(some)
            for (condition, start), some in groups.items()
        ],
        "causes": {
            condition: causes_of(condition, some) for (condition,), some in conditions.items()
        },
    }


def grouped(rows: Iterable[Row], names: tuple[str, ...]) -> dict[tuple[str, ...], list[Row]]:
    """Group rows by their values of the named columns."""
    result: defaultdict[tuple[str, ...], list[Row]] = defaultdict(list)
    for row in rows:
        result[tuple(row[name] for name in names)].append(row)
    return dict(result)


def group_summary(rows: Sequence[Row]) -> Row:
    """Summarize a group: shares of the pictures of all robots, and statistics of its drives."""
    weights = np.array([row["pictures"] for row in rows], dtype=float)

    def over_pictures(name: str) -> float | None:
        return _weighted([row.get(name) for row in rows], weights)

    result = {
        "drives": len(rows),
        "pictures": int(weights.sum()),
        "misleading_drives": sum(row["misleading"] > 0 for row in rows),
        "misleading_longest_s": max(row["misleading_longest_s"] for row in rows),
        "lost_again_drives": sum(row["lost_again"] for row in rows),
        "right_to_the_end_drives": sum(row["right_to_the_end"] for row in rows),
        "time_to_right_median_s": _median([row["time_to_right_s"] for row in rows]),
        "ate_rmse_median_m": _median([row["ate_rmse_m"] for row in rows]),
        "ate_rmse_worst_m": _worst([row["ate_rmse_m"] for row in rows]),
        "nees_median_of_drives": _median([row["nees_mean"] for row in rows]),
        "decided_median_s": _median([row.get("decided_s") for row in rows]),
        "decided_drives": sum(row.get("decided_s") is not None for row in rows),
    }
    shares = (
        "right", "sure", "given", "misleading", "sure_wrong", "alarm_while_right",
        "sure_while_right", "available",
        "bound_mean_m", "nees_mean", "inside_95", "alert", "unfounded", "right_after_decided",
        "sure_after_decided", "misleading_before_carry", "misleading_first_second",
        "misleading_later",
    )  # fmt: skip
    later = [row["misleading_later_longest_s"] for row in rows if "misleading_later" in row]
    if later:
        result["misleading_later_longest_s"] = max(later)
    when_sure = weights * np.array([row["sure"] for row in rows])
    wrong_of_sure = [row["misleading_of_certain"] for row in rows]
    result["misleading_of_certain"] = _weighted(wrong_of_sure, when_sure)
    while_right = weights * np.array([row["right"] for row in rows])
    if while_right.any():
        sure = [row["sure_while_right"] for row in rows]
        result["sure_while_right"] = _weighted(sure, while_right)
    return {name: over_pictures(name) for name in shares} | result


def causes_of(condition: str, rows: Sequence[Row]) -> Row:
    """Return which cause was named first and most, in how many drives, and how soon."""
    expected = EXPECTED.get(condition, ())
    names = [*map(str, Cause), NO_ALERT]
    first = [row["first_cause"] or NO_ALERT for row in rows]
    main = [row["main_cause"] or NO_ALERT for row in rows]
    return {
        "expected": [str(cause) for cause in expected],
        "drives": len(rows),
        "first": {name: first.count(name) for name in names},
        "main": {name: main.count(name) for name in names},
        "first_right": _among(first, expected),
        "main_right": _among(main, expected),
        "first_alert_median_s": _median([row["first_alert_s"] for row in rows]),
        "pictures_with_alert": _weighted(
            [row["alert"] for row in rows], np.array([row["pictures"] for row in rows], float)
        ),
    }


def _among(named: list[str], expected: tuple[Cause, ...]) -> float | None:
    """Return the share of drives with a correct cause; None if no cause is correct."""
    return sum(name in expected for name in named) / len(named) if expected else None


def _weighted(values: Sequence[float | None], weights: Any) -> float | None:
    known = [place for place, value in enumerate(values) if value is not None and weights[place]]
    if not known:
        return None
    return float(
        np.average([float(values[place] or 0.0) for place in known], weights=weights[known])
    )


def _median(values: Sequence[float | None]) -> float | None:
    known = [value for value in values if value is not None]
    return float(np.median(known)) if known else None


def _worst(values: Sequence[float | None]) -> float | None:
    return max((value for value in values if value is not None), default=None)
