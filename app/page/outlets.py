"""Outputs of the program besides the page: recordings, ROS 2, Foxglove, calibrations, maps."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from datetime import UTC, datetime
from types import MappingProxyType
from typing import Any, Protocol

from app.console import say
from app.engine.drive_calibrator import DriveCalibrator
from app.engine.drivers import Driver, Drivers
from app.engine.mapping.map_drawer import MapDrawer
from app.engine.program import Program
from app.messages.commands import (
    CloseRecordingCommand,
    Command,
    OpenRecordingCommand,
    RecordCommand,
    RunAgainCommand,
    UseFieldCommand,
)
from app.messages.driving_commands import (
    CalibrateCommand,
    FinishCalibrationCommand,
    UndoCalibrationCommand,
)
from app.messages.map_commands import (
    DeleteStrokeCommand,
    DiscardMapCommand,
    ExploreCommand,
    FinishMapCommand,
    JoinStrokesCommand,
    MoveEndCommand,
    PauseMapCommand,
    SaveMapCommand,
    StartMapCommand,
)
from app.page.program_changes import ChangeMap, GoOn, ProgramChanges
from app.recordings.contents import contents_of
from app.recordings.recorder import Recorder
from app.ros2.inbox import Inbox
from app.ros2.publisher import TopicPublisher
from app.ros2.source import TopicSource
from app.ros2.websocket_routes import Foxglove, Rosbridge


class LiveRoute(Protocol):
    """An output that runs as long as the program."""

    @property
    def failure(self) -> str | None:
        """The current problem of the output; None without one."""
        ...

    def start(self) -> None:
        """Start; an error says why it cannot."""
        ...

    def close(self) -> None:
        """End the output; may be called twice."""
        ...


class Outlets:
    """All outputs of one program; the settings say which of them run."""

    def __init__(
        self, program: Program, change_map: ChangeMap | None = None, go_on: GoOn | None = None
    ) -> None:
        """Prepare the outputs of a program.

        Args:
            program: the program.
            change_map: switches to the map of another program.
            go_on: switches to another program, with another robot.
        """
        config = program.config
        self.drivers = Drivers.of(program)
        self.calibrator = DriveCalibrator(program, lambda: datetime.now(UTC))
        self.mapping = MapDrawer(program)
        self.publisher = TopicPublisher(TopicSource.of(program), program.engine.every)
        self.inbox = Inbox(program, self.publisher.source, self.drivers, self.carry_out)
        self.recorder = Recorder(
            self.publisher, config.recording, lambda: contents_of(program), datetime.now
        )
        self.changes = ProgramChanges(
            program, self.drivers, self.mapping, self.recorder, change_map, go_on
        )
        self.rosbridge = Rosbridge(self.publisher, self.inbox)
        self.foxglove = Foxglove(self.publisher, self.inbox, config.ros2)
        self._record = config.recording.record
        self._routes = tuple(self._live_routes(program))

    def _live_routes(self, program: Program) -> Iterator[LiveRoute]:
        settings, host = program.config.ros2, program.config.host
        if settings.dds:
            from app.ros2.dds.route import DdsRoute  # noqa: PLC0415

            yield DdsRoute(self.publisher, self.inbox, settings, host)

    def start(self) -> None:
        """Start all outputs that the settings ask for.

        Raises:
            BrickPoseError: an output is not available; the message says what to do.
        """
        try:
            for route in self._routes:
                route.start()
            if self._record:
                say(f"Recording to {self.recorder.start()}")
        except Exception:
            self.close()
            raise

    def carry_out(self, driver: Driver, command: Command) -> None:
        """Carry out a checked command, or pass it on to the engine.

        Raises:
            BrickPoseError: the command cannot be carried out; the message says why.
        """
        act = ACTS.get(type(command))
        if act is None:
            self.drivers.put(driver, command)
        else:
            act(self, driver, command)

    def record(self, enabled: bool) -> None:
        """Start a recording, or end the running one.

        Raises:
            RecordingError: a recording is running already, or cannot be written.
        """
        if enabled:
            self.recorder.start()
        else:
            self.recorder.stop()

    def calibrate(self, driver: Driver, command: CalibrateCommand) -> None:
        """Start the drive that calibrates the robot.

        Raises:
            CommandError: somebody else drives, or the last drive is not adjusted yet.
        """
        if command.start:
            self.calibrator.require_collected()
        self.drivers.put(driver, command)
        if command.start:
            self.calibrator.begin()

    def explore(self, driver: Driver, command: ExploreCommand) -> None:
        """Let the robot explore what the map lacks; begin a map if there is none.

        Raises:
            CommandError: somebody else drives, or the map is finished.
        """
        if command.start:
            self.drivers.require_free(driver)
            self.mapping.explore()
        self.drivers.put(driver, command)

    @property
    def failures(self) -> list[str]:
        """The current problems, in words."""
        given = [route.failure for route in self._routes]
        return [words for words in (*given, self.publisher.failure) if words is not None]

    def close(self) -> None:
        """End all outputs, and wait until the recording is written; may be called twice."""
        self.calibrator.close()
        self.mapping.close()
        self.recorder.close()
        for route in self._routes:
            route.close()
        self.publisher.close()


ACTS: Mapping[type[Command], Callable[[Outlets, Driver, Any], None]] = MappingProxyType(
    {
        OpenRecordingCommand: lambda outlets, driver, command: outlets.changes.open_recording(
            driver, command.name
        ),
        RunAgainCommand: lambda outlets, driver, _: outlets.changes.run_again(driver),
        CloseRecordingCommand: lambda outlets, *_: outlets.changes.close_recording(),
        RecordCommand: lambda outlets, _, command: outlets.record(command.on),
        CalibrateCommand: lambda outlets, driver, command: outlets.calibrate(driver, command),
        FinishCalibrationCommand: lambda outlets, *_: outlets.calibrator.finish(),
        UndoCalibrationCommand: lambda outlets, *_: outlets.calibrator.undo(),
        StartMapCommand: lambda outlets, _, command: outlets.mapping.begin(
            discard=command.discard, paused=command.paused
        ),
        PauseMapCommand: lambda outlets, _, command: outlets.mapping.pause(command.paused),
        FinishMapCommand: lambda outlets, *_: outlets.mapping.finish(),
        DeleteStrokeCommand: lambda outlets, _, command: outlets.mapping.delete_stroke(
            command.stroke, command.version
        ),
        MoveEndCommand: lambda outlets, _, command: outlets.mapping.move_end(
            command.stroke, command.last, (command.x, command.y), command.version
        ),
        JoinStrokesCommand: lambda outlets, _, command: outlets.mapping.join_strokes(
            command.stroke, command.other, command.version
        ),
        ExploreCommand: lambda outlets, driver, command: outlets.explore(driver, command),
        DiscardMapCommand: lambda outlets, *_: outlets.mapping.discard(),
        SaveMapCommand: lambda outlets, driver, command: outlets.changes.save_map(driver, command),
        UseFieldCommand: lambda outlets, driver, command: outlets.changes.use_field(
            driver, command
        ),
    }
)
"""Return what carries out each command that is not for the engine."""
