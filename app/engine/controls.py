"""Everything that a command may act on: robot, odometry, filter and driving."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from app.engine.added_models import choice_of
from app.engine.driving import Driving
from app.engine.follower import Follower
from app.engine.localization import Localization
from app.engine.parameter_changes import with_values_and_models
from app.engine.problems import Problems
from app.engine.snapshot import LAYERS
from app.languages.marking import phrase
from app.messages.message import Layer
from robot.description.profile import Profile
from robot.description.spec import RobotSpec
from robot.driving.odometry import Odometry, OdometryState
from robot.geometry import Pose2
from robot.interface import Frame, RepositionableRobot, Robot
from robot.localization.parameters import LocalizationParameters
from robot.settings import SettingError
from sim.simulated import SimSettings, SimulatedRobot


@dataclass(frozen=True)
class EngineState:
    """The state that the next ticks depend on, except for the robot and who drives."""

    spec: RobotSpec
    calibrated: float
    odometry: Odometry
    localization: Localization
    map_from_odom: Pose2
    """Where dead reckoning began."""
    odom_from_scan: Pose2 | None = None
    picture_stamp: float | None = None
    """Stamp of the last picture [s]; the picture is not stored, as the next one replaces it."""
    driving: tuple[Any, ...] | None = None
    """Of ``Driving``."""
    kept: Mapping[str, object] = field(default_factory=dict)


class Controls:
    """Robot, odometry, filter and driving; the engine owns them and one thread calls them."""

    def __init__(
        self,
        robot: Robot,
        odometry: Odometry,
        follower: Follower,
        driving: Driving,
        start: Pose2,
    ) -> None:
        self.robot = robot
        self.spec = robot.spec
        """The robot as it is known now: a calibration may change it."""
        self.calibrated = -math.inf
        """Stamp of the last calibration since the start [s]; -inf before the first."""
        self.odometry = odometry
        self.follower = follower
        """Follows the robot by its measurements."""
        self.driving = driving
        self.map_from_odom = start
        """Where dead reckoning began."""
        self.frame: Frame | None = None
        """The last picture."""
        self.odom_from_scan: Pose2 | None = None
        """Odometry at the stamp of the last picture that was used."""
        self.layers: frozenset[Layer] = LAYERS
        """Visible layers of the 3D view."""
        self.reloads = 0
        """How many times models were loaded again, since a file was saved."""
        self.problems = Problems()
        self.stamp = 0.0
        """Stamp of the last reading [s]."""
        self.kept: dict[str, object] = {}
        """What commands of features keep in the engine, by a name: values that nobody changes."""

    @property
    def localization(self) -> Localization:
        """Scanner and filter; commands to them need an engine that has them."""
        assert isinstance(self.follower, Localization)
        return self.follower

    @property
    def faults(self) -> SimSettings | None:
        """The faults of a simulated robot; None of a real one."""
        return self.robot.settings if isinstance(self.robot, SimulatedRobot) else None

    @property
    def state(self) -> EngineState:
        """The state that the next ticks depend on."""
        stamp = None if self.frame is None else self.frame.stamp
        return EngineState(
            self.spec,
            self.calibrated,
            self.odometry,
            self.localization,
            self.map_from_odom,
            self.odom_from_scan,
            stamp,
            self.driving.state,
            self.kept.copy(),
        )

    def restore(self, state: EngineState) -> None:
        """Continue from another state."""
        self.spec = state.spec
        self.calibrated = state.calibrated
        self.driving.kinematics = state.odometry.drive
        if state.driving is not None:
            self.driving.restore(state.driving)
        self.odometry = state.odometry
        self.follower = state.localization
        self.kept = dict(state.kept)
        self.map_from_odom = state.map_from_odom
        self.odom_from_scan = state.odom_from_scan
        stamp = state.picture_stamp
        self.frame = None if stamp is None else Frame(stamp, np.zeros((1, 1), np.uint8))

    def report(self, topic: str, message: str | None) -> None:
        """Report what is wrong with a topic; None reports that nothing is."""
        self.problems.report(topic, self.stamp, message)

    def halt(self) -> None:
        """Halt the motors before work that may take long; the next step drives them again."""
        self.robot.write(np.zeros(len(self.robot.spec.joints)))

    def stop_if_slow(self, wanted: LocalizationParameters) -> None:
        """Stop the robot before a change of parameters that takes longer than a step."""
        if self.localization.models.is_slow_to_use(wanted):
            self.driving.stop()
            self.halt()

    def reload_models(self, *, at_once: bool = False) -> None:
        """If the user saved a model file, halt the motors and load the models again."""
        if any(each.saved(self.stamp, at_once=at_once) for each in self.follower.added):
            self.halt()
            self.localization.reload()
            self.reloads += 1

    def stop_while_faulty(self, *, connected: bool, faults: tuple[str, ...]) -> None:
        """End the drive for a fault, stand while the robot does not answer; report all faults."""
        fault = self.follower.fault
        if fault is not None or (faults and not connected):
            self.driving.stop(fault or faults[0])
        elif not connected:
            self.driving.hold()
        self.problems.report_all("robot", self.stamp, faults)
        self.report("models", fault and phrase(f"The robot stands still: {fault}"))
        for topic, complaint in self.follower.complaints.items():
            self.report(topic, complaint)

    def set_parameters(self, values: dict[str, bool | float | str]) -> None:
        """Change parameters and models by name: all of them or none."""
        localization = self.localization
        choice = choice_of(localization.added)
        try:
            wanted, models = with_values_and_models(localization.parameters, choice, values)
        except SettingError as error:
            # The change was valid when it was sent, but a model's file may have vanished since.
            self.report("settings", f"A change was not taken: {error}.")
            return
        self.report("settings", None)
        if models != choice:
            self.halt()
        self.stop_if_slow(wanted)
        localization.choose(models, wanted)

    def calibrate(self, profile: Profile) -> None:
        """Change what is known of the robot."""
        self.spec = profile.applied_to(self.spec.as_drawn)
        self.calibrated = self.stamp
        self.odometry.drive = self.driving.kinematics = self.odometry.drive.of(self.spec)
        self.localization.use_robot(self.spec)

    def reset(self) -> None:
        """Restore the configured parameters, and put the filter back to its start."""
        self.stop_if_slow(self.localization.configured)
        self.halt()
        self.localization.reset()

    def place(self, pose: Pose2, odometry: OdometryState) -> None:
        """Put the robot elsewhere; in a replay, the recorded robot was already put there."""
        if isinstance(self.robot, RepositionableRobot):
            if not (self.driving.programme and self.driving.programme.anywhere):
                self.driving.stop()
            self.robot.place(pose)
        self.localization.earlier.clear()
        # Dead reckoning continues from the new pose: the wheels did not turn on the way there.
        self.map_from_odom = pose @ odometry.odom_from_robot.inverse()
