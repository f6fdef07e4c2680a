"""LaidSearch: finds whether all tape lies a little beside its drawing, as if laid by hand.

A robot whose place was known, and then contradicts odometry, is followed from there by tape exactly
as drawn, and by tape that may lie beside it. If steps contradict odometry with the first and not
with the second, it is the tape; if they do with both, it is the robot.
"""

from __future__ import annotations

import numpy as np

from robot.geometry import Array, Pose2
from robot.localization.monitoring.mounting_check import CameraPosition
from robot.misplaced_tape.laid_tape import LaidTape
from robot.misplaced_tape.laid_tracker import LaidTracker
from robot.misplaced_tape.search import RAYS, stands
from robot.scan import Scan, rays_of

ENOUGH = 60.0
"""So much larger the sum of surprises must be with tape as drawn."""
USUAL_LEAP = 4.0
"""With tape as laid, no leap may be larger [standard deviations]."""
KNOWN_SDS = (0.005, 0.005, 0.005)
"""What a place that is known by tape is off besides, if the tape is [m, m, rad]."""
REFUTED = -30.0
"""If tape as laid surprises by so much more than as drawn, and a scale by more, too, it lies as
drawn; on healthy robots some 300 scans tell. Of 46 searches that found it, by less doubt of wheels,
one had come to -26. Half: two of them end before; twice: less than half as many scans are spared.
"""
LEAST_SCANS = 40
"""So many scans must have been compared."""
LONGEST = 600
"""After so many, nothing is found any more."""
MISSES_SHARE, FADES = 0.05, 0.97
"""At most this share of the last returns may not be as expected; counts fade with each scan."""


class LaidTapes:
    """How the tape of a drawing may lie."""

    referenced = True
    """It never changes: states of a run that are stored share it."""

    def __init__(self, edges: Array) -> None:
        """Take edges (n, 4) [m] of the drawing."""
        self.as_drawn = LaidTape(edges, scales=False, bends=False)
        self.scaled = LaidTape(edges, bends=False)
        """Larger or smaller as a whole."""
        self.laid = LaidTape(edges)
        """Each place off by itself, too."""


class LaidSearch:
    """Looks for it from a known place on; scan by scan, for one thread."""

    def __init__(
        self,
        tapes: LaidTapes,
        mounting: CameraPosition,
        pose: Pose2,
        covariance: Array,
        odometry: Pose2,
    ) -> None:
        """Begin where the robot was known to be.

        Args:
            tapes: how the tape may lie.
            mounting: of the camera, or a laser's.
            pose: the place.
            covariance: its covariance (3, 3) [m, m, rad].
            odometry: there.
        """
        covariance = covariance + np.diag(np.square(KNOWN_SDS))
        self._as_drawn = LaidTracker(tapes.as_drawn, mounting, pose, covariance)
        self._scaled, self._laid = (
            _Candidate(LaidTracker(tape, mounting, pose, covariance))
            for tape in (tapes.scaled, tapes.laid)
        )
        self._odometry = odometry
        self._scans = 0

    @property
    def failed(self) -> bool:
        """Whether it is not that, or it takes too long."""
        refuted = self._laid.evidence < REFUTED and self._scaled.evidence < 0
        return self._laid.failed or refuted or self._scans > LONGEST

    def add(self, scan: Scan, odometry: Pose2) -> LaidTracker | None:
        """Take one more scan, and odometry at its stamp; return who follows tape as it lies."""
        moved = self._odometry.inverse() @ odometry
        if stands(moved):
            return None
        self._odometry = odometry
        self._scans += 1
        rays = rays_of(scan, RAYS)
        self._as_drawn.step(moved, rays)
        self._scaled.step(moved, rays, self._as_drawn.surprise)
        self._laid.step(moved, rays, self._as_drawn.surprise)
        if self._scans < LEAST_SCANS or not self._laid.fits:
            return None
        # A single number is sooner sure, but tape that was laid by hand is never only larger.
        evidence = max(each.evidence for each in (self._scaled, self._laid) if each.fits)
        return self._laid.tracker if evidence > ENOUGH else None


class _Candidate:
    """One way in which tape may lie, and what speaks for it."""

    def __init__(self, tracker: LaidTracker) -> None:
        self.tracker = tracker
        self.failed = False
        """Whether steps contradict odometry with it, too."""
        self.evidence = 0.0
        """How much less surprising scans were than with tape as drawn."""
        self._seen = self._missed = 0.0

    @property
    def fits(self) -> bool:
        """Whether the last scans fit, and all steps."""
        return not self.failed and self._missed <= MISSES_SHARE * self._seen

    def step(self, moved: Pose2, rays: Array, surprise: float) -> None:
        """Follow a step of odometry, and compare rays (n, 9); they surprise so with another."""
        if self.failed:
            return
        tracker = self.tracker
        tracker.step(moved, rays)
        self.evidence += surprise - tracker.surprise
        self._seen = FADES * self._seen + tracker.fits
        self._missed = FADES * self._missed + tracker.misses
        self.failed = tracker.leap > USUAL_LEAP or not tracker.is_plausible
