"""Navigation: waits for the first journey in an engine, and then has a pilot."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

from app.engine.controls import Controls
from app.features.navigation.journey import Journey
from app.messages.commands import Command
from app.settings.config import Config
from robot.fields.field import Field
from robot.geometry import Pose2
from robot.interface import Reading, Robot

if TYPE_CHECKING:
    from app.features.navigation.pilot import Pilot
    from robot.navigation.navigation_status import NavigationStatus


def companions(config: Config, robot: Robot, field: Field) -> tuple[Navigation, ...]:
    """Return what navigates in a new engine."""
    # A robot that says nothing of it is a real one.
    return (Navigation(config, field, waits=not getattr(robot, "in_real_time", True)),)


class Navigation:
    """Goes along with one engine; whoever never sends a goal loads nothing of navigation."""

    def __init__(self, config: Config, field: Field, *, waits: bool) -> None:
        """Prepare; ``waits`` for plans where robot time outruns the clock, so drives repeat."""
        self._waits = waits
        self._config = config
        self._field = field
        self._pilot: Pilot | None = None

    @property
    def shown(self) -> NavigationStatus | None:
        """The state of the journey; None before the first."""
        return None if self._pilot is None else self._pilot.shown

    @property
    def needs_pictures(self) -> bool:
        """Whether the camera must not rest."""
        return self._pilot is not None and self._pilot.needs_pictures

    def commands(self, odom_from_robot: Pose2, controls: Controls) -> Iterable[Command]:
        """Tell recordings of a journey that ended before its goal."""
        return self._pilot.commands(controls) if self._pilot else ()

    def add(self, reading: Reading, controls: Controls) -> None:
        """Set the velocity of this tick, if there is a journey."""
        if self._pilot is None and isinstance(controls.driving.programme, Journey):
            from app.features.navigation.pilot import Pilot  # noqa: PLC0415 - the first goal

            self._pilot = Pilot(self._config, self._field, reading.stamp, waits=self._waits)
        if self._pilot is not None:
            self._pilot.add(reading, controls)

    def close(self) -> None:
        """End the pilot's thread."""
        if self._pilot is not None:
            self._pilot.close()
