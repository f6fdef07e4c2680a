"""Motion checks: what scans say of the motion that wheels tell, in words."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from app.languages.marking import phrase
from robot.geometry import Array, Pose2
from robot.localization.estimate import Alert, Cause
from robot.localization.monitoring.monitor import Monitor
from robot.scan import Scan
from robot.scan_checks.plug_check import PlugCheck, Plugs
from robot.scan_checks.punctuality import LEAST, Habit, Punctuality

SHOWN = 3.0
"""That pictures come late is said for so long after it was last found [s]."""
MUCH_LATER = 0.07
"""Pictures are reckoned with as later than before if it is by more than this [s]; wheels of a robot
that nobody calibrated look like some 50 ms for a moment."""
FADES = 0.9
"""That a pose may be off, as pictures may be late, fades by this share a picture [of a variance].
"""
HABITS = {
    Habit.LATER: phrase("pictures come late, or later than before"),
    Habit.BY_TURNS: phrase("pictures come late by turns: is the computer or the network busy?"),
}
WORDS = {
    Plugs.SWAPPED: phrase(
        "the floor turns the other way than the wheels do: are the motors in each other's place, "
        "or is the picture mirrored?"
    ),
    Plugs.LEFT_REVERSED: phrase("the left motor turns the other way than it says"),
    Plugs.RIGHT_REVERSED: phrase("the right motor turns the other way than it says"),
    Plugs.BOTH_REVERSED: phrase("both motors turn the other way than they say"),
    Plugs.TURNED_ROUND: phrase(
        "the floor moves as if the camera looked back: is the robot wired back to front?"
    ),
}


class MotionChecks:
    """Checks plugs and pictures of one robot."""

    def __init__(self, track: float) -> None:
        """Begin with a robot that is as it should be.

        Args:
            track: distance between the wheels [m].
        """
        self._plugs = PlugCheck(track)
        self.forget_lateness()

    def add(self, scan: Scan, odometry: Pose2) -> None:
        """Add a scan, and odometry at its stamp."""
        self._plugs.add(scan, odometry)
        self._punctuality.add(scan, odometry)

    @property
    def _late(self) -> float:
        """By how much the newest picture is reckoned to be late [s]."""
        return self._punctuality.by_turns.late if self._by_turns else self._later

    def on_time(self, scan: Scan) -> Scan:
        """Return the newest scan as seen from where the robot was at its stamp."""
        if self._plugs.plugs is not Plugs.RIGHT or self._late == 0.0:
            return scan
        since = self._punctuality.since(self._late)
        return replace(scan, robot_from_scan=since @ scan.robot_from_scan)

    def forget_lateness(self) -> None:
        """Forget how late pictures come: the robot stands elsewhere, and tape jumped in them."""
        self._punctuality = Punctuality()
        self._by_turns = False
        """Whether it is reckoned with that each picture is late on its own."""
        self._later = self._usual = 0.0
        """How much later than at first pictures are believed to come otherwise, at least 0, and how
        much later they seem to come, slipping wheels included [s]."""
        self._changed = -math.inf
        """Stamp at which that last changed [s]."""
        self._unsure = np.zeros((3, 3))
        """By how much the newest scans may lead elsewhere, as they may be late [m², rad²]."""

    def advise(self, monitor: Monitor) -> None:
        """Reckon with how late the newest picture is, and tell what is not known of that."""
        if self._plugs.plugs is not Plugs.RIGHT:
            return
        self._reckon(monitor)
        if self._punctuality.doubted and not self._by_turns:
            monitor.doubt_lateness()
        unsure = np.zeros((3, 3))
        if self._by_turns or monitor.may_be_late:
            unsure = self._moved_while_unsure()
        # A pose that was led astray stays so until scans say more.
        self._unsure = np.maximum(unsure, FADES * self._unsure)
        monitor.of_clearing += self._unsure

    def _reckon(self, monitor: Monitor) -> None:
        """Reckon with pictures that come otherwise, unless wheels that slip may be the reason."""
        punctuality = self._punctuality
        # What grows without a change of habit may be a wheel that has slipped for a moment.
        grown, self._usual = punctuality.usual - self._usual, punctuality.usual
        by_turns = punctuality.habit is Habit.BY_TURNS
        self._by_turns &= by_turns
        if punctuality.changed <= self._changed:
            return
        self._changed = punctuality.changed
        if by_turns and not self._by_turns and not monitor.slips:
            self._by_turns = True
            monitor.forget()  # what seemed to be errors of wheels and camera was of pictures
        if not by_turns and monitor.may_be_late and (grown > MUCH_LATER or grown < 0):
            later = self._later + grown
            self._later = later if later >= LEAST else 0.0

    def _moved_while_unsure(self) -> Array:
        """Return the covariance (3, 3) of a pose whose picture may have been taken at any time."""
        since, late, unsure = self._punctuality.since, self._late, self._punctuality.unsure
        if unsure == 0.0:
            return np.zeros((3, 3))
        ways = [since(late).inverse() @ since(late + other) for other in (unsure, -unsure)]
        ahead, aside, turn = np.square([way.to_array() for way in ways]).max(axis=0).tolist()
        return np.diag([ahead + aside, ahead + aside, turn])

    def alerts(self, stamp: float) -> tuple[Alert, ...]:
        """Return what is wrong at a stamp [s]; other plugs make pictures seem late, too."""
        plugs = self._plugs.plugs
        if plugs is not Plugs.RIGHT:
            return (Alert(Cause.MOTORS, WORDS[plugs]),)
        habit = self._punctuality.habit
        if habit in HABITS and 0 <= stamp - self._punctuality.changed < SHOWN:
            return (Alert(Cause.PICTURES_LATE, HABITS[habit]),)
        return ()
