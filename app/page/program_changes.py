"""Switches to another field, to the map that was drawn, to a recording, or back to the robot."""

from __future__ import annotations

from collections.abc import Callable

from app.console import say
from app.engine.drivers import Driver, Drivers
from app.engine.mapping.map_drawer import MapDrawer
from app.engine.program import Program
from app.messages.commands import UseFieldCommand
from app.messages.map_commands import SaveMapCommand
from app.recordings.library import find
from app.recordings.recorder import Recorder
from app.recordings.replay.opening import ReplayProgram
from app.recordings.replay.succession import replay_after, robot_again, run_again
from app.settings.config import MAPS
from app.settings.field_names import field_named
from robot.errors import CommandError
from robot.fields.field import FieldError
from robot.fields.field_loading import load_field
from robot.localization.estimate import Hypothesis

ChangeMap = Callable[[str, Hypothesis | None], None]
"""Switches to another map by its name, with the robot's place in it; None is the field's start."""
GoOn = Callable[[Callable[[], Program]], None]
"""Ends this program soon, and continues with the program that the function then builds."""


class ProgramChanges:
    """Ends a program for another one, if no other client drives and no map would be lost."""

    def __init__(
        self,
        program: Program,
        drivers: Drivers,
        drawer: MapDrawer,
        recorder: Recorder,
        change_map: ChangeMap | None = None,
        go_on: GoOn | None = None,
    ) -> None:
        """Prepare the changes of a program.

        Args:
            program: the program.
            drivers: who drives it.
            drawer: draws its map.
            recorder: records it.
            change_map: switches to another map; None if that is not possible.
            go_on: switches to another program, with another robot; None if that is not possible.
        """
        self._program = program
        self._drivers = drivers
        self._drawer = drawer
        self._recorder = recorder
        self._change_map = change_map
        self._go_on = go_on
        self._maps = program.config.mapping.path()

    def save_map(self, driver: Driver, command: SaveMapCommand) -> None:
        """Save the map that was drawn, and switch to it if that is requested.

        Raises:
            CommandError: there is no map, it cannot be saved, or another client drives.
        """
        newest = self._program.engine.latest.get()
        if command.use and (newest is None or self._change_map is None):
            raise CommandError(
                "this program cannot switch to another map; save it, and start again"
            )
        if command.use:
            self._drivers.require_free(driver)
            self._drawer.require_done()
        path = self._drawer.save(command.name, self._maps)
        say(f"The map is {path}")
        if command.use:
            assert newest is not None and self._change_map is not None  # it was refused else
            place = self._drawer.place(newest)
            try:
                load_field(str(path), MAPS).require_inside(place.pose)
            except FieldError as error:
                raise CommandError(f"the map is saved, but the robot is off it: {error}") from error
            self._change_map(str(path), place)

    def use_field(self, driver: Driver, command: UseFieldCommand) -> None:
        """Switch to another field.

        Raises:
            CommandError: there is no such field, another client drives, or a map would be lost.
        """
        if self._change_map is None:
            raise CommandError("this program cannot load another field; start it again")
        self._require_idle(driver)
        name = field_named(command.name, self._maps)
        try:
            load_field(name, MAPS)
        except FieldError as error:
            raise CommandError(str(error)) from error
        self._change_map(name, None)

    def open_recording(self, driver: Driver, name: str) -> None:
        """Replay a recording in place of the robot.

        Raises:
            BrickPoseError: it cannot be replayed, another client drives, or a map would be lost.
        """
        if self._go_on is None:
            raise CommandError("this program cannot open a recording; brickpose replay does")
        self._require_idle(driver)
        item = find(self._program.config.recording.path(), name)
        following = replay_after(self._program, item.file.parent)
        following.replay.begin()
        self._go_on(lambda: following)

    def run_again(self, driver: Driver) -> None:
        """Replay the last recording with the current parameters; a running recording ends first.

        Raises:
            BrickPoseError: nothing was recorded; also the errors of ``open_recording``.
        """
        if self._go_on is None or self._recorder.folder is None:
            raise CommandError("nothing is recorded of this drive; record, drive, and run it again")
        self._require_idle(driver)
        self._recorder.close()
        following = run_again(self._program, self._recorder.folder)
        following.replay.begin()
        self._go_on(lambda: following)

    def close_recording(self) -> None:
        """Go back to the robot that the recording was opened from.

        Raises:
            CommandError: this program began with the recording.
        """
        program = self._program
        before = program.before if isinstance(program, ReplayProgram) else None
        if before is None or self._go_on is None:
            raise CommandError("there is no robot to go back to; brickpose run starts one")
        self._go_on(lambda: robot_again(program, before))

    def _require_idle(self, driver: Driver) -> None:
        self._drivers.require_free(driver)
        self._drawer.require_none_lost()
