"""The program on one screen: read, take commands, odometry, scan, filter, drive, publish.

The engine has no thread and no clock of its own: a test, a benchmark and an evaluation call
``step`` directly, faster than real time; ``run`` is the loop around it.
"""

from __future__ import annotations

import gc
import itertools
import threading
import time

import numpy as np

from app.engine.driving import Driving
from app.engine.localization import Localization
from app.engine.loop_statistics import LoopMeter
from app.engine.mailboxes.broadcast import Broadcast
from app.engine.mailboxes.command_queue import CommandQueue
from app.engine.mailboxes.latest import Latest
from app.engine.parameter_changes import changed_with_own
from app.engine.problems import LOG, Problems
from app.engine.snapshot import LAYERS, Snapshot
from app.engine.telling import tell
from app.messages.commands import (
    Command,
    DriveCommand,
    FigureEightCommand,
    PauseCommand,
    PlaceCommand,
    ResetCommand,
    ResumeCommand,
    ScatterCommand,
    SetParametersCommand,
    SetParticlesCommand,
    SetPoseCommand,
    ShowCommand,
    StopCommand,
    UpdateCommand,
)
from app.messages.message import Layer
from robot.driving.odometry import Odometry, OdometryState
from robot.geometry import Pose2, Twist2
from robot.interface import Frame, Placeable, Reading, Robot
from robot.localization.parameters import LocalizationParameters
from robot.settings import SettingError

FRAME_OVERDUE = 0.5
"""Without a new picture for so long [s] (or three usual periods), the camera has stalled."""

LOADED = 500
"""Ticks after which compiled code has been loaded: objects by the hundred thousand that live as
long as the program. To go over them takes the garbage collector 0.1 s, in which nothing steps."""


class Engine:
    """Owns the robot, the odometry, the filter and who drives; one thread calls it."""

    def __init__(
        self,
        robot: Robot,
        odometry: Odometry,
        localization: Localization,
        driving: Driving,
        start: Pose2,
    ) -> None:
        self.robot = robot
        self.latest: Latest[Snapshot] = Latest()
        self.every: Broadcast[Snapshot] = Broadcast()
        self.commands = CommandQueue()
        self._odometry = odometry
        self.localization = localization
        """Scanner and filter."""
        self._driving = driving
        self._kinematics = odometry.drive
        self._map_from_odom = start
        self._frame: Frame | None = None
        self._odom_from_scan: Pose2 | None = None
        self._problems = Problems()
        self._meter = LoopMeter()
        self._layers: frozenset[Layer] = LAYERS
        self.failure: str | None = None
        """Why it stopped, if it failed."""

    def note(self, message: str) -> None:
        """Put into the record what went wrong before the start."""
        self._problems.note(0.0, message)

    def step(self) -> Snapshot:
        """One tick: from the robot's next reading to what everybody sees.

        Raises:
            RobotError: the robot does not answer any more.
        """
        reading = self.robot.read()
        # Only then: most of a tick passes in it, and what comes meanwhile is for this tick.
        snapshot = self._advance(reading, self.commands.take())
        self._publish(snapshot)
        return snapshot

    def _advance(self, reading: Reading, commands: tuple[Command, ...]) -> Snapshot:
        self._meter.begin()
        odometry = self._odometry.update(reading)
        self._mind_own_models(reading.stamp)
        self._take(commands, reading.stamp, odometry)
        self._localize(reading)
        self._stand_while_faulty(reading)
        twist = self._driving.update(reading.stamp)
        wheels = self.robot.write(self._kinematics.wheels(twist))
        applied = self._kinematics.twist(wheels)
        return self._snapshot(reading, commands, odometry, applied)

    def _publish(self, snapshot: Snapshot) -> None:
        self.latest.put(snapshot)
        self.every.put(snapshot)

    def run(self, stop: threading.Event) -> None:
        """Step until told to stop; the robot is closed whatever happens.

        A failure is logged once and published: it never becomes a repeat of the last value.
        """
        try:
            for count in itertools.count():
                if stop.is_set():
                    break
                self.step()
                if count == LOADED:
                    gc.freeze()
        except Exception as error:
            LOG.exception("the engine stopped")
            self._publish_failure(f"The robot stopped: {error}")
        finally:
            self.robot.close()

    def _mind_own_models(self, stamp: float) -> None:
        """Take the user's own models anew when they were saved, with the motors at rest."""
        if self.localization.own.saved(stamp):
            self._rest()
            self.localization.reload()

    def _stand_while_faulty(self, reading: Reading) -> None:
        """Stand still while the robot or a model of the user's own is broken, and say where."""
        own, stamp = self.localization.own, reading.stamp
        if not reading.connected:
            self._driving.stop()
        self._problems.report_all("robot", stamp, reading.faults)
        broken = own.fault
        if broken is not None:
            self._driving.stop()
            broken = f"The robot stands still: {broken}"
        self._problems.report("own models", stamp, broken)
        self._problems.report("slow models", stamp, own.slow)
        self._problems.report("idle models", stamp, own.idle)
        self._problems.report("models on offer", stamp, " ".join(own.complaints) or None)

    def _localize(self, reading: Reading) -> None:
        if reading.frame is not None:
            self._frame = reading.frame
            self._meter.frame(reading.frame.stamp)
            self._measure(reading.frame, reading.stamp)
        last = self._frame.stamp if self._frame else 0.0
        overdue = reading.stamp - last > max(FRAME_OVERDUE, 3 * self._meter.frame_period)
        # A fault says it better.
        silent = "The camera sends no pictures." if overdue and not reading.faults else None
        self._problems.report("camera", reading.stamp, silent)

    def _measure(self, frame: Frame, now: float) -> None:
        try:
            then = self._odometry.at(frame.stamp)
        except LookupError as error:
            self._problems.report("delay", now, f"A picture came too late to be used: {error}.")
            return
        self._problems.report("delay", now, None)
        self._odom_from_scan = then.odom_from_robot
        self.localization.measure(frame, then)

    def _take(self, commands: tuple[Command, ...], stamp: float, odometry: OdometryState) -> None:
        self.localization.note(odometry.odom_from_robot)
        for command in commands:
            self._drive_command(command, stamp)
            self._filter_command(command, stamp)
            match command:
                case PlaceCommand() if isinstance(self.robot, Placeable):
                    self._place(Pose2(command.x, command.y, command.theta), odometry)
                case ShowCommand():
                    shown = {command.layer} if command.visible else set()
                    self._layers = self._layers - {command.layer} | shown

    def _drive_command(self, command: Command, stamp: float) -> None:
        match command:
            case DriveCommand():
                self._driving.drive(Twist2(command.v, command.omega), stamp)
            case FigureEightCommand():
                self._driving.figure_eight(stamp)
            case StopCommand():
                self._driving.stop()

    def _filter_command(self, command: Command, stamp: float) -> None:
        localization = self.localization
        match command:
            case SetPoseCommand() | SetParticlesCommand():
                tell(localization, command)
            case ScatterCommand():
                localization.scatter()
            case PauseCommand():
                localization.paused = True
            case ResumeCommand():
                localization.paused = False
            case UpdateCommand():
                localization.update_once()
            case ResetCommand():
                self._stand_if_slow(localization.configured)
                self._rest()
                localization.reset()
            case SetParametersCommand():
                self._set_parameters(command, stamp)

    def _set_parameters(self, command: SetParametersCommand, stamp: float) -> None:
        localization = self.localization
        choice = localization.own.choice
        try:
            wanted, own = changed_with_own(localization.parameters, choice, command.values)
        except SettingError as error:
            # It was valid when it was sent; a model's file can vanish since.
            self._problems.report("settings", stamp, f"A change was not taken: {error}.")
            return
        self._problems.report("settings", stamp, None)
        if own != choice:
            self._rest()
        self._stand_if_slow(wanted)
        localization.choose(own, wanted)

    def _stand_if_slow(self, wanted: LocalizationParameters) -> None:
        """Stop the robot before something that takes longer than a step."""
        if self.localization.is_slow_to_use(wanted):
            self._driving.stop()
            self._rest()

    def _rest(self) -> None:
        """Halt the motors for what may take long; the next step lets them go on."""
        self.robot.write(np.zeros(len(self.robot.spec.joints)))

    def _place(self, pose: Pose2, odometry: OdometryState) -> None:
        assert isinstance(self.robot, Placeable)
        self._driving.stop()
        self.robot.place(pose)
        # Dead reckoning goes on from the new place: the wheels did not turn on the way there.
        self._map_from_odom = pose @ odometry.odom_from_robot.inverse()

    def _snapshot(
        self,
        reading: Reading,
        taken: tuple[Command, ...],
        odometry: OdometryState,
        applied: Twist2,
    ) -> Snapshot:
        localization = self.localization
        belief = localization.belief
        scan = localization.line_scan
        scan_pose = None
        # Kept, not asked for by stamp: the odometry of a camera that stalls is forgotten in time.
        if belief is not None and self._odom_from_scan is not None:
            scan_pose = belief.pose(self._odom_from_scan)
        return Snapshot(
            stamp=reading.stamp,
            published=time.monotonic(),
            reading=reading,
            commands=taken,
            truth=reading.truth,
            odometry=self._map_from_odom @ odometry.odom_from_robot,
            odom_from_robot=odometry.odom_from_robot,
            pose=belief.pose(odometry.odom_from_robot) if belief else None,
            estimate=belief.estimate if belief else None,
            integrity=localization.integrity_at(odometry.odom_from_robot),
            twist=applied,
            mode=self._driving.mode,
            cloud=localization.cloud,
            frame=self._frame,
            line_scan=scan,
            odom_from_scan=self._odom_from_scan,
            scan_pose=scan_pose,
            paused=localization.paused,
            updates=localization.updates,
            parameters=localization.parameters,
            own=localization.own.choice,
            fault=localization.fault,
            loop=self._meter.end(reading.stamp),
            connected=reading.connected,
            battery_v=reading.battery_v,
            problems=self._problems.now,
            problem_count=self._problems.count,
            record=self._problems.record,
            layers=self._layers,
        )

    def _publish_failure(self, message: str) -> None:
        self.failure = message
        last = self.latest.get()
        if last is None:
            return
        self._problems.report("engine", last.stamp, message)
        self.latest.put(last.failed(self._problems))
