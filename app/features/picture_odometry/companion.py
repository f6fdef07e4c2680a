"""Motion from the picture, in each tick: measured beside the wheels, and compared with them."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field

from app.engine.controls import Controls
from app.languages.marking import phrase
from app.messages.commands import Command
from robot.camera import FloorView
from robot.geometry import Array, Pose2
from robot.interface import Reading
from robot.picture_odometry.aided_odometry import PictureAidedOdometry
from robot.picture_odometry.ground import GroundError
from robot.picture_odometry.odometer import PictureMotion, PictureOdometer
from robot.picture_odometry.settings import NAME, PictureOdometrySettings
from robot.picture_odometry.wheel_check import WheelCheck, WheelState

WORDS = {
    WheelState.STUCK: phrase("The wheels turn, and the robot stands: it is stuck."),
    WheelState.SLIPPING: phrase("The robot does not move as its wheels turn: they slip."),
    WheelState.PUSHED: phrase("The robot moves, and its wheels do not turn so: it is pushed."),
    WheelState.LIFTED: phrase("The robot was lifted off the floor."),
}
"""What is told of wheels that do not roll."""


@dataclass(frozen=True, slots=True, eq=False)
class PictureOdometryState:
    """What the picture's odometer shows of itself at a tick."""

    motion: PictureMotion = field(repr=False)
    """The newest motion between two pictures."""
    odom_from_robot: Pose2
    """All motions one after the other, since the first picture; where nothing is seen, as the
    wheels say."""
    wheels: WheelState
    odom_covariance: Array | None = field(default=None, repr=False)
    """Covariance (3, 3) of dead reckoning that is corrected by it; None if it is not."""


class PictureOdometryCompanion:
    """Goes along with one engine: gives it an odometry that looks at pictures, and tests wheels."""

    needs_pictures = False

    def __init__(self, settings: PictureOdometrySettings) -> None:
        self._settings = settings
        self._check = WheelCheck()
        self._view: FloorView | None = None
        self._odometer: PictureOdometer | None = None
        self._last: PictureMotion | None = None
        self._pose = Pose2()
        self.shown: PictureOdometryState | None = None

    def commands(self, odom_from_robot: Pose2, controls: Controls) -> Iterable[Command]:
        """Put the odometry in place that looks at pictures; it gives no commands."""
        if self._view != controls.spec.floor_view:  # first, or calibrated anew
            self._view = controls.spec.floor_view
            self._odometer = self._made(self._view, controls)
        odometry = controls.odometry
        if self._odometer is None:
            return ()
        if not isinstance(odometry, PictureAidedOdometry):
            odometry = PictureAidedOdometry(odometry, self._odometer, fuse=self._settings.fuse)
            controls.odometry = odometry
        elif odometry.odometer.view != self._view:
            odometry.odometer = self._odometer
        odometry.delay = controls.spec.picture_delay
        return ()

    def _made(self, view: FloorView, controls: Controls) -> PictureOdometer | None:
        try:
            odometer = PictureOdometer(view, self._settings)
        except GroundError as error:
            controls.report(NAME, phrase(f"Motion is not measured in pictures: {error}."))
            return None
        controls.report(NAME, None)
        return odometer

    def add(self, reading: Reading, controls: Controls) -> None:
        """Compare the motion of a new picture with that of the wheels."""
        odometry = controls.odometry
        motion = odometry.newest if isinstance(odometry, PictureAidedOdometry) else None
        if motion is None or motion is self._last or not isinstance(odometry, PictureAidedOdometry):
            return
        self._last = motion
        self._pose = self._pose @ motion.motion
        state = self._check.add(motion)
        controls.report("wheels", WORDS.get(state))
        covariance = odometry.at(reading.stamp).covariance if odometry.fuse else None
        self.shown = PictureOdometryState(motion, self._pose, state, covariance)

    def close(self) -> None:
        """Do nothing: there is no thread."""
