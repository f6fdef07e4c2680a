"""When a filter is asked: it follows odometry, and takes a scan once the robot has moved."""

from __future__ import annotations

import math
from dataclasses import replace

from robot.geometry import Array, Pose2
from robot.localization.estimate import Estimate, Hypothesis
from robot.localization.filter import Cloud, Filter
from robot.localization.integrity import SEARCHING, Integrity
from robot.localization.monitoring.claims import claim
from robot.localization.monitoring.monitor import NO_DOUBT, Monitor
from robot.localization.parameters import FilterParameters
from robot.localization.refinement import Refinement
from robot.scan import Scan


class Localizer:
    """A filter, fed as nav2_amcl feeds it."""

    def __init__(
        self,
        belief: Filter,
        parameters: FilterParameters,
        refinement: Refinement | None = None,
        reach: tuple[float, float] = (0.0, math.inf),
        monitor: Monitor | None = None,
    ) -> None:
        self.reach = reach
        """Shortest and longest range that are believed [m]."""
        self.filter = belief
        self.parameters = parameters
        self.refinement = refinement
        """Makes the heaviest hypothesis finer; None leaves it as the filter has it."""
        self.monitor = monitor
        """Watches what is claimed; None claims by weight and covariance alone."""
        self.updates = 0
        """Scans taken since the belief was last made anew."""
        self.integrity: Integrity = SEARCHING
        """What is claimed of the newest estimate."""
        self.now: Pose2 | None = None
        """The robot in the odom frame when a pose is told; None takes that of the next scan."""
        self._odometry: Pose2 | None = None
        self._forced = True

    def set_pose(self, pose: Pose2, covariance: Array | None = None) -> None:
        """Start anew around a pose in the map; without a covariance (3, 3), the one set."""
        self.filter.set_pose(
            pose, self.parameters.initial_covariance if covariance is None else covariance
        )
        self._restart()

    def set_hypotheses(self, hypotheses: tuple[Hypothesis, ...]) -> None:
        """Start anew at places whose weights are relative to each other."""
        self.filter.set_hypotheses(hypotheses)
        self._restart()

    def set_cloud(self, cloud: Cloud) -> None:
        """Start anew from given weighted poses."""
        self.filter.set_cloud(cloud)
        self._restart()

    def scatter(self) -> None:
        """Start anew: the robot may be anywhere on the field."""
        self.filter.scatter()
        self._restart()

    def force_update(self) -> None:
        """Let the next scan count, however little the robot moves."""
        self._forced = True

    def predict(self, odometry: Pose2) -> bool:
        """Follow odometry alone: while scans are paused.

        Returns whether it moved; it stays while the robot has hardly moved since the last time.

        Args:
            odometry: the robot in the odom frame.
        """
        moved = self._moved(odometry)
        due = self._is_due(moved)
        if due:
            self._odometry = odometry
            self.filter.predict(self._as_wheels_are(moved))
        return due

    def update(self, odometry: Pose2, scan: Scan) -> Estimate | None:
        """Take a scan; None while the robot has hardly moved since the last, or nothing is known.

        Args:
            odometry: the robot in the odom frame, at the scan's stamp.
            scan: the measurement.
        """
        moved = self._moved(odometry)
        if not (self._forced or self._is_due(moved)):
            return None
        self._forced = False
        # The window of odometry advances only here, so no motion is lost between updates.
        self._odometry = odometry
        self.filter.predict(self._as_wheels_are(moved))
        seen = scan.within(*self.reach)
        if self.monitor is not None:
            seen = self.monitor.corrected(seen)
        self.filter.correct(seen)
        self.updates += 1
        estimate = self.estimate(scan.stamp)
        if estimate is None:
            return None
        heaviest = estimate.hypotheses[0]
        if self.refinement is not None:
            heaviest = self.refinement.refine(heaviest, seen)
        if self.monitor is not None:
            spread = estimate.effective / max(len(self.filter.cloud.weights), 1)
            self.monitor.observe(heaviest, seen, odometry, spread)
            self.filter.loosen(self.monitor.looseness)
            heaviest = self.monitor.caught_up(heaviest)
            heaviest = replace(
                heaviest, covariance=heaviest.covariance + self.monitor.doubt.covariance
            )
        estimate = replace(estimate, hypotheses=(heaviest, *estimate.hypotheses[1:]))
        self.integrity = self._claim(estimate)
        return estimate

    def estimate(self, stamp: float) -> Estimate | None:
        """What the filter says now; None while it cannot say anything."""
        hypotheses = self.filter.hypotheses
        if not hypotheses:
            self.integrity = SEARCHING
        return Estimate(stamp, hypotheses, self.filter.effective) if hypotheses else None

    def _claim(self, estimate: Estimate) -> Integrity:
        doubt = NO_DOUBT if self.monitor is None else self.monitor.doubt
        return claim(estimate.hypotheses, self.filter.standing, doubt)

    def _restart(self) -> None:
        self.updates = 0
        self.integrity = SEARCHING
        if self.monitor is not None:
            self.monitor.begin_anew()
        # The belief is about the robot where it is now: what it drove before is in it already.
        self._odometry = self.now
        self._forced = True

    def _moved(self, odometry: Pose2) -> Pose2:
        if self._odometry is None:
            self._odometry = odometry
        return self._odometry.inverse() @ odometry

    def _as_wheels_are(self, moved: Pose2) -> Pose2:
        return moved if self.monitor is None else self.monitor.corrected_step(moved)

    def _is_due(self, moved: Pose2) -> bool:
        far = math.hypot(moved.x, moved.y) >= self.parameters.update_min_d
        return far or abs(moved.theta) >= self.parameters.update_min_a
