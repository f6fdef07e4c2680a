"""Motion checks: what scans say of the motion that wheels tell, in words."""

from __future__ import annotations

from app.languages.marking import phrase
from robot.geometry import Pose2
from robot.localization.estimate import Alert, Cause
from robot.scan import Scan
from robot.scan_checks.plug_check import PlugCheck, Plugs
from robot.scan_checks.punctuality import Habit, Punctuality

SHOWN = 3.0
"""That pictures come late is said for so long after it was last found [s]."""
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
        self._punctuality = Punctuality()

    def add(self, scan: Scan, odometry: Pose2) -> None:
        """Add a scan, and odometry at its stamp."""
        self._plugs.add(scan, odometry)
        self._punctuality.add(scan, odometry)

    @property
    def lateness_doubted(self) -> bool:
        """Whether the newest picture comes later, or earlier, than those before."""
        return self._plugs.plugs is Plugs.RIGHT and self._punctuality.doubted

    def alerts(self, stamp: float) -> tuple[Alert, ...]:
        """Return what is wrong at a stamp [s]; other plugs make pictures seem late, too."""
        plugs = self._plugs.plugs
        if plugs is not Plugs.RIGHT:
            return (Alert(Cause.MOTORS, WORDS[plugs]),)
        if 0 <= stamp - self._punctuality.changed < SHOWN:
            return (Alert(Cause.PICTURES_LATE, HABITS[self._punctuality.habit]),)
        return ()
