"""Count errors against claimed bounds in logarithmic bins, as in Stanford diagrams."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from app.lab.evaluation.integrity.claims import Claims
from app.lab.evaluation.integrity.measures import certain
from robot.geometry import Array
from robot.localization.estimate import State

PLACE_BINS: Array = np.geomspace(1e-4, 10.0, 61)
"""Bin borders of errors and of radii [m]."""
HEADING_BINS: Array = np.geomspace(1e-4, 3.2, 61)
"""Bin borders of heading errors and of heading bounds [rad]."""


@dataclass(frozen=True)
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
