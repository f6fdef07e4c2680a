"""Monitors an estimate: checks whether scans and odometry agree with the models.

Steady errors show in the scans. Significant ones are corrected: the tilt of the camera, the size of
the wheels, the lateness of pictures. The monitor names the likeliest reason for doubt, and says how
far the pose may still be off.

What half and twice of a constant change is said as ``python -m benchmarks.constants`` found it.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from robot.geometry import Array, Pose2, heading_angles, turned_covariance
from robot.localization.estimate import ONLY_PLACE, Cause, Hypothesis
from robot.localization.monitoring.causes import Causes, Findings
from robot.localization.monitoring.doubt import NO_DOUBT, Doubt
from robot.localization.monitoring.fit_check import FitCheck
from robot.localization.monitoring.mounting_check import HELD, LASER, CameraPosition, MountingCheck
from robot.localization.monitoring.odometry_check import OdometryCheck, OdometryErrors
from robot.localization.monitoring.scan_residuals import GATE, residual_sums
from robot.localization.monitoring.slip_check import SLIPS, SPREADS, SlipCheck
from robot.localization.monitoring.steady_errors import SteadyErrors, pose_errors
from robot.localization.ray_evidence import RayEvidence, ends_of_seen
from robot.localization.scan_matching import SLOPE, ScanMatcher
from robot.scan import Scan, rays_of

BEAMS = 91
"""Rays of a scan that are checked."""
LAID_SD = 0.0003
"""Spread of a near range with which a scan is laid on the edges before it is checked [m]."""
EXPLAINED = 0.6
"""The only place must explain more than this share of the returns, for errors of the robot to be
learnt there. With 0.3 or 0.8 nothing changes beyond chance."""
TORN = 2.5
"""Wheels slip, or the robot was carried off, if steps differ from odometry by more spreads. Of
pictures 30.5 % are certain and 0.7 % misleading; half: 29.8 and 0.6; twice: 33.5 and 0.8."""
JUMP, JUMP_TURN = 0.04, 0.2
"""A pose farther than this from the one that odometry predicts is another place [m], [rad]. Half
and twice the distance: nothing changes beyond chance."""
JOLT, JOLT_TURN = 0.006, 0.015
"""A pose that leaves the one predicted by odometry between two pictures by more than this, and its
spread, slipping wheels and another view explain, contradicts odometry [m], [rad]. Half of JOLT:
found again after 1.3 s instead of 1.1; twice: nothing changes of robots that begin scattered, but
one that knew its place is certain of another for 1.3 s (``--few``; *stub*, seed 9001). Half of
JOLT_TURN: 22 of 45 000 pictures by robots that know their place contradict (twelve conditions,
seeds 24000 and 24001), and as it is none; twice: one that was carried to a place that looks the
same is certain there for 1.3 s (*town*, seed 308)."""
SWAY = 0.05
"""Lateness of pictures, 1 sd, that is reckoned with while steps differ from odometry in heading
only, now this way and now that [s]: some pictures may come late, or wheels slip as it turns. Half
and twice: 99.5 and 98.8 % certain instead of 99.1 of a robot that drives to goals, and none
misleads (``evaluate navigation --map town --seeds 1 --first-seed 7710 --goals 10``, which stood for
0.25 s at each goal); with no bound at all 82.6 %."""
NARROWS = 0.5
"""The variances of a pose that a step is judged by fall to no less than this share from one picture
to the next: a pose that few rays of one picture made exact is not that sure yet. Half: nothing
changes; twice, so that they never fall: 99 % of the errors within 40 instead of 38 mm."""
TURN_SLIPS = 0.2
"""Share of a turn that slipping wheels explain, as long as wheels hardly slipped before. Half:
nothing changes; twice: while pictures come 90 ms late all at once, 26 % are certain and wrong."""
LOOSEST = 4.0
"""Largest factor on odometry's standard deviations. Half: 99 % of the errors within 42 instead of
46 mm, and the rest, as with twice, unchanged beyond chance."""
USUAL = 1.5
"""Steps that differ from odometry by no more than this many spreads are usual. Half: misleading in
1.0 % of pictures instead of 0.7; twice: nothing changes beyond chance."""
SEEING, BLIND_AFTER, BLIND = 6, 0.3, 2.5
"""If fewer than SEEING rays lie on edges for longer than BLIND_AFTER [s], steps add up unseen. Then
they err BLIND times as much as each step alone, because slip lasts for about a second, and wheels
are never exactly as drawn. Half and twice of BLIND: nothing changes beyond chance. Half of SEEING:
no claim changes; twice: nothing changes beyond chance (``--few``)."""
HIDDEN = 2.0
"""Factor on the variance of errors that cannot be excluded, while slip, or another error that is
told, hides them. Half: with all errors at once (``slip_check.py``) 0.9 % are certain and wrong, not
0.1; twice: 90.7 % certain on a slippery floor instead of 96.5."""
LAID = np.diag(np.square([0.010, 0.010, 0.020]))
"""Covariance of where tape lies that somebody laid by hand, and of its direction, which counts
from a step that does not fit the map as usual on [m², m², rad²]. Half of these deviations: on *tee*
(hand-laid, seed 15500) 4 % are certain and wrong, for 0.7 s, and not none (6 % without it); twice:
15 % are certain, not 56."""
REFUTED = 60
"""After this many usual steps, tape lies where it is drawn. With none 0.64 % are certain and wrong
on floors that are 3 % smaller, not 0.13; half and twice: nothing changes beyond chance (``brickpose
evaluate integrity --map square tee stub town --start known --condition enlarged shrunk --first-seed
24600 --seeds 2 --laps 1``)."""
SAME_TILT = math.radians(0.03)
"""Tilts that differ by less [rad] shift a pose by less than scans do."""
LEAST_LATE = 0.001
"""A smaller lateness is not corrected [s]. Half and twice: the median error is the same."""
LATE_SURE, LATE_BLEND = 3.0, 0.1
"""Lateness is corrected above this many standard deviations, by this share of a change per scan.
Half of LATE_SURE: the median error is 1.8 mm instead of 1.4; twice: 1.5. Half and twice of
LATE_BLEND: 1.5 and 1.4."""


class Monitor:
    """Checks each estimate, together with the scan that it was made from."""

    def __init__(
        self,
        evidence: RayEvidence,
        mounting: CameraPosition = LASER,
        errors: SteadyErrors = SteadyErrors(),
        *,
        model_suspected: bool = True,
    ) -> None:
        """Make a monitor of a robot of which nothing was seen yet.

        Args:
            evidence: judges how well scans fit.
            errors: how large the robot's steady errors may be.
            model_suspected: as ``use`` takes it.
        """
        self._fit = FitCheck()
        self.use(evidence, model_suspected=model_suspected)
        self._mounting = mounting
        self._errors = errors
        self._measured = np.diag(errors.measured**2)
        """Covariance (3, 3) of what a calibration leaves open, along the robot's axes."""
        self._causes = Causes()
        self._camera = MountingCheck(errors)
        self._stamp: float | None = None
        self._seen = -math.inf
        """Stamp at which edges were last seen [s]."""
        self._slip = SlipCheck()
        self.of_clearing = np.zeros((3, 3))
        """By how much the newest scan may lead elsewhere, as it was cleared [m², m², rad²]."""
        self.forget()

    def forget(self) -> None:
        """Forget the robot's errors and the steps so far: what was seen has another reason."""
        self._odometry = OdometryCheck(self._errors)
        self._camera.forget()
        self._due = 0
        """How many usual steps are due until tape lies where it is drawn."""
        self._tilt_of_steps = np.zeros(2)
        """Pitch and roll [rad] that were taken off the scans of the steps compared."""
        self.lateness = 0.0
        """How much later pictures seem to be stamped than they were taken [s]."""
        self._wheels: tuple[float, ...] = (0.0, 0.0, 0.0)
        """Apparent errors of odometry: forward [-], turn by distance [rad/m], and turn [-]."""
        self.looseness = 1.0
        """Factor on odometry's usual standard deviations."""
        self.restart()

    def restart(self) -> None:
        """Restart at another given pose: keep the robot's errors, and drop the steps so far."""
        self._odometry.restart()
        self._fit.restart()
        self._slip.restart()
        self._last: tuple[Hypothesis, Pose2] | None = None
        """Hypothesis and odometry of the last scan."""
        self._variances = np.zeros(3)
        """Variances of the last poses, which narrow by and by [m², m², rad²]."""
        self._torn = self.slips = self._sways = False
        """Whether the steps of the pose do not agree with odometry; whether it is slip; and whether
        they differ in heading only, and do not last."""
        self.contradicted = False
        """Whether the newest pose is where neither odometry nor slipping wheels can have led."""
        self._causes.forget()
        self.doubt = NO_DOUBT

    def use(self, evidence: RayEvidence, *, model_suspected: bool = True) -> None:
        """Switch to the evidence of other parameters.

        Args:
            evidence: judges how well scans fit.
            model_suspected: whether the sensor model may be the cause of an error; one of ours with
                its usual parameters is not.
        """
        self._evidence, self._model_suspected = evidence, model_suspected
        self._matcher = ScanMatcher(evidence.edge_index, evidence.range_max, LAID_SD, GATE, SLOPE)

    def compensate_lateness(self, hypothesis: Hypothesis) -> Hypothesis:
        """Return the hypothesis at the scan's stamp, if its picture was taken earlier."""
        if self.lateness == 0.0:
            return hypothesis
        return replace(
            hypothesis, pose=hypothesis.pose @ self._odometry.twist.integrate(self.lateness)
        )

    @property
    def may_be_late(self) -> bool:
        """Whether pictures may be later or earlier than before: no wheels that slip explain it."""
        return not self.slips and self._odometry.agrees

    def doubt_lateness(self) -> None:
        """Let pictures be later or earlier than before, unless wheels that slip explain it."""
        if self.may_be_late:
            self._odometry.jump()
            self._odometry.doubt_lateness()

    def corrected_step(self, moved: Pose2) -> Pose2:
        """Return a step by odometry, corrected by the apparent errors of the wheels."""
        forward, turn_by_way, turn = self._wheels
        theta = moved.theta * (1 + turn) + moved.x * turn_by_way
        target = Pose2(theta=0.5 * (theta - moved.theta)) @ Pose2(moved.x, moved.y)
        return Pose2((1 + forward) * target.x, (1 + forward) * target.y, theta)

    def corrected(self, scan: Scan) -> Scan:
        """Return a scan, corrected by the apparent tilt of the camera."""
        tilt, hit = self._camera.applied, scan.hit
        if not (tilt.any() and math.isfinite(self._mounting.height) and hit.any()):
            return scan
        ends = scan.points()
        ends = ends - self._mounting.shifts(ends) @ tilt
        local = scan.robot_from_scan.inverse().apply(ends)
        bearings, ranges = scan.bearings.copy(), scan.ranges.copy()
        bearings[hit], ranges[hit] = heading_angles(local), np.hypot(local[:, 0], local[:, 1])
        return replace(scan, bearings=bearings, ranges=ranges)

    def on_seen_floor(self, scan: Scan, pose: Pose2) -> Scan:
        """Return a scan without what unseen floor returned, which may fit elsewhere by chance."""
        rays = rays_of(scan, len(scan.ranges))
        return scan.until(ends_of_seen(pose.to_array(), rays, self._evidence))

    def observe(self, hypothesis: Hypothesis, scan: Scan, odometry: Pose2, spread: float) -> None:
        """Check the heaviest hypothesis after a scan.

        Args:
            hypothesis: where the robot should be.
            scan: the scan that was taken there, as ``corrected`` returns it.
            odometry: the robot in the odom frame at the scan's stamp.
            spread: share of the cloud that is effective; 1 if the scan gave no information.
        """
        elapsed = 0.03 if self._stamp is None else max(scan.stamp - self._stamp, 1e-3)
        self._stamp = scan.stamp
        rays = rays_of(scan, BEAMS)
        expected = self._expected(odometry)
        # On bent tape, the residuals of a pose that is centimetres off would look like a tilt.
        pitch, roll = self._camera.applied.tolist()
        laid = self._matcher.match(hypothesis.pose, rays, HELD)
        sums, used, returned = residual_sums(
            laid.pose.to_array(),
            rays,
            self._evidence.edge_index,
            self._evidence.range_max,
            self._mounting.x,
            self._mounting.height,
            pitch,
            roll,
            self._camera.exactness,
        )
        far = expected is not None and _is_far(expected, hypothesis.pose)
        # A pose sways by which hardly any edges are seen.
        view = self._camera.view_variance(sums)
        covariance = hypothesis.covariance + self.of_clearing
        unsure = self._variances + covariance.diagonal()
        unsure[:2] += 0.5 * view
        self.contradicted = used > 2 * SEEING and self._contradicts(expected, hypothesis, unsure)
        leapt = far or self.contradicted
        if leapt:
            self._odometry.restart()
            self._odometry.doubt_lateness()
            self._slip.restart()
            self._causes.forget()
        if self._last is not None and expected is not None and not leapt:
            moved, offset = self._last[1].inverse() @ odometry, expected.inverse() @ hypothesis.pose
            self._slip.observe(hypothesis.pose, moved, offset, laid.information - HELD, elapsed)
        self._fit.observe(self._evidence, rays, hypothesis.pose, expected)
        self._last = hypothesis, odometry
        self._variances = np.maximum(covariance.diagonal(), NARROWS * self._variances)
        earlier = self._odometry.errors
        # At a wrong place, nothing can be learnt about the robot's errors.
        trusted = hypothesis.weight > ONLY_PLACE and self._fit.fits and used > EXPLAINED * returned
        if trusted:
            self._camera.observe(sums, used, elapsed)
            self._odometry.observe(scan.stamp, hypothesis.pose, odometry, covariance)
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
            math.sqrt(hypothesis.covariance[0, 0] + hypothesis.covariance[1, 1]),
            scan.stamp - self._odometry.stuck_at,
            self._fit.change,
            self._model_suspected,
        )
        self._causes.judge(findings)
        self._follow_tilt()
        self._wheels = findings.odometry.of_wheels
        if used >= SEEING:
            self._seen = scan.stamp
        self.looseness = self._looseness(findings)
        self.lateness = self._lateness(findings.odometry)
        rest = findings.odometry.rest
        self._torn = float(rest.max()) > TORN
        self.slips = self._slip.explains(rest, TORN)
        if findings.odometry is not earlier:
            self._try_map(usual=float(rest[:2].max()) <= USUAL)
        self._sways = self._torn and not self.slips and float(rest[:2].max()) < USUAL
        self.doubt = self._doubt(hypothesis.pose, findings)

    def watch(self, pose: Pose2, scan: Scan) -> bool:
        """Judge what is seen while the robot stands, when no scan is due: it may be carried off.

        Args:
            pose: the robot in the map.
            scan: the scan that was taken there, as ``corrected`` returns it.

        Returns:
            Whether the last scans fit.
        """
        self._fit.observe(self._evidence, rays_of(scan, BEAMS), pose)
        self.doubt = replace(self.doubt, fits=self._agrees)
        return self._fit.fits

    @property
    def fits_clearly(self) -> bool:
        """Whether not even the newest scan gives reason to look again."""
        return self._fit.fits_clearly

    @property
    def newest_fits(self) -> bool:
        """Whether the newest scan fits where the robot should be."""
        return self._fit.newest_fits

    def _follow_tilt(self) -> None:
        """Take a tilt off the next scans, and compare steps anew when it changes.

        Otherwise the pose's shift by the other tilt would look like latency of the pictures.
        """
        self._camera.follow()
        if np.abs(self._camera.applied - self._tilt_of_steps).max() > SAME_TILT:
            self._tilt_of_steps = self._camera.applied
            self._odometry.jump()

    def _expected(self, odometry: Pose2) -> Pose2 | None:
        """Return the last pose, moved on by odometry; None without a last pose."""
        if self._last is None:
            return None
        last, before = self._last
        return last.pose @ self.corrected_step(before.inverse() @ odometry)

    def _contradicts(self, expected: Pose2 | None, hypothesis: Hypothesis, unsure: Array) -> bool:
        """Return whether neither odometry, slip nor another view leads to where it should be."""
        if expected is None or self._last is None or not self._odometry.settled:
            return False
        last = self._last[0].pose
        moved, offset = last.inverse() @ expected, expected.inverse() @ hypothesis.pose
        way = SLIPS * math.hypot(moved.x, moved.y) + SPREADS * math.sqrt(unsure[:2].sum())
        # Wheels that slip already may turn the robot by more from one picture to the next.
        loose = max(float(self._odometry.errors.rest[2]), 1.0)
        turn = min(TURN_SLIPS * loose, SLIPS) * abs(moved.theta) + SPREADS * math.sqrt(unsure[2])
        jolt = JOLT_TURN * loose
        return math.hypot(offset.x, offset.y) > JOLT + way or abs(offset.theta) > jolt + turn

    def _try_map(self, *, usual: bool) -> None:
        """Let a step tell whether tape lies where it is drawn, and the floor is as large."""
        if not (usual or self.slips):
            self._due = REFUTED
        elif self._due:
            self._due -= 1
        elif self._odometry.settled and (self.slips or not self._torn):
            self._camera.try_scale()

    def _looseness(self, findings: Findings) -> float:
        if self._odometry.standing > 0:
            return LOOSEST
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
        caused = self._camera.pose_error(map_doubted=mapped)
        motion = pose.theta, self._odometry.twist.v, self._odometry.twist.omega
        known, unknown = pose_errors(
            *motion, errors.values, errors.covariance, self.lateness, *caused
        )
        known = known + turned_covariance(self._measured, pose.theta)
        if self.slips or self._causes.alerts:
            unknown = HIDDEN * unknown
        unknown = unknown + self.of_clearing
        if self.slips:
            unknown = unknown + self._slip.covariance
        elif mapped or self._due:
            unknown = unknown + LAID
        if self._sways:
            late = pose.to_array() - (pose @ self._odometry.twist.integrate(-SWAY)).to_array()
            late[2] = SWAY * self._odometry.twist.omega
            unknown = unknown + np.outer(late, late)
        return Doubt(known, unknown, self._causes.alerts, self._agrees)

    @property
    def _agrees(self) -> bool:
        """Whether the last scans fit, and it is known how far steps may differ from odometry."""
        return self._fit.fits and (self.slips or self._sways or not self._torn)


def _is_far(expected: Pose2, pose: Pose2) -> bool:
    return expected.distance_to(pose) > JUMP or abs(expected.turn_to(pose)) > JUMP_TURN
