"""WithoutPiece: follows a robot without a piece of tape, and clears its scans of that."""

from __future__ import annotations

import numpy as np

from robot.geometry import Pose2
from robot.misplaced_tape.search import RAYS, Misplaced, misplaced, stands
from robot.misplaced_tape.tape_drawing import PlaceFollower, TapeDrawing
from robot.scan import Scan, rays_of

EDGE = 0.03
"""So far before the piece a ray's sight ends [m]."""
FADES = 0.97
"""Counts of rays fade by this with each scan."""
LOST_SHARE, LEAST_RAYS = 0.3, 40
"""The place is lost if so large a share of the last rays does not fit; fewer tell nothing."""
LOST_M = 0.1
"""It is also lost if its standard deviation is larger [m]."""
FITS_SHARE = 0.9
"""The piece fits again if so large a share of the last rays that look there see it."""


class WithoutPiece:
    """The place of a robot while one piece of tape is not where the drawing has it."""

    def __init__(
        self, drawing: TapeDrawing, follower: PlaceFollower, finding: Misplaced, odometry: Pose2
    ) -> None:
        """Go on with a follower that leaves the piece out, from where odometry is now."""
        self.finding = finding
        """The piece, and how far it lies aside by all that was seen of it."""
        self._drawing, self._follower, self._odometry = drawing, follower, odometry
        self._fits = self._misses = self._in_place = self._through = 0.0

    def clear(self, scan: Scan, odometry: Pose2) -> Scan:
        """Follow the robot by one more scan, and odometry at its stamp; let it end there."""
        moved = self._odometry.inverse() @ odometry
        if not stands(moved):
            self._odometry = odometry
            self._step(moved, scan)
        return self._hidden(scan, self._follower.tracker.pose)

    @property
    def is_lost(self) -> bool:
        """Whether the robot is no longer where it is followed."""
        looked = self._fits + self._misses
        odd = looked > LEAST_RAYS and self._misses > LOST_SHARE * looked
        return odd or self._follower.tracker.width > LOST_M

    @property
    def fits_again(self) -> bool:
        """Whether the piece lies where it is drawn."""
        looked = self._in_place + self._through
        return looked > LEAST_RAYS and self._in_place > FITS_SHARE * looked

    def place(self, odometry: Pose2) -> tuple[Pose2, np.ndarray]:
        """Return where the robot is at an odometry pose, and its covariance (3, 3) by scans."""
        tracker = self._follower.tracker
        return tracker.pose @ (self._odometry.inverse() @ odometry), tracker.by_scans

    def _hidden(self, scan: Scan, pose: Pose2) -> Scan:
        """Return a scan from a pose that ends before the piece."""
        every = rays_of(scan, len(scan.ranges))
        begin = self._drawing.hidden_from(self._follower, every, pose) - EDGE
        if not np.isfinite(begin).any():
            return scan
        # No thing may begin there instead: where tape is drawn, it would be taken for that.
        return scan.until(begin)

    def _step(self, moved: Pose2, scan: Scan) -> None:
        follower, rays = self._follower, rays_of(scan, RAYS)
        before = follower.fits, follower.misses, follower.in_place, follower.through
        # The piece itself would be taken for other tape at its ends.
        others = self._hidden(scan, follower.tracker.pose @ moved)
        follower.tracker.step(moved, rays_of(others, RAYS))
        self._drawing.look(follower, rays)
        self._fits = FADES * self._fits + follower.fits - before[0]
        self._misses = FADES * self._misses + follower.misses - before[1]
        self._in_place = FADES * self._in_place + follower.in_place - before[2]
        self._through = FADES * self._through + follower.through - before[3]
        self.finding = misplaced(follower) or self.finding
