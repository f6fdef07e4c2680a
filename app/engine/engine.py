"""The program on one screen: read, take commands, odometry, scan, filter, drive, publish.

The engine has no thread and no clock of its own: a test, a benchmark, an evaluation and a replay
call ``step`` directly, faster than real time; ``run`` is the loop around it.
"""

from __future__ import annotations

import gc
import itertools
import threading
import time
from collections.abc import Callable

from app.engine.controls import Controls
from app.engine.localization import Localization
from app.engine.loop_statistics import LoopMeter
from app.engine.mailboxes.broadcast import Broadcast
from app.engine.mailboxes.command_queue import CommandQueue
from app.engine.mailboxes.latest import Latest
from app.engine.problems import LOG
from app.engine.snapshot import Snapshot
from app.messages.commands import Command
from robot.driving.odometry import OdometryState
from robot.geometry import Twist2
from robot.interface import Frame, Reading

FRAME_OVERDUE = 0.5
"""Without a new picture for so long [s] (or three usual periods), the camera has stalled."""

LOADED = 500
"""Ticks after which compiled code has been loaded: objects by the hundred thousand that live as
long as the program. To go over them takes the garbage collector 0.1 s, in which nothing steps."""

Apply = Callable[[Command, Controls, OdometryState], None]
"""Carries out a command that was checked."""


class Engine:
    """Steps robot, odometry, filter and drive; one thread calls it."""

    def __init__(self, controls: Controls, apply: Apply) -> None:
        """At the start.

        Args:
            controls: robot, odometry, filter and who drives.
            apply: carries out a command; ``app.engine.commands`` has the table.
        """
        self.controls = controls
        self.latest: Latest[Snapshot] = Latest()
        self.every: Broadcast[Snapshot] = Broadcast()
        self.commands = CommandQueue()
        self.failure: str | None = None
        """Why it stopped, if it failed."""
        self._apply = apply
        self._meter = LoopMeter()
        self._applied: tuple[Reading, Twist2] | None = None
        """The last tick's reading and velocity."""

    @property
    def localization(self) -> Localization:
        """Scanner and filter."""
        return self.controls.localization

    def note(self, message: str) -> None:
        """Put into the record what went wrong before the start."""
        self.controls.problems.note(0.0, message)

    def step(self) -> Snapshot:
        """One tick: from the robot's next reading to what everybody sees.

        Raises:
            RobotError: the robot does not answer any more.
        """
        reading = self.controls.robot.read()
        # Only then: most of a tick passes in it, and what comes meanwhile is for this tick.
        snapshot = self._advance(reading, self.commands.take())
        self.publish(snapshot)
        return snapshot

    def advance(self, commands: tuple[Command, ...]) -> Snapshot:
        """One tick with these commands; nobody sees it yet.

        Raises:
            RobotError: the robot does not answer any more; a recording is over.
        """
        return self._advance(self.controls.robot.read(), commands)

    def linger(self, commands: tuple[Command, ...]) -> Snapshot:
        """Take commands without any time going by; after the first tick."""
        assert self._applied is not None  # there was a tick
        reading, twist = self._applied
        self._meter.begin()
        self.controls.localization.own.look_again()
        self.controls.reload_own_models()
        odometry = self.controls.odometry.at(reading.stamp)
        self._take(commands, odometry)
        self.controls.stand_while_faulty(connected=reading.connected, faults=reading.faults)
        return self._snapshot(reading, commands, odometry, twist)

    def publish(self, snapshot: Snapshot) -> None:
        """Let everybody see a tick."""
        self.latest.put(snapshot)
        self.every.put(snapshot)

    def fail(self, message: str) -> None:
        """Say that it is over, and why."""
        self.failure = message
        last = self.latest.get()
        if last is None:
            return
        self.controls.problems.report("engine", last.stamp, message)
        self.latest.put(last.failed(self.controls.problems))

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
            self.fail(f"The robot stopped: {error}")
        finally:
            self.controls.robot.close()

    def _advance(self, reading: Reading, commands: tuple[Command, ...]) -> Snapshot:
        self._meter.begin()
        controls, driving = self.controls, self.controls.driving
        controls.stamp = reading.stamp
        odometry = controls.odometry.update(reading)
        controls.reload_own_models()
        self._take(commands, odometry)
        self._localize(reading)
        controls.stand_while_faulty(connected=reading.connected, faults=reading.faults)
        kinematics = controls.odometry.drive
        wheels = controls.robot.write(kinematics.wheels(driving.update(reading.stamp)))
        self._applied = reading, kinematics.twist(wheels)
        return self._snapshot(reading, commands, odometry, self._applied[1])

    def _take(self, commands: tuple[Command, ...], odometry: OdometryState) -> None:
        self.controls.localization.note(odometry.odom_from_robot)
        for command in commands:
            self._apply(command, self.controls, odometry)

    def _localize(self, reading: Reading) -> None:
        controls = self.controls
        if reading.frame is not None:
            controls.frame = reading.frame
            self._meter.frame(reading.frame.stamp)
            self._measure(reading.frame)
        last = controls.frame.stamp if controls.frame else 0.0
        overdue = reading.stamp - last > max(FRAME_OVERDUE, 3 * self._meter.frame_period)
        # A fault says it better.
        silent = "The camera sends no pictures." if overdue and not reading.faults else None
        controls.report("camera", silent)

    def _measure(self, frame: Frame) -> None:
        controls = self.controls
        try:
            exposed = controls.odometry.at(frame.stamp)
        except LookupError as error:
            controls.report("delay", f"A picture came too late to be used: {error}.")
            return
        controls.report("delay", None)
        controls.odom_from_scan = exposed.odom_from_robot
        controls.localization.measure(frame, exposed)

    def _snapshot(
        self,
        reading: Reading,
        taken: tuple[Command, ...],
        odometry: OdometryState,
        applied: Twist2,
    ) -> Snapshot:
        controls, localization = self.controls, self.controls.localization
        problems, belief = controls.problems, localization.belief
        scan_pose = None
        # Kept, not asked for by stamp: the odometry of a camera that stalls is forgotten in time.
        if belief is not None and controls.odom_from_scan is not None:
            scan_pose = belief.pose(controls.odom_from_scan)
        return Snapshot(
            stamp=reading.stamp,
            published=time.monotonic(),
            reading=reading,
            commands=taken,
            truth=reading.truth,
            odometry=controls.map_from_odom @ odometry.odom_from_robot,
            odom_from_robot=odometry.odom_from_robot,
            pose=belief.pose(odometry.odom_from_robot) if belief else None,
            estimate=belief.estimate if belief else None,
            integrity=localization.integrity_at(odometry.odom_from_robot),
            twist=applied,
            mode=controls.driving.mode,
            cloud=localization.cloud,
            frame=controls.frame,
            line_scan=localization.line_scan,
            odom_from_scan=controls.odom_from_scan,
            scan_pose=scan_pose,
            paused=localization.paused,
            updates=localization.updates,
            parameters=localization.parameters,
            own=localization.own.choice,
            fault=localization.fault,
            loop=self._meter.end(reading.stamp),
            connected=reading.connected,
            battery_v=reading.battery_v,
            problems=problems.now,
            problem_count=problems.count,
            record=problems.record,
            layers=controls.layers,
        )
