"""Calibrates the robot while it drives the calibration's programme.

The control loop only publishes its ticks, as it always does. A thread, which there is only during
such a drive, collects them, and a process of its own adjusts what there is: in a thread an
adjustment would take Python's lock from the control loop.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator
from concurrent.futures import Future
from dataclasses import dataclass, field, replace
from datetime import datetime
from typing import Any, Literal

from app.engine.profile_command import calibration_command
from app.engine.program import Program
from app.engine.snapshot import Snapshot
from app.features.calibration.collected_drive import CollectedDrive
from app.features.calibration.drive_follower import DriveFollower, FollowedTicks
from app.features.calibration.followed_drive import result_of, ticks_of
from app.features.calibration.written_file import written_file
from app.languages.marking import phrase
from app.messages.driving_commands import StopCommand
from app.settings.profile_files import undo, write_calibration
from app.worker_process import WorkerProcess
from robot.calibration.adjustment import CalibrationError
from robot.calibration.calibrate import Calibration
from robot.calibration.programme import KNOWN_SD, LONGEST_S
from robot.description.profile import Profile
from robot.description.unknowns import ROBOT
from robot.description.urdf import SpecError
from robot.errors import CommandError

STEP_S = 8.0
"""The drive is adjusted again after this much more of it [s]."""
FEWEST_S = 20.0
"""Shortest drive by which the robot is calibrated [s]."""
STANDING_S = 0.5
"""How much is collected of the robot's standing at the end [s]."""
BEGINS_S = 2.0
"""The drive begins within this time after its command [s]."""
MOST_WAITING = 2000
"""Most ticks that wait for the thread: forty seconds of them."""
LAST_S = 0.1
"""The drive is whole if less than this of it is missing [s]."""


@dataclass(frozen=True)
class CalibrationDrive:
    """The drive of a calibration that runs, or the last one."""

    state: Literal["drive", "adjust", "done", "failed"] = "drive"
    began: float | None = None
    """Stamp of its first tick [s]; None before it."""
    ended: float | None = None
    """Stamp at which the robot stood again [s]; None before."""
    adjusted: int = 0
    """How often it was adjusted."""
    calibration: Calibration | None = field(default=None, repr=False)
    """What the last adjustment found."""
    words: str | None = None
    """What is missing so far, or why it failed."""

    def seconds(self, stamp: float) -> float:
        """Return how long it has driven at a stamp [s]."""
        return 0.0 if self.began is None else (self.ended or stamp) - self.began


class DriveCalibrator:
    """Follows the drives of calibrations, and makes their results hold; for any thread."""

    def __init__(self, program: Program, clock: Callable[[], datetime]) -> None:
        """Prepare for a program; ``clock`` tells the date of a calibration."""
        self._program = program
        self._clock = clock
        self._drive: CalibrationDrive | None = None
        self._present_before: tuple[Profile, Profile] | None = None
        """The profile that holds since the last calibration, and the one before."""
        self._finish = threading.Event()
        self._follower = DriveFollower(
            program,
            "calibration",
            MOST_WAITING,
            self._work,
            lambda words: self._show(state="failed", words=words),
        )
        self._lock = threading.Lock()

    @property
    def drive(self) -> CalibrationDrive | None:
        """The drive that runs, or the last one; None before the first."""
        return self._drive

    @property
    def undoable(self) -> bool:
        """Whether there is a calibration to go back to."""
        return self._present_before is not None

    def require_collected(self) -> None:
        """Refuse another drive while the last one is adjusted.

        Raises:
            CommandError: it is.
        """
        if self._follower.running and self._drive is not None and self._drive.state == "adjust":
            raise CommandError("the last drive is adjusted; drive again when that is done")

    def begin(self) -> None:
        """Follow a drive that was commanded; it may be followed already."""
        with self._lock:
            if not self._follower.running:
                self._finish.clear()
                self._drive = CalibrationDrive()
                self._follower.begin()

    def finish(self) -> None:
        """End the drive, and calibrate by what it has seen.

        Raises:
            CommandError: there is no drive, or it is too short.
        """
        drive, newest = self._drive, self._program.engine.latest.get()
        if not self._follower.running or drive is None or drive.state != "drive" or newest is None:
            raise CommandError("no calibration drives now")
        driven = drive.seconds(newest.stamp)
        if driven < FEWEST_S:
            raise CommandError(f"it has driven for {driven:.0f} s; valid is {FEWEST_S:g} s or more")
        self._finish.set()
        self._program.engine.commands.put(StopCommand(type="stop"))

    def undo(self) -> None:
        """Go back to the calibration before the last one.

        Raises:
            CommandError: there is none.
        """
        with self._lock:
            if self._present_before is None:
                raise CommandError("nothing was calibrated here, so there is nothing to undo")
            if self._follower.running:
                raise CommandError("the robot is being calibrated; stop that first")
            present, earlier = self._present_before
            path = written_file(self._program.config)
            if path is not None:
                try:
                    undo(path)
                except OSError as error:
                    raise CommandError(f"{path} cannot be changed: {error.strerror}") from error
            self._program.engine.commands.put(calibration_command(earlier))
            self._present_before = earlier, present
            self._drive = None

    def close(self) -> None:
        """End the thread; may be called twice."""
        self._follower.close()

    def _work(self, ticks: FollowedTicks) -> None:
        with ticks.subscription:
            drive = self._follow(ticks_of(ticks.feed, ticks.stopping), ticks.process)
        self._show(state="adjust", words=None)
        self._keep(drive, result_of(drive.adjusted(), ticks.stopping))

    def _follow(self, ticks: Iterator[Snapshot], process: WorkerProcess) -> CollectedDrive:
        """Collect a drive to its end, and let a process adjust it on the way.

        Raises:
            CalibrationError: it ended early.
        """
        drive, due = CollectedDrive(self._program, _first(ticks), process), STEP_S
        waiting: Future[Calibration] | None = None
        self._show(began=drive.began)
        for snapshot in ticks:
            drive.add(snapshot)
            if snapshot.reading.faults:
                raise CalibrationError(f"the robot stopped: {snapshot.reading.faults[0]}")
            if snapshot.mode != "calibrate":
                break
            if waiting is not None and waiting.done():
                self._show_result(waiting)
                waiting = None
            if waiting is None and due <= drive.seconds < LONGEST_S - STEP_S:
                waiting, due = drive.adjusted(), drive.seconds + STEP_S
        driven = drive.seconds
        self._show(ended=drive.began + driven)
        if driven < LONGEST_S - LAST_S and not self._finish.is_set():
            raise CalibrationError(f"the drive was stopped after {driven:.0f} s")
        for snapshot in ticks:
            drive.add(snapshot)
            if drive.seconds - driven >= STANDING_S:
                break
        return drive

    def _show_result(self, adjusted: Future[Calibration]) -> None:
        """Show what an adjustment on the way has found."""
        assert self._drive is not None  # it is followed
        try:
            calibration = adjusted.result()
        except CalibrationError as error:
            # More of the drive may tell what is missing.
            self._show(words=str(error))
        else:
            self._show(calibration=calibration, adjusted=self._drive.adjusted + 1, words=None)
            if calibration.camera_y_sd <= KNOWN_SD and not self._finish.is_set():
                self._finish.set()
                self._program.engine.commands.put(StopCommand(type="stop"))

    def _keep(self, drive: CollectedDrive, calibration: Calibration) -> None:
        """Make a calibration hold, and write a real robot's profile."""
        program, newest = self._program, self._program.engine.latest.get()
        assert newest is not None and self._drive is not None  # there were ticks
        driven = self._drive.seconds(newest.stamp)
        source = phrase(f"{driven:.0f} s of driving on {program.field.name}")
        values, sd = calibration.values[:ROBOT], calibration.sd[:ROBOT]
        earlier = Profile.of(newest.spec)
        calibration.quality.require_consistent()
        fit = calibration.quality.table()
        profile = Profile(drive.spec.name, self._clock(), source, values, sd, earlier.lens, fit)
        program.engine.commands.put(calibration_command(profile))
        program.engine.commands.put(drive.pose_command(calibration, newest))
        self._present_before = profile, earlier
        words, path = None, written_file(program.config)
        if path is not None:
            try:
                write_calibration(path, profile)
            except (SpecError, OSError) as error:
                words = phrase(f"it holds until the program ends: {error}")
        adjusted = self._drive.adjusted + 1
        self._show(state="done", calibration=calibration, adjusted=adjusted, words=words)

    def _show(self, **changes: Any) -> None:
        assert self._drive is not None  # it is followed
        self._drive = replace(self._drive, **changes)


def _first(ticks: Iterator[Snapshot]) -> Snapshot:
    """Return the first tick of the drive."""
    began: float | None = None
    for snapshot in ticks:
        began = snapshot.stamp if began is None else began
        if snapshot.mode == "calibrate":
            return snapshot
        if snapshot.stamp - began > BEGINS_S:
            break
    raise CalibrationError("the robot did not begin to drive")
