"""The steps of one tick: read, take commands, odometry, scan, filter, drive, publish.

The engine has no thread and no clock of its own. Tests, benchmarks and evaluations call ``step``
directly, faster than real time, and a replay calls ``advance``; ``run`` is the loop around
``step``.
"""

from __future__ import annotations

import gc
import itertools
import math
import threading
import time
from collections.abc import Callable, Sequence

import numpy as np

from app.engine.companions import Companions
from app.engine.control import ControlLoop
from app.engine.controls import Controls
from app.engine.localization import Localization
from app.engine.loop_statistics import LoopMeter
from app.engine.mailboxes.rhythm import EARLY_S, Rhythm
from app.engine.problems import LOG, failing_alone
from app.engine.rest import PAGE_HZ, RESTING_PERIOD, STANDS_S, WATCHED_PERIOD, Standstill
from app.engine.snapshot import Snapshot
from app.feature_search import FeatureError, reason_of
from app.languages.marking import phrase
from app.messages.commands import Command
from robot.driving.odometry import OdometryState
from robot.errors import BrickPoseError
from robot.geometry import Array, Twist2
from robot.interface import Frame, Reading, RestingRobot, RobotError
from robot.scan import Scan

FRAME_OVERDUE = 0.5
"""Time without a picture [s], or three usual periods if longer, after which the camera stalled."""

MUCH_TOO_FAST = 1.1
"""By so much may a robot's clock run ahead of this computer's: no clock that waits does."""

UNWATCHED_S = 0.2
"""Interval of snapshots while nobody looks [s]: with 0.02 all ticks cost 0.4 % of a core more."""

WARM_UP_TICKS = 500
"""Ticks after which all compiled code is loaded: hundreds of thousands of objects that live as long
as the program. The garbage collector takes 0.1 s to scan them, and the engine waits meanwhile."""

Apply = Callable[[Command, Controls, OdometryState], None]
"""Carries out a checked command."""


class Engine(ControlLoop):
    """Steps robot, odometry, filter and drive; one thread calls it."""

    def __init__(
        self, controls: Controls, apply: Apply, companions: Companions | None = None
    ) -> None:
        """Make an engine before its first tick.

        Args:
            controls: robot, odometry, filter and driving.
            apply: carries out a command; ``app.engine.commands`` has the table.
            companions: what features do in each tick; None is nothing.
        """
        super().__init__(controls.spec, controls.follower.shown.scanner)
        self.controls = controls
        self._apply = apply
        self._companions = companions or Companions()
        self._meter = LoopMeter()
        self._standstill = Standstill()
        robot = controls.robot
        self._resting_robot = robot if isinstance(robot, RestingRobot) else None
        self._resting = 0.0
        """Time between two pictures that are used while the camera rests [s]; 0: it does not."""
        self._pictured = False
        """Whether the last reading had a picture that was used."""
        self._woke = 0.0
        """When it last began to send all pictures [s]."""
        self._measured = -math.inf
        """Stamp of the last picture or scan that was used [s]."""
        self._last_scan: float | None = None
        """Stamp of a laser's newest scan [s]."""
        self._applied: tuple[Reading, Twist2] | None = None
        """The last tick's reading and velocity."""
        self._rhythm = Rhythm()
        self._told = -math.inf
        """When a tick was last published by ``run`` [s]."""

    @property
    def localization(self) -> Localization:
        """Scanner and filter."""
        return self.controls.localization

    def note(self, message: str) -> None:
        """Add a problem to the record at stamp 0, such as one from before the start."""
        self.controls.problems.note(0.0, message)

    def step(self) -> Snapshot:
        """Run one tick: from the robot's next reading to the published snapshot.

        Raises:
            RobotError: the robot does not answer any more.
        """
        snapshot = self._snapshot(*self._next())
        self.publish(snapshot)
        return snapshot

    def _next(self) -> tuple[Reading, tuple[Command, ...], OdometryState, Twist2]:
        reading = self.controls.robot.read()
        # Take commands after the read: it waits for most of a tick, and commands that come
        # meanwhile belong to this tick.
        return self._advance(reading, self.commands.take())

    def advance(self, commands: tuple[Command, ...]) -> Snapshot:
        """Run one tick with these commands, without publishing it.

        Raises:
            RobotError: the robot does not answer any more; a recording is over.
        """
        return self._snapshot(*self._advance(self.controls.robot.read(), commands))

    def apply_between_ticks(self, commands: tuple[Command, ...]) -> Snapshot:
        """Carry out commands between two ticks, while no time passes; needs a tick before."""
        assert self._applied is not None  # there was a tick
        reading, twist = self._applied
        self._meter.begin()
        self.controls.reload_models(at_once=True)
        odometry = self.controls.odometry.at(reading.stamp)
        self._take(commands, odometry)
        self.controls.stop_while_faulty(connected=reading.connected, faults=reading.faults)
        return self._snapshot(reading, commands, odometry, twist)

    def fail(self, message: str) -> None:
        """Publish that the engine has failed, and why."""
        self.failure = message
        last = self.latest.get()
        if last is None:
            return
        self.controls.problems.report("engine", last.stamp, message)
        self.latest.put(last.failed(self.controls.problems.shown))

    def run(self, stop: threading.Event) -> None:
        """Step until ``stop`` is set; the robot is then closed, or handed over."""
        self.audience.leave()  # whoever made the engine
        try:
            began = 0.0, 0.0
            for count in itertools.count():
                if stop.is_set():
                    break
                tick = self._next()
                stamp = tick[0].stamp
                # Of the last tick, too: it says where the robot was left.
                if self._is_wanted() or stop.is_set():
                    self.publish(self._snapshot(*tick))
                began = began if count else (time.monotonic(), stamp)
                self._check_pace(*began, stamp)
                if count == WARM_UP_TICKS:
                    gc.freeze()
        except Exception as error:
            LOG.exception("the engine stopped")
            kind = "" if isinstance(error, BrickPoseError) else f"{type(error).__name__}: "
            self.fail(f"The robot stopped: {kind}{error}")
        finally:
            with failing_alone(self.controls.robot.name):
                self._leave_robot()
            self._companions.close()

    def where_it_hangs(self, thread: int | None) -> Sequence[str]:
        """Return in words which lines of users' files a thread is running."""
        added = self.controls.follower.added
        return [words for models in added if (words := models.running(thread))]

    def _is_wanted(self) -> bool:
        """Return whether anybody waits for this tick, maybe with a new picture."""
        clock, rate = time.monotonic(), self.audience.rate
        if self._resting:
            rate = min(rate, 1 / self._resting)
        wanted = clock >= self._told + UNWATCHED_S - EARLY_S
        wanted |= rate > 0 and (self._pictured or self._rhythm.wait(clock) <= 0)
        if wanted and rate > 0:
            self._rhythm.choose(clock, rate)
        self._told = clock if wanted else self._told
        return wanted or self.every.subscribed

    def _check_pace(self, began: float, first: float, stamp: float) -> None:
        """Report a robot of others that does not wait: what it does is too fast to be driven."""
        passed = time.monotonic() - began
        if self.controls.faults is None and stamp - first > MUCH_TOO_FAST * passed + 1.0:
            fast = phrase("The robot's clock is too fast: does its read wait until its stamp?")
            self.controls.report("pace", fast)

    def _leave_robot(self) -> None:
        robot = self.controls.robot
        if self.handed_over and self.failure is None:
            robot.write(np.zeros(len(robot.spec.joints)))
        else:
            robot.close()

    def _advance(
        self, reading: Reading, commands: tuple[Command, ...]
    ) -> tuple[Reading, tuple[Command, ...], OdometryState, Twist2]:
        """Work on a reading; return what a snapshot of this tick is made from."""
        self._meter.begin()
        controls, driving = self.controls, self.controls.driving
        joints = len(controls.robot.spec.joints)
        _require_sound("positions", reading.positions, joints)
        _require_sound("velocities", reading.velocities, joints)
        controls.stamp = reading.stamp
        odometry = controls.odometry.update(reading)
        controls.reload_models()
        commands += self._companions.commands(odometry.odom_from_robot, controls)
        self._take(commands, odometry)
        self._localize(reading)
        self._rest(odometry, commands)
        self._companions.add(reading, controls)
        controls.stop_while_faulty(connected=reading.connected, faults=reading.faults)
        kinematics = controls.odometry.drive
        wheels = controls.robot.write(kinematics.wheels(driving.update(odometry)))
        _require_sound("applied velocities", wheels, joints)
        self._applied = reading, kinematics.twist(wheels)
        return reading, commands, odometry, self._applied[1]

    def _take(self, commands: tuple[Command, ...], odometry: OdometryState) -> None:
        self.controls.follower.note(odometry.odom_from_robot)
        for command in commands:
            name = str(getattr(command, "type", type(command).__name__))
            try:
                self._apply(command, self.controls, odometry)
                self.controls.report(f"command:{name}", None)
            except RobotError:
                raise
            except Exception as error:
                self._refuse(name, command, error)

    def _refuse(self, name: str, command: Command, error: Exception) -> None:
        """Name a command that could not be carried out; in doubt the robot stands."""
        LOG.exception("the command %s failed", name)
        controls, why = self.controls, reason_of(error)
        controls.driving.stop()
        if self._companions.leave_out_giver(command, error, controls):
            return
        words = phrase(f"The command {name} failed: {why}")
        if isinstance(error, FeatureError) or not isinstance(error, BrickPoseError):
            controls.report(f"command:{name}", words)
        else:
            controls.problems.note(controls.stamp, words)

    def _localize(self, reading: Reading) -> None:
        controls = self.controls
        frame = _exposed(reading.frame, controls.spec.picture_delay)
        seen = frame or reading.scan
        self._pictured = False
        if seen is not None:
            self._last_scan = self._last_scan if frame else seen.stamp
            if not self._resting or seen.stamp >= self._measured + 0.9 * self._resting:
                controls.frame, self._pictured = frame or controls.frame, frame is not None
                self._meter.frame(seen.stamp, rested=self._measured < self._woke)
                self._measure(seen)
                self._measured = seen.stamp
        # A robot that has sent scans and never a picture has a laser instead of a camera.
        last = controls.frame.stamp if controls.frame else self._last_scan or 0.0
        overdue = reading.stamp - last > max(FRAME_OVERDUE, 3 * self._meter.frame_period)
        # A reported fault says more.
        overdue = overdue and controls.follower.needs_camera and not reading.faults
        silent = phrase("The camera sends no pictures.")
        if controls.frame is None and self._last_scan is not None:
            silent = phrase("The laser sends no scans.")
        controls.report("camera", silent if overdue else None)

    def _rest(self, odometry: OdometryState, taken: tuple[Command, ...]) -> None:
        """Let the camera rest, or wake it."""
        controls = self.controls
        if taken:  # it may have moved the robot, or what is believed of it
            self._standstill = Standstill()
        stood = self._standstill.seconds(odometry.odom_from_robot, odometry.stamp)
        rate = self.audience.rate
        rests = (
            stood >= STANDS_S
            and controls.driving.mode == "idle"
            and controls.follower.settled
            and not (rate > PAGE_HZ or self.every.subscribed)
            and not self._companions.need_pictures
        )
        period = WATCHED_PERIOD if rate > 0 else RESTING_PERIOD
        self._resting = period if rests else 0.0
        if rests:
            self._woke = odometry.stamp
        if self._resting_robot is not None:
            self._resting_robot.rest(self._resting, self.commands.__len__)

    def _measure(self, seen: Frame | Scan) -> None:
        controls = self.controls
        try:
            exposed = controls.odometry.at(seen.stamp)
        except LookupError as error:
            controls.report("delay", f"A picture came too late to be used: {error}.")
            return
        controls.report("delay", None)
        controls.odom_from_scan = exposed.odom_from_robot
        controls.follower.measure(seen, exposed)

    def _snapshot(
        self,
        reading: Reading,
        taken: tuple[Command, ...],
        odometry: OdometryState,
        applied: Twist2,
    ) -> Snapshot:
        controls, follower = self.controls, self.controls.follower
        belief = follower.belief
        scan_pose = None
        # Use the stored odometry of the scan: if the camera stalls, the odometry's history no
        # longer has that stamp.
        if belief is not None and controls.odom_from_scan is not None:
            scan_pose = belief.pose(controls.odom_from_scan)
        return Snapshot(
            stamp=reading.stamp,
            published=time.monotonic(),
            reading=reading,
            spec=controls.spec,
            calibrated=controls.calibrated,
            commands=taken,
            truth=reading.truth,
            odometry=controls.map_from_odom @ odometry.odom_from_robot,
            odom_from_robot=odometry.odom_from_robot,
            pose=belief.pose(odometry.odom_from_robot) if belief else None,
            estimate=belief.estimate if belief else None,
            integrity=follower.integrity_at(odometry.odom_from_robot),
            twist=applied,
            mode=controls.driving.mode,
            frame=controls.frame,
            filter=follower.shown,
            odom_from_scan=controls.odom_from_scan,
            scan_pose=scan_pose,
            loop=self._meter.end(reading.stamp),
            connected=reading.connected,
            battery_v=reading.battery_v,
            problems=controls.problems.shown,
            layers=controls.layers,
            drawn=self.drawn.get(),
            route=controls.driving.goal,
            added=self._companions.shown(controls),
            faults=controls.faults,
        )


def _require_sound(name: str, values: Array, joints: int) -> None:
    """Refuse an answer of the robot that would make everything after it unknown.

    Raises:
        RobotError: names what is not a number for each joint.
    """
    if np.shape(values) != (joints,) or not all(map(math.isfinite, values)):
        given = np.asarray(values).tolist()
        raise RobotError(f"the robot's {name} are {given}; valid are {joints} finite numbers")


def _exposed(frame: Frame | None, delay: float) -> Frame | None:
    """Return a picture with the stamp of its exposure, which it was stamped later than."""
    return frame if frame is None or delay == 0 else Frame(frame.stamp - delay, frame.image)
