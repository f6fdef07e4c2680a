"""Everything that a command may act on: the robot, its odometry and filter, and who drives."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from app.engine.driving import Driving
from app.engine.localization import Localization
from app.engine.parameter_changes import changed_with_own
from app.engine.problems import Problems
from app.engine.snapshot import LAYERS
from app.messages.message import Layer
from robot.driving.odometry import Odometry, OdometryState
from robot.geometry import Pose2
from robot.interface import Frame, Placeable, Robot
from robot.localization.parameters import LocalizationParameters
from robot.settings import SettingError


@dataclass(frozen=True)
class EngineState:
    """What the next ticks depend on, besides the robot and who drives."""

    odometry: Odometry
    localization: Localization
    map_from_odom: Pose2
    """Where dead reckoning began."""
    odom_from_scan: Pose2 | None = None
    picture_stamp: float | None = None
    """Of the last picture [s]; the picture itself is not kept, as the next one replaces it."""


class Controls:
    """Owned by the engine; one thread calls it."""

    def __init__(
        self,
        robot: Robot,
        odometry: Odometry,
        localization: Localization,
        driving: Driving,
        start: Pose2,
    ) -> None:
        self.robot = robot
        self.odometry = odometry
        self.localization = localization
        """Scanner and filter."""
        self.driving = driving
        self.map_from_odom = start
        """Where dead reckoning began."""
        self.frame: Frame | None = None
        """The last picture."""
        self.odom_from_scan: Pose2 | None = None
        """Odometry at the stamp of the last picture that was used."""
        self.layers: frozenset[Layer] = LAYERS
        """What the 3D view shows."""
        self.problems = Problems()
        self.stamp = 0.0
        """Of the last reading [s]."""

    @property
    def state(self) -> EngineState:
        """What the next ticks depend on."""
        stamp = None if self.frame is None else self.frame.stamp
        return EngineState(
            self.odometry, self.localization, self.map_from_odom, self.odom_from_scan, stamp
        )

    def restore(self, state: EngineState) -> None:
        """Go on from another state."""
        self.odometry = state.odometry
        self.localization = state.localization
        self.map_from_odom = state.map_from_odom
        self.odom_from_scan = state.odom_from_scan
        stamp = state.picture_stamp
        self.frame = None if stamp is None else Frame(stamp, np.zeros((1, 1), np.uint8))

    def report(self, topic: str, message: str | None) -> None:
        """Say what is wrong with a topic, or None that nothing is."""
        self.problems.report(topic, self.stamp, message)

    def halt(self) -> None:
        """Halt the motors for what may take long; the next step lets them go on."""
        self.robot.write(np.zeros(len(self.robot.spec.joints)))

    def stand_if_slow(self, wanted: LocalizationParameters) -> None:
        """Stop the robot before a change of parameters that takes longer than a step."""
        if self.localization.is_slow_to_use(wanted):
            self.driving.stop()
            self.halt()

    def reload_own_models(self) -> None:
        """Read the user's own models again when they were saved, with the motors at rest."""
        if self.localization.own.saved(self.stamp):
            self.halt()
            self.localization.reload()

    def stand_while_faulty(self, *, connected: bool, faults: tuple[str, ...]) -> None:
        """Stand still while the robot or a model of the user's own is broken, and say where."""
        own = self.localization.own
        if not connected:
            self.driving.stop()
        self.problems.report_all("robot", self.stamp, faults)
        broken = own.fault
        if broken is not None:
            self.driving.stop()
            broken = f"The robot stands still: {broken}"
        self.report("own models", broken)
        self.report("slow models", own.slow)
        self.report("idle models", own.idle)
        self.report("models on offer", " ".join(own.complaints) or None)

    def set_parameters(self, values: dict[str, bool | float | str]) -> None:
        """Change parameters and models by name; all or none."""
        localization = self.localization
        choice = localization.own.choice
        try:
            wanted, own = changed_with_own(localization.parameters, choice, values)
        except SettingError as error:
            # It was valid when it was sent; a model's file can vanish since.
            self.report("settings", f"A change was not taken: {error}.")
            return
        self.report("settings", None)
        if own != choice:
            self.halt()
        self.stand_if_slow(wanted)
        localization.choose(own, wanted)

    def reset(self) -> None:
        """Parameters as configured, and the filter where it started."""
        self.stand_if_slow(self.localization.configured)
        self.halt()
        self.localization.reset()

    def place(self, pose: Pose2, odometry: OdometryState) -> None:
        """Put the robot elsewhere; in a replay it was put there then."""
        if isinstance(self.robot, Placeable):
            self.driving.stop()
            self.robot.place(pose)
        # Dead reckoning goes on from the new place: the wheels did not turn on the way there.
        self.map_from_odom = pose @ odometry.odom_from_robot.inverse()
