"""Watches an estimate: do scans and odometry fit what the models claim?

What is steadily off shows in the scans. What stands out of its own spread is taken off: the tilt of
the camera, the size of the wheels, the lateness of pictures. The monitor says what the likeliest
reason is, and how far the pose may still be off.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace

import numpy as np

from robot.geometry import Array, Pose2, heading_angles
from robot.localization.estimate import Hypothesis
from robot.localization.integrity import Alert, Cause
from robot.localization.monitoring.causes import Causes, Findings
from robot.localization.monitoring.mounting import LASER, Mounting
from robot.localization.monitoring.mounting_check import MountingCheck
from robot.localization.monitoring.odometry_check import OdometryCheck, OdometryErrors
from robot.localization.monitoring.pose_errors import pose_errors
from robot.localization.monitoring.scan_residuals import residual_sums
from robot.localization.ray_evidence import RayEvidence
from robot.localization.rays import rays_of
from robot.localization.scan_matching import ScanMatcher
from robot.scan import Scan

BEAMS = 91
"""Rays of a scan that are looked at."""
LAID_SD, LAID_SLOPE, LAID_GATE = 0.0003, 25.0, 0.03
"""Spread of a near range [m], how it grows [1/m²], and the gate [m] with which a scan is laid on
the edges before it is looked at."""
LOOSE = np.diag(1 / np.square([0.03, 0.03, 0.1]))
"""How little then is held to where the robot should be [1/m², 1/m², 1/rad²]."""
FITTING = 0.5
"""Share of a new scan in the mean of how well scans fit."""
FORGETTING = 0.01
"""Share of what scans did to the pose that the next one makes forget."""
MOST_PULLED = 1.5
"""What one scan may do to the pose counts for no more: another place may take the lead."""
TRUSTED, EXPLAINED = 0.95, 0.6
"""Weight of a place, and share of the returns that it explains, to learn of the robot there."""
TORN = 2.5
"""Where steps differ from odometry by so many spreads, wheels slip or it was carried off."""
JUMP, JUMP_TURN = 0.04, 0.2
"""A pose that moves so much from one scan to the next is another place [m], [rad]."""
LOOSEST = 4.0
"""Odometry is believed this much less, at most."""
USUAL = 1.5
"""Steps that differ from odometry by no more than so many spreads are as usual."""
SEEING, BLIND_AFTER, BLIND = 6, 0.3, 2.5
"""With fewer rays on edges than this for so long [s], steps add up unseen, and err so many times
more than each by itself: slip lasts for about a second, and wheels are never quite as drawn."""
DOUBT_KEPT = 5.0
"""For so long after a doubt the pose may still be off [s]."""
SCALE_SD, SCALE_DOUBTED = 0.007, 0.015
"""How much too large or too small a map may be that is not doubted, and one that is."""
LEAST_LATE = 0.001
"""Less is not made up for [s]."""
LATE_SURE, LATE_BLEND = 3.0, 0.1
"""Lateness of so many standard deviations is made up for, by so much more with each scan."""


@dataclass(frozen=True, slots=True)
class Doubt:
    """How far an estimate may be off by what its covariance does not know."""

    covariance: Array = field(repr=False)
    """(3, 3) [m, m, rad] by what was found: zero while nothing is."""
    unknown: Array = field(repr=False)
    """(3, 3) by what was not found, but cannot be excluded yet."""
    alerts: tuple[Alert, ...]
    fits: bool
    """Whether the last scans fit here at all, and poses follow each other as odometry says."""


NO_DOUBT = Doubt(np.zeros((3, 3)), np.zeros((3, 3)), (), True)


class Monitor:
    """Takes each estimate with the scan that it was made of."""

    def __init__(self, evidence: RayEvidence, mounting: Mounting = LASER) -> None:
        self.use(evidence)
        self._mounting = mounting
        self._odometry = OdometryCheck()
        self._camera = MountingCheck()
        self._causes = Causes()
        self._stamp: float | None = None
        self._last: tuple[Pose2, Pose2] | None = None
        """Pose and odometry of the last scan."""
        self._seen = -math.inf
        """When edges were seen last [s]."""
        self._fit = 1.0
        self._pulled = 0.0
        """By how much scans moved the pose to where they fit worse, as log-likelihood."""
        self._doubted = -math.inf
        """When a doubt was raised last [s]."""
        self.doubt = NO_DOUBT
        self.lateness = 0.0
        """By so much pictures seem to be stamped later than they were taken [s]."""
        self._wheels: tuple[float, ...] = (0.0, 0.0, 0.0)
        """By how much odometry seems to be off: forward, turn by way [rad/m], and turn."""
        self.looseness = 1.0
        """How many times wider than usual odometry seems to err."""

    def begin_anew(self) -> None:
        """Another pose was told: what was found of the robot stays, steps to here do not count."""
        self._odometry.begin_anew()
        self._last, self._fit, self._pulled = None, 1.0, 0.0
        self._causes.forget()
        self.doubt = NO_DOUBT

    def use(self, evidence: RayEvidence) -> None:
        """Go on with other parameters."""
        self._evidence = evidence
        self._matcher = ScanMatcher(
            evidence.index, evidence.range_max, LAID_SD, LAID_GATE, LAID_SLOPE
        )

    def caught_up(self, hypothesis: Hypothesis) -> Hypothesis:
        """Where the robot is at the scan's stamp, if its picture was taken before."""
        if self.lateness == 0.0:
            return hypothesis
        return replace(
            hypothesis, pose=hypothesis.pose @ self._odometry.twist.integrate(self.lateness)
        )

    def corrected_step(self, moved: Pose2) -> Pose2:
        """A step by odometry as it would be with wheels of the size that they seem to have."""
        forward, turn_by_way, turn = self._wheels
        theta = moved.theta * (1 + turn) + moved.x * turn_by_way
        target = Pose2(theta=0.5 * (theta - moved.theta)) @ Pose2(moved.x, moved.y)
        return Pose2((1 + forward) * target.x, (1 + forward) * target.y, theta)

    def corrected(self, scan: Scan) -> Scan:
        """A scan as it would be without the tilt that the camera seems to have."""
        tilt, hit = self._camera.applied, scan.hit
        if not (tilt.any() and math.isfinite(self._mounting.height) and hit.any()):
            return scan
        ends = scan.points()
        ends = ends - self._mounting.shifts(ends) @ tilt
        local = scan.robot_from_scan.inverse().apply(ends)
        bearings, ranges = scan.bearings.copy(), scan.ranges.copy()
        bearings[hit], ranges[hit] = heading_angles(local), np.hypot(local[:, 0], local[:, 1])
        return replace(scan, bearings=bearings, ranges=ranges)

    def observe(self, hypothesis: Hypothesis, scan: Scan, odometry: Pose2, spread: float) -> None:
        """Take the heaviest hypothesis after a scan.

        Args:
            hypothesis: where the robot should be.
            scan: that was taken there, as ``corrected``.
            odometry: the robot in the odom frame then.
            spread: share of the cloud that is effective; 1 is a scan that told nothing.
        """
        elapsed = 0.03 if self._stamp is None else max(scan.stamp - self._stamp, 1e-3)
        self._stamp = scan.stamp
        rays = rays_of(scan, BEAMS)
        expected = self._expected(odometry)
        if expected is not None and _is_far(expected, hypothesis.pose):
            self._odometry.begin_anew()
            self._causes.forget()
        # On bent tape a pose that is centimetres off would leave what looks like a tilt.
        pitch, roll = self._camera.applied.tolist()
        laid = self._matcher.match(hypothesis.pose, rays, LOOSE).pose
        sums, used, returned = residual_sums(
            laid.to_array(),
            rays,
            self._evidence.index,
            self._evidence.range_max,
            self._mounting.x,
            self._mounting.height,
            pitch,
            roll,
            self._camera.exactness,
        )
        self._judge_fit(hypothesis.pose, expected, rays)
        self._last = hypothesis.pose, odometry
        # At a wrong place nothing is learnt of the robot.
        trusted = hypothesis.weight > TRUSTED and self._fit > 0 and used > EXPLAINED * returned
        if trusted:
            self._camera.observe(sums, used, elapsed)
            self._odometry.observe(scan.stamp, hypothesis.pose, odometry, hypothesis.covariance)
        else:
            self._odometry.jump()
            self._camera.look(sums)
        findings = Findings(
            scan.stamp,
            elapsed,
            self._odometry.errors,
            self._camera.error,
            returned,
            spread,
            math.sqrt(float(np.trace(hypothesis.covariance[:2, :2]))),
            self._pulled,
        )
        self._causes.judge(findings)
        self._camera.follow()
        self._wheels = _standing_out(findings.odometry)
        if used >= SEEING:
            self._seen = scan.stamp
        if self._causes.alerts:
            self._doubted = scan.stamp
        self.looseness = self._looseness(findings)
        self.lateness = self._lateness(findings.odometry)
        self.doubt = self._doubt(hypothesis.pose, findings)

    def _expected(self, odometry: Pose2) -> Pose2 | None:
        """Where the last pose is by now, by odometry."""
        if self._last is None:
            return None
        pose, before = self._last
        return pose @ self.corrected_step(before.inverse() @ odometry)

    def _judge_fit(self, pose: Pose2, expected: Pose2 | None, rays: Array) -> None:
        seeing = rays[~np.isnan(rays[:, 4])]
        if not len(seeing):
            return
        badly = self._evidence.log_likelihood_anywhere(seeing)
        poses = [pose.to_array()] if expected is None else [pose.to_array(), expected.to_array()]
        better, *before = (self._evidence.log_likelihoods(np.array(poses), seeing) - badly).tolist()
        if better == 0 and not np.isfinite(seeing[:, 3]).any():
            return
        self._fit += FITTING * (min(better, 1.0) - self._fit)
        self._pulled *= 1 - FORGETTING
        for well in before:
            # From a place that did not fit anyway it may be moved anywhere.
            self._pulled += max(min(better - well, 0.0), -MOST_PULLED) if well > 0 else 0.0

    def _looseness(self, findings: Findings) -> float:
        rest = findings.odometry.rest
        least = BLIND if findings.stamp - self._seen > BLIND_AFTER else 1.0
        return min(max(float(max(rest[0], rest[2])) / USUAL, least), LOOSEST)

    def _lateness(self, errors: OdometryErrors) -> float:
        late = errors.value("late")
        wanted = late if abs(late) > LATE_SURE * errors.sd("late") else 0.0
        blended = self.lateness + LATE_BLEND * (wanted - self.lateness)
        return blended if abs(blended) >= LEAST_LATE else 0.0

    def _doubt(self, pose: Pose2, findings: Findings) -> Doubt:
        errors = findings.odometry
        mapped = any(alert.cause is Cause.MAP for alert in self._causes.alerts)
        caused, caused_spread = self._camera.pose_error(SCALE_DOUBTED if mapped else SCALE_SD)
        recently = findings.stamp - self._doubted < DOUBT_KEPT
        known, unknown = pose_errors(
            pose.theta,
            self._odometry.twist.v,
            self._odometry.twist.omega,
            errors.values,
            errors.covariance,
            self.lateness,
            caused,
            caused_spread,
            self._odometry.wiggle if recently else NO_DOUBT.covariance,
        )
        torn = float(errors.rest.max()) > TORN
        return Doubt(known, unknown, self._causes.alerts, self._fit > 0 and not torn)


def _standing_out(errors: OdometryErrors) -> tuple[float, ...]:
    """What is beyond chance of the wheels' errors: forward, turn by way, and turn."""
    values, variances = errors.values[1:4].tolist(), errors.covariance.diagonal()[1:4].tolist()
    return tuple(
        math.copysign(max(abs(value) - math.sqrt(variance), 0.0), value)
        for value, variance in zip(values, variances, strict=True)
    )


def _is_far(expected: Pose2, pose: Pose2) -> bool:
    return expected.distance_to(pose) > JUMP or abs(expected.turn_to(pose)) > JUMP_TURN
