"""Follows a robot's calibration while it drives: small drifts, and a camera that was bumped.

Every few seconds the last ones are measured again (``drift``). What has drifted a little is learnt,
with all that was known before. A camera that has moved is told, and measured from the seconds that
follow; its path is followed on, as the filter may have lost it.
"""

from __future__ import annotations

import itertools
import math
from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np

from robot.calibration.drift import (
    MOVED,
    SHIFTED_MOST,
    DriftCheck,
    DriftFinding,
    Known,
)
from robot.calibration.drive_log import DriveLog, DriveRecorder
from robot.calibration.start_poses import entry_table
from robot.description.spec import RobotSpec
from robot.description.unknowns import COUNT, NAMES, PRIORS, ROBOT, Differences
from robot.fields.field import Field
from robot.geometry import Array, Pose2
from robot.interface import Reading
from robot.scanning.settings import LineScannerSettings

PERIOD_S, STEP = 0.2, 0.05
"""Least time between two pictures that are used [s], and least turn of a wheel [rad]."""
WINDOW, CHECK = 25, 9
"""Pictures of a window, and new ones between two checks: 5 and 1.8 s of driving."""
MEASURED = (25, 50, 75)
"""A camera that has moved is measured from this many pictures, the fewest first: each time
better."""
MEMORY_S = 60.0
"""Pictures and wheels older than this are forgotten [s]: the robot may have stood in between."""
SUSPECT = 11.3
"""Square of a shift by its covariance from which on a window teaches nothing: one of a hundred
exceeds it by chance."""
JUMP, JUMP_TURN = 0.02, 0.1
"""A pose that differs by more from what the wheels say since the last one has jumped [m, rad]."""
ENDS = (12, 6)
"""Pictures at the end of a window that are looked at alone: the camera may be bumped within it."""
UNUSUAL, BLEND = 1.4, 0.2
"""Edges of such a window lie farther off than usual by this factor; the share of what is usual that
is learnt from one window."""
DRAWN_SD = np.array([0.002, 0.002, 0.002, 5e-4, 5e-4, 5e-4, 0.003, 0.002, 0.02, 0.02, 0.02])
"""How well a robot is taken to be as drawn, if nobody calibrated it."""
DRIFT_SD = np.array([2e-4, 2e-4, 2e-4, 5e-5, 5e-5, 5e-5, 0, 5e-4, 0.002, 0.002, 0.002, 0, 0, 0, 0])
"""How far the unknowns drift in a minute."""
NOTICEABLE = np.array([3e-4, 3e-4, 3e-4, 1e-4, 2e-4, 1e-4, 5e-4, 5e-4, 0.005, 0.005, 0.005])
"""A drift is taken over when one of them exceeds this: it moves the robot by 0.1 mm or so."""
DIRECTIONS = (
    ("more tilted to the left", "more tilted to the right"),
    ("higher", "lower"),
    ("further to the right", "further to the left"),
)
"""How a camera looks that is turned about the robot's axes, by less and more than zero."""
Job = Callable[[], DriftFinding | None]


@dataclass(frozen=True, slots=True, eq=False)
class TrackedPicture:
    """What one picture saw, and where the filter believed the robot to be."""

    stamp: float
    pixels: Array
    pose: Pose2 | None
    """None if the filter did not know one place."""
    odom_from_robot: Pose2


@dataclass(frozen=True, eq=False)
class Update:
    """What is to be taken over."""

    values: dict[str, float]
    """Differences by name."""
    sd: dict[str, float]
    pose: Pose2
    """Of the robot in the map, at the last picture's stamp."""
    covariance: Array = field(repr=False)
    """(3, 3) of it."""
    odom_from_robot: Pose2
    """Odometry at that stamp."""


class CalibrationTracker:
    """Follows one robot on one field; ``job`` is the work, which any thread may do."""

    def __init__(self, spec: RobotSpec, taped: Field, settings: LineScannerSettings) -> None:
        """Follow a robot from its profile, or from its drawing if it has none."""
        self._check = DriftCheck(spec.uncalibrated, taped, entry_table(taped))
        self._recorder = DriveRecorder(spec, settings, taped.tape)
        self._axle = list(spec.axle)
        self._pictures: deque[TrackedPicture] = deque()
        self._wheels: deque[tuple[float, Array]] = deque()
        self._fresh = 0
        """Pictures since the last check."""
        self._path: dict[float, Array] = {}
        """Poses by stamp, as the last window that fitted had them."""
        self._learnt_until = -math.inf
        self._usual = 1.0
        """Residual of most windows, in the deviations that are expected."""
        self._moved_at: float | None = None
        """Stamp of the last picture before those from which a moved camera is measured."""
        self._working: tuple[TrackedPicture, ...] = ()
        """The window of the job that was given out."""
        self.remark = ""
        """What was found of the camera, in plain words; empty if it is as calibrated."""
        self.begin(spec)

    def begin(self, spec: RobotSpec) -> None:
        """Follow from another calibration."""
        sd = PRIORS.copy()
        sd[:ROBOT] = DRAWN_SD if spec.measured_sd is None else spec.measured_sd
        values = np.zeros(COUNT)
        values[:ROBOT] = Differences.of(spec).values
        self._known = self._before = Known(values, np.diag(np.square(sd)))
        self._applied = values[:ROBOT].copy()
        self._moved_at, self.remark = None, ""
        self.forget()

    def forget(self) -> None:
        """Forget the last seconds: the robot was put elsewhere."""
        self._pictures.clear()
        self._path.clear()
        self._working, self._fresh = (), 0

    def is_of(self, spec: RobotSpec) -> bool:
        """Return whether a robot's calibration is the one that was given out last."""
        return bool(np.allclose(Differences.of(spec).values, self._applied, atol=1e-9))

    def add(self, reading: Reading, pose: Pose2 | None, odom_from_robot: Pose2 | None) -> None:
        """Add a reading, with the filter's pose and odometry's at the exposure of its picture."""
        self._wheels.append((reading.stamp, reading.positions[self._axle]))
        earliest = reading.stamp - MEMORY_S
        while self._wheels[0][0] < earliest:
            self._wheels.popleft()
        frame = reading.frame
        if frame is None or odom_from_robot is None or not self._is_due(frame.stamp):
            return
        pixels = self._recorder.edges(frame.image)
        self._pictures.append(TrackedPicture(frame.stamp, pixels, pose, odom_from_robot))
        self._fresh += 1
        while len(self._pictures) > MEASURED[-1] or self._pictures[0].stamp < earliest:
            self._pictures.popleft()

    def _is_due(self, stamp: float) -> bool:
        """Return whether a picture tells something new: the robot stood if it moved too little."""
        if not self._pictures:
            return True
        last = self._pictures[-1].stamp
        if stamp - last < PERIOD_S - 1e-6:
            return False
        before = next((angles for when, angles in reversed(self._wheels) if when <= last), None)
        return before is None or bool(np.abs(self._wheels[-1][1] - before).max() >= STEP)

    def job(self) -> Job | None:
        """Return work to be done, if there is any; ``take`` gets its result."""
        if self._moved_at is not None:
            return self._measuring(self._moved_at)
        window = tuple(self._pictures)[-WINDOW:]
        if self._fresh < CHECK or len(window) < 2 * CHECK:
            return None
        self._fresh, self._working = 0, window
        log, known, path = self._log(window), self._known, dict(self._path)
        usual = UNUSUAL * self._usual
        return lambda: self._checked(window, log, known, path, usual)

    def _measuring(self, moved_at: float) -> Job | None:
        window = tuple(picture for picture in self._pictures if picture.stamp >= moved_at)
        wanted = next((count for count in MEASURED if count > len(self._working)), None)
        if wanted is None or len(window) < wanted:
            return None
        self._working = window = window[:wanted]
        log, known, start = self._log(window), self._before, self._path[moved_at]
        return lambda: self._check.measure(log, start, known, SHIFTED_MOST)

    def _checked(
        self,
        window: tuple[TrackedPicture, ...],
        log: DriveLog,
        known: Known,
        path: dict[float, Array],
        usual: float,
    ) -> DriftFinding | None:
        """Return what a window says; None if nothing fits.

        In a window without a bump, the edges lie not farther off than ``usual``, in deviations.
        """
        if _is_smooth(window):
            poses = np.array([p.pose.to_array() for p in window if p.pose is not None])
            finding = self._check.check(log, poses, known)
            if finding is not None and finding.fits and finding.significance <= SUSPECT:
                return finding
        first = next((k for k, p in enumerate(window) if p.stamp in path or p.pose), len(window))
        if len(window) - first < CHECK:
            return None
        begin = window[first]
        start = path[begin.stamp] if begin.pose is None else begin.pose.to_array()
        finding = self._check.measure(log.since(first), start, known)
        if finding is None or (finding.fits and finding.significance <= MOVED):
            return finding
        # If the camera was bumped within the window, only its end fits as windows usually do.
        findings = [finding]
        for count in ENDS:
            if findings[-1].residual > usual:
                end = log.since(len(window) - count)
                newest = self._check.measure(end, finding.poses[-count], known)
                findings += [] if newest is None else [newest]
        return min(findings, key=lambda each: each.residual)

    def take(self, finding: DriftFinding | None) -> Update | None:
        """Take the result of a job; return what is to be taken over."""
        window, count = self._working, 0 if finding is None else len(finding.poses)
        if finding is None or not finding.fits or not window:
            if self._moved_at is None or len(window) >= MEASURED[-1]:
                self._moved_at = None
                self._path.clear()
            return None
        if self._moved_at is None:
            stamps = [picture.stamp for picture in window[-count:]]
            self._path = dict(zip(stamps, finding.poses, strict=True))
            if finding.significance > MOVED:
                self._moved_at, self._before = stamps[-1], self._known
                self._working, self.remark = (), camera_remark(finding.shift)
                return None
            if finding.significance > SUSPECT:
                return None
            self.remark = ""  # of a bump that could not be measured, and was none
            return self._learn(finding, stamps)
        self._known = finding.loose
        self.remark = camera_remark(finding.shift)
        if len(window) == MEASURED[-1]:
            stamps = [picture.stamp for picture in window]
            self._path = dict(zip(stamps, finding.poses, strict=True))
            self._moved_at, self._learnt_until, self.remark = None, stamps[-1], ""
        return self._update(finding, window)

    def _learn(self, finding: DriftFinding, stamps: list[float]) -> Update | None:
        """Learn a drift from a window, if none of it was learnt from before."""
        if stamps[0] < self._learnt_until:
            return None
        self._usual += BLEND * (finding.residual - self._usual)
        tight, drift = finding.tight, DRIFT_SD**2 * (stamps[-1] - stamps[0]) / 60
        self._known = Known(tight.values, tight.covariance + np.diag(drift))
        self._learnt_until = stamps[-1]
        changed = np.abs(self._known.values[:ROBOT] - self._applied)
        return self._update(finding, self._working) if (changed > NOTICEABLE).any() else None

    def _update(self, finding: DriftFinding, window: Sequence[TrackedPicture]) -> Update:
        self._applied = self._known.values[:ROBOT].copy()
        sd = np.sqrt(np.diag(self._known.covariance))[:ROBOT]
        return Update(
            dict(zip(NAMES, self._applied.tolist(), strict=False)),
            dict(zip(NAMES, sd.tolist(), strict=False)),
            Pose2.from_array(finding.poses[-1]),
            finding.pose_covariance,
            window[-1].odom_from_robot,
        )

    def _log(self, window: Sequence[TrackedPicture]) -> DriveLog:
        begin = window[0].stamp - 0.5
        wheels = [(stamp, angles) for stamp, angles in self._wheels if stamp >= begin]
        return DriveLog(
            np.array([picture.stamp for picture in window]),
            np.array([picture.pixels for picture in window]),
            np.array([stamp for stamp, _ in wheels]),
            np.array([angles for _, angles in wheels]),
        )


def _is_smooth(window: Sequence[TrackedPicture]) -> bool:
    """Return whether the filter knew each pose, and none jumped."""
    for before, after in itertools.pairwise(window):
        if before.pose is None or after.pose is None:
            return False
        rolled = before.odom_from_robot.inverse() @ after.odom_from_robot
        expected = before.pose @ rolled
        if expected.distance_to(after.pose) > JUMP or abs(expected.turn_to(after.pose)) > JUMP_TURN:
            return False
    return True


def camera_remark(shift: Array) -> str:
    """Return how a camera is turned against its calibration, by rotation (3,) [rad], in words."""
    axis = int(np.argmax(np.abs(shift)))
    direction = DIRECTIONS[axis][int(shift[axis] > 0)]
    return f"the camera looks {abs(math.degrees(shift[axis])):.1f}° {direction} than calibrated"
