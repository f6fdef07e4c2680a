"""PlaceWatch: looks whether the place is known, and tells the filter one that it has lost."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from app.engine.added_models import AddedModels
from robot.covariance import widest
from robot.geometry import Array, Pose2
from robot.localization.estimate import KNOWN, Integrity, State

KNOWN_SDS = (0.005, 0.005, 0.01)
"""What a place may be off that is certain or followed, besides its covariance [m, m, rad]."""
BOUND_SDS = 3.5
"""A bound that holds in 99.9 % is about so many standard deviations of a place or a heading."""
AWAY_M, AWAY_S = 0.04, 0.5
"""The filter is told the place if it knows none, or one that is farther away than this [m], for so
long [s]."""
TOLD_S = 3.0
"""It is told at most once in so many seconds."""
SURE_M = 0.03
"""It is told only a place that is known so well [m], one standard deviation."""

Outline = tuple[tuple[float, float, float, float], ...]
"""Edges of a piece of tape: x and y of both ends of each [m]."""


class KnownPlace(NamedTuple):
    """A place that was known."""

    pose: Pose2
    covariance: Array
    odometry: Pose2

    @classmethod
    def claimed(
        cls, claim: Integrity, pose: Pose2, covariance: Array, odometry: Pose2
    ) -> KnownPlace:
        """Return a place that may be off by as much as is claimed, or by more."""
        along, turn = claim.radius / BOUND_SDS, claim.heading_bound / BOUND_SDS
        return cls(pose, covariance + np.diag(np.square([along, along, turn])), odometry)


@dataclass(slots=True)
class Telling:
    """When the filter is told a place."""

    agreed_at: float = -math.inf
    """When the filter last knew the same place."""
    told_at: float = -math.inf

    def place(
        self,
        stamp: float,
        followed: tuple[Pose2, Array],
        state: State,
        pose: Pose2 | None,
    ) -> tuple[Pose2, Array] | None:
        """Return a place that is followed, with its covariance; None if the filter knows it.

        Args:
            stamp: of the newest scan [s].
            followed: the place, and its covariance (3, 3) [m, m, rad].
            state: what is claimed of the filter's place.
            pose: this place; None without one.
        """
        place, covariance = followed
        covariance = covariance + np.diag(np.square(KNOWN_SDS))
        sure = widest(covariance) < SURE_M
        if not sure or (state in KNOWN and pose and pose.distance_to(place) < AWAY_M):
            self.agreed_at = stamp
        if stamp < max(self.agreed_at + AWAY_S, self.told_at + TOLD_S):
            return None
        self.told_at = stamp
        return place, covariance


class PlaceWatch(AddedModels):
    """Offers no model: it looks at the scans that the program's own ones get, and clears them."""

    @property
    def outline(self) -> Outline | None:
        """Where the drawing has tape that does not lie there; None if all does."""
        return None

    def look(self, claim: Integrity, pose: Pose2, covariance: Array, odometry: Pose2) -> None:
        """Look whether the place is known that the newest scan has led to.

        Args:
            claim: what is claimed of it.
            pose: the likeliest place.
            covariance: its covariance (3, 3) [m, m, rad].
            odometry: at the scan's stamp.
        """

    def place(
        self, state: State, pose: Pose2 | None, odometry: Pose2
    ) -> tuple[Pose2, Array] | None:
        """Return where the filter shall look for the robot, with a covariance; None if it knows.

        Args:
            state: what is claimed of the filter's place.
            pose: this place at ``odometry``; None without one.
            odometry: now.
        """

    def forget(self) -> None:
        """Forget where the robot was: somebody has said where it is, or that nobody knows."""
