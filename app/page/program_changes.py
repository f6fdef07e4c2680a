"""Switches to another field, or to another program with another robot."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from app.engine.driver import Driver
from app.engine.drivers import Drivers
from app.engine.program import Program
from app.foreign_files import read_apart
from app.messages.commands import UseFieldCommand
from app.settings.config import MAPS
from app.settings.field_names import field_named
from robot.errors import CommandError
from robot.fields.field import Field, FieldError
from robot.fields.field_loading import load_field
from robot.localization.estimate import Hypothesis

ChangeMap = Callable[[str, Field, Hypothesis | None], None]
"""Switches to a map, by name and content, with the robot's place in it; None is its start."""
GoOn = Callable[[Callable[[], Program]], None]
"""Ends this program soon, and continues with the program that the function then builds."""


class ProgramChanges:
    """Ends a program for another one, if no other client drives and nothing would be lost."""

    def __init__(
        self,
        program: Program,
        drivers: Drivers,
        require_endable: Callable[[], None],
        change_map: ChangeMap | None = None,
        go_on: GoOn | None = None,
    ) -> None:
        """Prepare the changes of a program.

        Args:
            program: the program.
            drivers: who drives it.
            require_endable: raises a CommandError if something would be lost.
            change_map: switches to another map; None if that is not possible.
            go_on: switches to another program, with another robot; None if that is not possible.
        """
        self.change_map = change_map
        self.go_on = go_on
        self._drivers = drivers
        self._require_endable = require_endable
        self._maps = program.config.mapping.path()

    def use_field(self, driver: Driver, command: UseFieldCommand) -> None:
        """Switch to another field.

        Raises:
            CommandError: there is no such field, another client drives, or a map would be lost.
        """
        if self.change_map is None:
            raise CommandError("this program cannot load another field; start it again")
        self.require_idle(driver)
        name = field_named(command.name, self._maps)
        own = Path(name).suffix == ""
        try:
            field = load_field(name, MAPS) if own else read_apart(_load, Path(name))
        except FieldError as error:
            raise CommandError(str(error)) from error
        self.change_map(name, field, None)

    def require_free(self, driver: Driver) -> None:
        """Raise a CommandError if another client drives."""
        self._drivers.require_free(driver)

    def require_idle(self, driver: Driver) -> None:
        """Refuse to end the program while another client drives, or if something would be lost.

        Raises:
            CommandError: says which.
        """
        self.require_free(driver)
        self._require_endable()


def _load(path: Path) -> Field:
    return load_field(str(path), MAPS)
