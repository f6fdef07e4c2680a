"""Saves the map that was drawn, and switches to it."""

from __future__ import annotations

from app.console import say
from app.engine.driver import Driver
from app.engine.program import Program
from app.features.mapping.map_drawer import MapDrawer
from app.features.mapping.messages import SaveMapCommand
from app.page.program_changes import ProgramChanges
from app.settings.config import MAPS
from robot.errors import CommandError
from robot.fields.field import FieldError
from robot.fields.field_loading import load_field


class MapSaver:
    """Saves maps of one program."""

    def __init__(self, program: Program, drawer: MapDrawer, changes: ProgramChanges) -> None:
        """Prepare to save.

        Args:
            program: the program.
            drawer: draws its map.
            changes: switches to another map.
        """
        self._engine = program.engine
        self._drawer = drawer
        self._changes = changes
        self._maps = program.config.mapping.path()

    def save(self, driver: Driver, command: SaveMapCommand) -> None:
        """Save the map that was drawn, and switch to it if that is requested.

        Raises:
            CommandError: there is no map, it contradicts itself, it cannot be saved, or another
                client drives.
        """
        newest, change_map = self._engine.latest.get(), self._changes.change_map
        if command.use and (newest is None or change_map is None):
            raise CommandError(
                "this program cannot switch to another map; save it, and start again"
            )
        if command.use:
            self._changes.require_free(driver)
            self._drawer.require_done()
        path = self._drawer.save(command.name, self._maps, force=command.force)
        say(f"The map is {path}")
        if command.use:
            assert newest is not None and change_map is not None  # it was refused else
            place = self._drawer.place(newest)
            try:
                field = load_field(str(path), MAPS)
                field.require_inside(place.pose)
            except FieldError as error:
                raise CommandError(f"the map is saved, but the robot is off it: {error}") from error
            change_map(str(path), field, place)
