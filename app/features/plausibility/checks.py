"""Checks each scan before the filter has it, and says what cannot be true."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from app.engine.added_models import AddedModels
from app.engine.robots import robot_spec
from app.features.plausibility.plug_check import PlugCheck, Plugs
from app.features.plausibility.punctuality import Habit, Punctuality
from app.languages.marking import phrase
from app.settings.config import Config
from robot.fields.field import Field
from robot.geometry import Pose2
from robot.localization.estimate import Alert, Cause
from robot.scan import Scan

STANDS, STANDS_TURN = 0.003, 0.005
"""Of a robot that has moved by less since its last picture, that may be the same [m], [rad]."""
SHOWN = 3.0
"""What was found is said for so long after it was last found [s]."""
FROZEN = Alert(
    Cause.FROZEN,
    phrase(
        "the camera delivers the same picture again and again while the wheels turn: it is not used"
    ),
)
DISPLACED = Alert(
    Cause.WHEEL_SLIP,
    phrase("the robot was not where its wheels had led it: was it pushed, lifted, or stuck?"),
)
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


class PlausibilityChecks(AddedModels):
    """Offers no model: it looks at the scans that the program's own ones get."""

    def __init__(self, track: float) -> None:
        """Begin with nothing seen.

        Args:
            track: distance between the wheels [m].
        """
        super().__init__()
        self._plugs = PlugCheck(track)
        self._punctuality = Punctuality()
        self._stamp = 0.0
        self._frozen_until = self._displaced_until = -math.inf
        self._pictured = Pose2()
        """Odometry when the newest picture was first seen."""

    @property
    def alerts(self) -> tuple[Alert, ...]:
        """What cannot be true; nothing if all can."""
        if self._stamp < self._frozen_until:
            return (FROZEN,)
        if self._stamp < self._displaced_until:
            return (DISPLACED,)
        plugs = self._plugs.plugs
        if plugs is Plugs.RIGHT and self._stamp < self._punctuality.changed + SHOWN:
            return (Alert(Cause.PICTURES_LATE, HABITS[self._punctuality.habit]),)
        return () if plugs is Plugs.RIGHT else (Alert(Cause.MOTORS, WORDS[plugs]),)

    def note_displaced(self) -> None:
        """Note that the robot was found again, elsewhere than its wheels had led."""
        self._displaced_until = self._stamp + SHOWN

    def cleared(self, scan: Scan, odometry: Pose2) -> Scan:
        """Return a scan as it is, or one that sees nothing if its picture is an old one."""
        self._stamp = scan.stamp
        if scan.repeated and _moved(self._pictured, odometry):
            self._frozen_until = scan.stamp + SHOWN
            rays = len(scan.ranges)
            return replace(scan, ranges=np.full(rays, np.inf), sight=np.full((rays, 2), np.nan))
        if scan.repeated:
            return scan
        self._pictured = odometry
        self._plugs.add(scan, odometry)
        self._punctuality.add(scan, odometry)
        return scan


def plausibility_checks(config: Config, field: Field) -> list[PlausibilityChecks]:
    """Return what checks an engine's scans."""
    return [PlausibilityChecks(robot_spec(config).track)]


def _moved(before: Pose2, after: Pose2) -> bool:
    return before.distance_to(after) > STANDS or abs(before.turn_to(after)) > STANDS_TURN
