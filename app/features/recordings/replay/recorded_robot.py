"""A recording as a robot: it replays the recorded readings, and ignores wheel commands."""

from __future__ import annotations

import contextlib
from collections.abc import Generator
from dataclasses import replace
from pathlib import Path

import numpy as np

from app.features.recordings.files.mcap_reader import RecordingReader
from app.features.recordings.files.recorded import RecordingError
from app.features.recordings.replay.decoding import (
    commands_of,
    joints_of,
    picture_of,
    pose_and_covariance_of,
    require_commands,
    set_pose_of,
    truth_of,
    twist_of,
)
from app.features.recordings.replay.position import BAD, NextTick, ReadPosition, TickMessages
from app.features.recordings.replay.ticks import RecordedTick, RecordedTopics, joined, ticks
from app.messages.commands import Command
from robot.description.spec import RobotSpec
from robot.driving.differential_drive import DifferentialDrive
from robot.geometry import Array, Pose2
from robot.interface import Frame, Reading, Robot, RobotError


class RecordedRobot:
    """Satisfies ``Robot``; can go to any position of the recording where it has been before."""

    in_real_time = False

    def __init__(
        self,
        reader: RecordingReader,
        topics: RecordedTopics,
        spec: RobotSpec,
        drive: DifferentialDrive,
        name: str,
    ) -> None:
        """Start at the beginning.

        Raises:
            RecordingError: no joint_states message can be used; says why.
        """
        self.name = name
        self.spec = spec
        self.reader = reader
        self.topics = topics
        self.at = ReadPosition()
        """How far it was read. It is not named ``place``, which is what a simulator offers."""
        self.recorded_estimate: tuple[float, Pose2] | None = None
        """Stamp [s] and pose of the recorded estimate, if the last tick has one."""
        self.damage = ""
        """Why the recording ends early; empty if it does not."""
        self._drive = drive
        self._names = [joint.name for joint in spec.joints]
        self._applied = np.zeros(len(spec.joints))
        self._messages = self._ticks_from(0)
        self._next = self._fetched()
        if self._next is None:
            raise RecordingError(f"{reader.path} has no joint_states that can be used{self._why()}")
        self.start_ns = self._next.tick.log_ns
        """Time of the first tick."""

    @property
    def engine(self) -> str | None:
        """Name and version of the physics engine that moved it; None: none did, or none is told."""
        return self.reader.metadata.get("brickpose", {}).get("engine") or None

    @property
    def next_ns(self) -> int | None:
        """Time of the next tick; None at the end."""
        return None if self._next is None else self._next.tick.log_ns

    def go_to(self, position: ReadPosition) -> None:
        """Go to a position where it was before."""
        if position.log_ns == self.at.log_ns:
            return
        self._messages.close()
        self.at = position
        self.damage = ""
        self._messages = self._ticks_from(position.log_ns + 1)
        self._next = self._fetched()

    def commands(self) -> tuple[Command, ...]:
        """The recorded commands of the next tick."""
        if self._next is None:
            return ()
        commands: list[Command] = []
        for topic, cdr in self._next.tick.commands:
            # ``read`` reports what cannot be read.
            with contextlib.suppress(*BAD):
                if topic == self.topics.command:
                    commands.extend(commands_of(cdr))
                else:
                    commands.append(set_pose_of(cdr))
        return tuple(commands)

    def read(self) -> Reading:
        """Return the reading of the next tick.

        Raises:
            RobotError: the recording is over.
        """
        if self._next is None:
            raise RobotError(f"the recording is over{self._why()}")
        item, self._next = self._next, None
        reading = self._reading(item)
        self._next = self._fetched()
        if self._next is None and self.damage:
            over = f"The recording is over here: {self.damage}."
            return replace(reading, faults=(*reading.faults, over))
        return reading

    def write(self, velocities: Array) -> Array:
        """Command nothing; return the joint velocities (j,) [rad/s] applied in the recording."""
        return self._applied.copy()

    def close(self) -> None:
        """Close the recording."""
        self._messages.close()
        self._next = None
        self._applied = np.zeros(len(self._names))

    def _ticks_from(self, start_ns: int) -> Generator[RecordedTick, None, None]:
        return ticks(self.reader.messages(self.topics.names, start_ns), self.topics)

    def _why(self) -> str:
        return f": {self.damage}" if self.damage else ""

    def _fetched(self) -> NextTick | None:
        """Return the next usable tick, with the messages of unusable ticks before it."""
        before: list[RecordedTick] = []
        trouble = ""
        try:
            for tick in self._messages:
                try:
                    stamp, positions, velocities = joints_of(tick.joints, self._names)
                except BAD as error:
                    self.damage = trouble = str(error)
                    before.append(tick)
                    continue
                if self.at.log_ns >= 0 and stamp + self.at.shift_ns == self.at.now_ns:
                    before.append(tick)  # the same joint_states again
                    continue
                self.damage = ""
                return NextTick(joined(before, tick), stamp, positions, velocities, trouble)
        except RecordingError as error:
            self.damage = str(error)
        return None

    def _reading(self, next_tick: NextTick) -> Reading:
        before, position = self.at, self.at.after(next_tick)
        turned = before.turned(next_tick, position)
        measured = next_tick.velocities
        if measured is None:
            measured = turned / max((position.now_ns - before.now_ns) / 1e9, 1e-3)
        given = TickMessages(next_tick)
        position = position.moved(self._drive.moved(turned)).with_status(given, self.topics)
        position = self._with_truth(given, before, position, turned)
        frame = self._frame(given, position.shift_ns)
        if frame is not None:
            position = replace(position, picture_log_ns=next_tick.tick.log_ns)
        self._tell_then(given, position.shift_ns)
        self._tell_applied(given, measured)
        if given.trouble:
            position = position.troubled(f"In the recording, {given.trouble}.")
        missing = self.reader.damage_between(before.log_ns, next_tick.tick.log_ns)
        if missing is not None:
            position = position.troubled(f"In the recording, {missing}.")
        self.at = position
        return Reading(
            position.now_ns / 1e9,
            next_tick.positions + position.ahead,
            measured,
            frame,
            position.battery_v,
            position.truth,
            position.connected,
            (*position.faults, *position.troubles),
        )

    def _with_truth(
        self, messages: TickMessages, before: ReadPosition, position: ReadPosition, turned: Array
    ) -> ReadPosition:
        result = messages.of(self.topics.truth, truth_of)
        if result is None:
            return position
        # The truth may be late, and belong to the tick before: the wheels carry it forward.
        late = position.now_ns - result[0] - position.shift_ns
        part = min(max(late / max(position.now_ns - before.now_ns, 1), 0.0), 2.0)
        truth = result[1] @ self._drive.moved(part * turned)
        return replace(position, truth=truth, truth_ns=position.now_ns)

    def _frame(self, messages: TickMessages, shift_ns: int) -> Frame | None:
        lens = self.spec.lens
        result = messages.of(
            self.topics.picture, lambda cdr: picture_of(cdr, (lens.height, lens.width))
        )
        return None if result is None else Frame((result[0] + shift_ns) / 1e9, result[1])

    def _tell_then(self, messages: TickMessages, shift_ns: int) -> None:
        result = messages.of(self.topics.amcl_pose, pose_and_covariance_of)
        self.recorded_estimate = (
            None if result is None else ((result[0] + shift_ns) / 1e9, result[1])
        )

    def _tell_applied(self, messages: TickMessages, measured: Array) -> None:
        twist = messages.of(self.topics.cmd_vel, twist_of)
        self._applied = measured if twist is None else self._drive.wheels(twist)
        for topic, cdr in messages.tick.commands:
            messages.read(require_commands if topic == self.topics.command else set_pose_of, cdr)


def replayed(robot: Robot) -> Path | None:
    """Return the file or folder that a robot replays; None if it is no recording."""
    return robot.reader.path if isinstance(robot, RecordedRobot) else None
