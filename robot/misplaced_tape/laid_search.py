"""LaidSearch: finds whether all tape lies a little beside its drawing, as if laid by hand.

A robot that was certain, and then contradicts odometry, is followed from there twice: with tape
exactly as drawn, and with tape that may lie beside it. If steps contradict odometry with the first
and not with the second, it is the tape; if they do with both, it is the robot.
"""

from __future__ import annotations

from robot.geometry import Array, Pose2
from robot.localization.monitoring.mounting_check import CameraPosition
from robot.misplaced_tape.laid_tape import LaidTape
from robot.misplaced_tape.laid_tracker import LaidTracker
from robot.misplaced_tape.search import RAYS, stands
from robot.scan import Scan, rays_of

ENOUGH = 40.0
"""So much larger the sum of squared leaps must be with tape as drawn."""
LARGEST_LEAP = 10.0
"""No leap counts for more [standard deviations]."""
USUAL_LEAP = 4.0
"""With tape as laid, no leap may be larger [standard deviations]."""
LEAST_SCANS = 20
"""So many scans must have been compared."""
LONGEST = 600
"""After so many, nothing is found any more."""
MISSES_SHARE, FADES = 0.05, 0.97
"""At most this share of the last returns may not be as expected; counts fade with each scan."""


class LaidSearch:
    """Looks for it from a known place on; scan by scan, for one thread."""

    def __init__(
        self,
        tapes: tuple[LaidTape, LaidTape],
        mounting: CameraPosition,
        pose: Pose2,
        covariance: Array,
        odometry: Pose2,
    ) -> None:
        """Begin where the robot was known to be.

        Args:
            tapes: exactly as drawn, and as it may lie.
            mounting: of the camera, or a laser's.
            pose: the place.
            covariance: its covariance (3, 3) [m, m, rad].
            odometry: there.
        """
        self._as_drawn, self.tracker = (
            LaidTracker(tape, mounting, pose, covariance) for tape in tapes
        )
        self._odometry = odometry
        self._evidence = 0.0
        self._fits = self._misses = 0.0
        self._scans = 0
        self.failed = False
        """Whether it is not that, or it takes too long."""

    def add(self, scan: Scan, odometry: Pose2) -> bool:
        """Take one more scan, and odometry at its stamp; return whether tape lies beside."""
        moved = self._odometry.inverse() @ odometry
        if stands(moved) or self.failed:
            return False
        self._odometry = odometry
        rays = rays_of(scan, RAYS)
        self._as_drawn.step(moved, rays)
        self.tracker.step(moved, rays)
        self._evidence += min(self._as_drawn.leap, LARGEST_LEAP) ** 2 - self.tracker.leap**2
        self._scans += 1
        self._fits = FADES * self._fits + self.tracker.fits
        self._misses = FADES * self._misses + self.tracker.misses
        torn = self.tracker.leap > USUAL_LEAP or not self.tracker.is_plausible
        self.failed = torn or self._scans > LONGEST
        fits = self._misses <= MISSES_SHARE * self._fits
        return not self.failed and fits and self._scans >= LEAST_SCANS and self._evidence > ENOUGH
