"""Finds the path of a drive in windows that grow, from where it may have begun.

First the path is not known, and the camera may be degrees askew: then every adjustment of the whole
drive ends in a wrong place. So the drive is adjusted in windows that grow. In each, the path is
followed a little farther with what is known by then, and all of it is adjusted again.
"""

from __future__ import annotations

from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from robot.calibration.adjustment import (
    Adjustment,
    CalibrationError,
    DriveEstimate,
    Solution,
    Weights,
    residual_sd,
)
from robot.calibration.camera_from_tape import Guess, camera_from_tape
from robot.calibration.drive_log import DriveLog
from robot.calibration.model_check import remarks
from robot.calibration.sightings import Sightings
from robot.calibration.start_poses import SECONDS, alike, entry_table, start_poses
from robot.calibration.tracking import follow_path
from robot.calibration.wheel_motion import WheelMotion
from robot.calibration.window_weights import window_weights
from robot.description.spec import RobotSpec
from robot.description.unknowns import COUNT
from robot.fields.field import Field
from robot.geometry import Array, Pose2
from robot.localization.models.entry_field import EntryField

WINDOWS = (2.0, 3.5, 6.0, 10.0, 16.0, 26.0, 42.0, 70.0, 120.0, 200.0, 350.0, 600.0)
"""Lengths of the drive's beginning that are adjusted one after the other [s]."""
BEGINNING_S = 6.0
"""How far the drive is followed from each pose where it may have begun [s]."""
CLEARLY = 40.0
"""A start fits better than another one if its cost is lower by this."""
FEW = 10
"""Iterations of an adjustment that begins at the solution, but from another start."""
LEAST_SEEN, FAR_OFF = 0.7, 3.0
"""A path fits if at least the first, a share of the edges that were seen, lies on the field's, and
they lie at most the second times as far off as expected."""
TOGETHER, ENOUGH, LEAST_LYING = 10, 100, 0.5
"""A path is lost where this many pictures saw at least this many edges, and less than this share of
them lies on the field's, ..."""
MOST_SLIP = 0.3
"""... or where a wheel would have slipped more than this, a share: seven of ``SLIP_SD``."""
UNSEEN = 20
"""No tape was in sight if so many pictures saw fewer edges than that together."""


class FieldDrive:
    """A drive on a field, and what the tape tells of the camera."""

    def __init__(self, log: DriveLog, spec: RobotSpec, taped: Field) -> None:
        self.stamps = log.stamps - log.stamps[0]
        """(k,) time since the first picture [s]."""
        self.field, self.lens = taped, spec.lens
        self._log, self._spec = log, spec
        self._seen = Sightings.of(log, spec, taped)

    @cached_property
    def guess(self) -> Guess:
        """What the tape tells of the camera."""
        if self.field.tape_width is None or len({tape.width for tape in self.field.tape}) > 1:
            return Guess()  # which edge is of which width, nobody knows yet
        twists = WheelMotion.of(self._log, self._spec).twists(np.zeros(COUNT))
        return camera_from_tape(self._seen, twists, self.field.tape_width)

    @property
    def edge_counts(self) -> NDArray[np.int64]:
        """(k,) how many edges each picture saw."""
        counts: NDArray[np.int64] = np.isfinite(self._log.pixels[:, :, 0]).sum(axis=1)
        return counts

    @cached_property
    def entries(self) -> EntryField:
        """The field, for edges to be laid on."""
        return entry_table(self.field)

    def window(self, count: int) -> tuple[Sightings, WheelMotion]:
        """Return the first pictures, and the wheels between them."""
        return self._seen.part(0, count), WheelMotion.of(self._log.until(count), self._spec)

    def start_poses(self, given_pose: Pose2) -> list[Pose2]:
        """Return where the drive may have begun, the likeliest pose first."""
        seen, motion = self.window(int(np.searchsorted(self.stamps, SECONDS)))
        values = self.guess.values
        steps, _ = motion.steps(values, np.zeros((len(motion.stamps) - 1, 2)))
        floor = seen.floor_points(values, motion.twists(values))
        return start_poses(floor, steps, self.field, self.entries, given_pose)


class DrivePath:
    """A drive's path from one start, as far as it was followed."""

    solution: Solution
    """Of the longest window so far."""

    def __init__(self, drive: FieldDrive, start: Pose2, start_covariance: Array) -> None:
        """Begin at a pose, with its covariance (3, 3) [m, m, rad]."""
        self._drive, self._start = drive, start.to_array()
        self._start_covariance = start_covariance
        self._covariance = start_covariance
        self._state = DriveEstimate(
            drive.guess.values.copy(), self._start[None].copy(), np.zeros((1, 2))
        )
        self._adjustment: Adjustment | None = None

    @property
    def seconds(self) -> float:
        """How much of the drive was followed [s]."""
        return float(self._drive.stamps[len(self._state.poses) - 1])

    @property
    def whole(self) -> bool:
        """Whether all of the drive was followed."""
        return len(self._state.poses) == len(self._drive.stamps)

    @property
    def start(self) -> Pose2:
        """Where the drive began, as far as it is known."""
        return Pose2(*self._state.poses[0].tolist())

    @property
    def fits(self) -> bool:
        """Whether the edges that were seen lie on the field's."""
        return _fits(self.solution)

    @property
    def lost_at(self) -> int | None:
        """At which picture the path seems to be wrong first; None if at none.

        That is where most edges lie off the field's, or the wheels had to slip too much. Edges that
        lie too near to the end of a field's edge say nothing; on a curve, which is many short
        edges, that is half of all.
        """
        state, seen = self.solution.state, self.solution.misses
        counting = self._drive.edge_counts[: len(state.poses)] - seen.near_ends
        lying = np.bincount(seen.picture, minlength=len(counting))
        sums = [np.convolve(edges, np.ones(TOGETHER), "same") for edges in (counting, lying)]
        wrong = (sums[0] >= ENOUGH) & (sums[1] < LEAST_LYING * sums[0])
        wrong |= self._slips
        return int(np.argmax(wrong)) if wrong.any() else None

    @property
    def _slips(self) -> NDArray[np.bool_]:
        """(k,) where the wheels had to slip too much."""
        slips: NDArray[np.bool_] = np.abs(self.solution.state.slip).max(axis=1) > MOST_SLIP
        return slips

    def require_whole(self) -> None:
        """Refuse a path that is wrong somewhere.

        Raises:
            CalibrationError: says when, and why.
        """
        first = self.lost_at
        if first is None:
            return
        seconds = self._drive.stamps[first]
        if self._slips[first]:
            raise CalibrationError(
                f"at {seconds:.0f} s pictures and wheels disagree on how the robot moved: it was "
                "moved by hand, or a wheel slipped; valid is a drive that ends before, or a new one"
            )
        if self._drive.edge_counts[max(0, first - UNSEEN) : first].sum() < UNSEEN:
            raise CalibrationError(
                f"after {seconds:.0f} s its path is lost, as the robot saw no tape before; valid "
                "is a shorter drive"
            )
        raise CalibrationError(
            f"after {seconds:.0f} s most of the edges that were seen lie off the field's: the "
            "robot was moved by hand, or there is tape that is not drawn; valid is a shorter drive"
        )

    def grow(self, window: float) -> None:
        """Follow the drive to a time after its first picture [s], and adjust all of it.

        Raises:
            CalibrationError: nothing explains the drive from this start.
        """
        first = self._adjustment is None
        part, motion = self._drive.window(int(np.searchsorted(self._drive.stamps, window)))
        state = follow_path(
            self._state, self._covariance, part, motion, self._drive.entries, first=first
        )
        self._adjustment = Adjustment(part, motion, self._start, self._start_covariance)
        for weights in window_weights(window, self._drive.guess):
            self.solution = self._adjustment.solve(state, weights)
            state = self.solution.state
        self._state, self._covariance = state, self.solution.pose_covariance

    @property
    def remarks(self) -> tuple[str, ...]:
        """What seems to be wrong with the field or the lens file."""
        assert self._adjustment is not None
        drive = self._drive
        return remarks(self._adjustment, self.solution, Weights(), drive.field, drive.lens)

    def compare_starts(self) -> tuple[Pose2, ...]:
        """Move to another start if all of the drive fits clearly better from there.

        The beginning of a drive may look the same from several places; marks that were seen later
        distinguish them.

        Returns:
            The other starts from which it fits as well.
        """
        images = [image @ self.start for image in (Pose2(), *self._drive.field.symmetries)]
        others = [
            (start, other)
            for start in self._drive.start_poses(self.start)
            if not any(alike(start, image) for image in images)
            and (other := self._moved_to(start)) is not None
        ]
        if not others:
            return ()
        start, best = min(others, key=lambda each: each[1].cost)
        if best.cost + CLEARLY < self.solution.cost:
            self._start, self.solution, self._state = start.to_array(), best, best.state
            part, motion = self._drive.window(len(best.state.poses))
            self._adjustment = Adjustment(part, motion, self._start, self._start_covariance)
            return self.compare_starts()
        return tuple(start for start, other in others if other.cost < self.solution.cost + CLEARLY)

    def _moved_to(self, start: Pose2) -> Solution | None:
        """Return the adjustment of the same path from another start; None if it does not fit."""
        move, state = start @ self.start.inverse(), self._state
        poses = np.array([(move @ Pose2.from_array(pose)).to_array() for pose in state.poses])
        part, motion = self._drive.window(len(poses))
        adjustment = Adjustment(part, motion, start.to_array(), self._start_covariance)
        moved = DriveEstimate(state.values.copy(), poses, state.slip.copy())
        try:
            solution = adjustment.solve(moved, Weights(), FEW)
        except CalibrationError:
            return None
        return solution if _fits(solution) else None

    def adjusted_again(self, weights: Weights) -> Solution:
        """Return the adjustment with other weights."""
        assert self._adjustment is not None
        return self._adjustment.solve(self._state, weights)


def begin(drive: FieldDrive, start: Pose2, start_covariance: Array) -> DrivePath:
    """Return the beginning of a drive's path, from the start as told if the drive fits there.

    Raises:
        CalibrationError: it fits nowhere, or at several places and not at the one that was told.
    """
    as_told = _begun(drive, start, start_covariance)
    places = drive.start_poses(start)
    images = [Pose2(), *drive.field.symmetries]
    if as_told is not None and as_told.fits:
        likeliest = places[0] if places else as_told.start
        if any(alike(image @ likeliest, as_told.start) for image in images):
            return as_told
    paths = [as_told, *(_begun(drive, place, start_covariance) for place in places)]
    fitting = sorted(
        (path for path in paths if path is not None and path.fits),
        key=lambda path: path.solution.cost,
    )
    if not fitting:
        raise CalibrationError(
            "the edges that were seen lie nowhere on the field's: this is another field, the robot "
            "was moved by hand, or the lens file is of another camera"
        )
    best = fitting[0]
    if as_told is not None and as_told.fits and not _is_clearly_better(best, as_told):
        return as_told
    rivals = [
        path
        for path in fitting[1:]
        if not _is_clearly_better(best, path) and not alike(path.start, best.start)
    ]
    if rivals:
        raise CalibrationError(
            f"the drive began at {start_text(best.start)} or at {start_text(rivals[0].start)}, "
            f"not at the given start {start_text(start)}; valid is a start within some centimetres"
        )
    return best


def _fits(solution: Solution) -> bool:
    return solution.share >= LEAST_SEEN and residual_sd(solution.misses) <= FAR_OFF


def _is_clearly_better(a: DrivePath, b: DrivePath) -> bool:
    return a.solution.cost + CLEARLY < b.solution.cost


def start_text(pose: Pose2) -> str:
    """Return a start pose in words."""
    return f"({pose.x:.2f} m, {pose.y:.2f} m, {np.degrees(pose.theta):.0f} degrees)"


def _begun(drive: FieldDrive, start: Pose2, start_covariance: Array) -> DrivePath | None:
    """Return the beginning of a path from a start; None if nothing explains it."""
    path = DrivePath(drive, start, start_covariance)
    try:
        for window in WINDOWS:
            if window <= BEGINNING_S and (window == WINDOWS[0] or not path.whole):
                path.grow(window)
    except CalibrationError:
        return None
    return path
