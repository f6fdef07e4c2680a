"""What runs as long as a program besides the page, as features add it: recordings, topics, maps."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from contextlib import suppress
from typing import TYPE_CHECKING, Any, Protocol, TypeVar, cast

from app.engine.command_row import Part, Request
from app.engine.commands import row_of
from app.engine.driver import Driver
from app.engine.drivers import Drivers
from app.engine.plugging import plugged
from app.engine.problems import LOG, failing_alone
from app.engine.program import Program
from app.engine.values import value_failures
from app.feature import Feature
from app.feature_search import reason_of
from app.languages.marking import phrase
from app.messages.commands import Command
from app.page.commands import CHANGES
from app.page.program_changes import ChangeMap, GoOn, ProgramChanges
from robot.errors import BrickPoseError

if TYPE_CHECKING:
    from fastapi import APIRouter

    from app.engine.snapshot import Snapshot
    from app.page.view.scene import NewViewLayer


class Closable(Protocol):
    """What has an end."""

    def close(self) -> None:
        """End it; may be called twice."""
        ...


MEMBERS = frozenset(
    {"recording", "calibration", "mapping", "navigation", "walls", "misplaced_tape", "replay"}
)
"""Members of ``TelemetryMessage`` that outlets fill; what is new is a ``Value``."""
T = TypeVar("T")
C = TypeVar("C", bound=Closable)


class Outlet:
    """What a feature runs as long as a program; it overrides what it needs."""

    @property
    def parts(self) -> Mapping[str, object]:
        """What carries out the feature's commands, by the names of their ``Part``."""
        return {}

    @property
    def failures(self) -> Iterable[str]:
        """The current problems, for people."""
        return ()

    @property
    def handed_on(self) -> object:
        """What the outlet of the next program has to know; ``Program.handed_on`` has it there."""
        return None

    def routers(self) -> Iterable[APIRouter]:
        """Return routes for the page's server."""
        return ()

    def telemetry(self, snapshot: Snapshot) -> Mapping[str, Any]:
        """Return members of ``TelemetryMessage`` for a tick, of those that outlets fill."""
        return {}

    def view_layers(self) -> Iterable[NewViewLayer]:
        """Return what makes layers of the 3D view."""
        return ()

    def require_endable(self) -> None:
        """Raise a CommandError if something would be lost, were the program to end for another."""

    def start(self) -> None:
        """Start what the settings ask for.

        Raises:
            BrickPoseError: it is not available; the message says what to do.
        """

    def close(self) -> None:
        """End it; may be called twice."""


class Outlets:
    """The outlets of one program, and what carries out its commands."""

    def __init__(
        self,
        program: Program,
        change_map: ChangeMap | None = None,
        go_on: GoOn | None = None,
    ) -> None:
        """Prepare the outlets of a program.

        Args:
            program: the program.
            change_map: switches to the map of another program.
            go_on: switches to another program, with another robot.
        """
        self.program = program
        self.drivers = Drivers.of(program)
        self.changes = ProgramChanges(
            program, self.drivers, self._require_endable, change_map, go_on
        )
        self._parts: dict[str, object] = {CHANGES.name: self.changes}
        self._shared: dict[str, Closable] = {}
        self._outlets: dict[str, Outlet] = {}
        """By the names of their features."""
        self._routes: dict[str, str] = {}
        """How each route failed last, by its path."""
        _, self._broken = plugged().features.made(self._add)

    def _add(self, feature: Feature) -> tuple[()]:
        if feature.outlet is None:
            return ()
        outlet = feature.outlet(self)
        for name in outlet.parts:
            if name in self._parts:
                raise ValueError(f"there is a part {name!r} already")
        self._parts.update(outlet.parts)
        self._outlets[feature.name] = outlet
        return ()

    def shared(self, part: Part[C], make: Callable[[], C]) -> C:
        """Return a part that several features use: the first to ask makes it, and it ends last."""
        if part.name not in self._parts:
            made = make()
            self._parts[part.name] = made
            self._shared[part.name] = made
        return cast(C, self._parts[part.name])

    def part(self, part: Part[T]) -> T | None:
        """Return a part of the program; None if the feature that has it does not take part."""
        return cast("T | None", self._parts.get(part.name))

    def start(self) -> None:
        """Start all outlets.

        Raises:
            BrickPoseError: what the settings ask for is not available; the message says what to do.
        """
        try:
            self._of_each(_started, refusals=(BrickPoseError,))
        except Exception:
            self.close()
            raise

    def carry_out(self, driver: Driver, command: Command) -> None:
        """Carry out a checked command of a client.

        Raises:
            BrickPoseError: the command cannot be carried out; the message says why.
        """
        row_of(command).act(Request(command, driver, self.drivers, self._parts))

    @property
    def failures(self) -> list[str]:
        """The current problems of features, in words."""
        present = self._of_each(lambda outlet: outlet.failures)
        routes = self._routes.values()
        return [*self.program.complaints, *self._broken, *present, *value_failures(), *routes]

    def note_route(self, path: str, error: Exception) -> str:
        """Return that a route failed, in words; from now on it is a problem."""
        self._routes[path] = phrase(f"The address {path} failed: {reason_of(error)}.")
        return self._routes[path]

    def handed_on(self) -> dict[str, object]:
        """Return what the outlets of the next program have to know, by the features' names."""
        return {name: outlet.handed_on for name, outlet in self._outlets.items()}

    def routers(self) -> list[APIRouter]:
        """Return routes for the page's server."""
        return self._of_each(lambda outlet: outlet.routers())

    def telemetry(self, snapshot: Snapshot) -> dict[str, Any]:
        """Return members of ``TelemetryMessage`` for a tick."""
        return dict(self._of_each(lambda outlet: _members(outlet.telemetry(snapshot))))

    def view_layers(self) -> list[NewViewLayer]:
        """Return what makes layers of the 3D view."""
        return self._of_each(lambda outlet: outlet.view_layers())

    def _require_endable(self) -> None:
        for outlet in self._outlets.values():
            outlet.require_endable()

    def _of_each(
        self,
        read: Callable[[Outlet], Iterable[T]],
        refusals: tuple[type[Exception], ...] = (),
    ) -> list[T]:
        """Collect from all outlets; a feature that fails is named, and asked no more.

        Refusals are raised instead: they tell what was asked for and cannot be had.
        """
        collected: list[T] = []
        for name, outlet in tuple(self._outlets.items()):
            try:
                collected += read(outlet)
            except refusals:
                raise
            except Exception as error:
                LOG.exception("the feature %s failed", name)
                self._broken.append(_failure(name, error))
                self._outlets.pop(name, None)
                self._take_away(outlet)
                with failing_alone(name):
                    outlet.close()
        return collected

    def _take_away(self, outlet: Outlet) -> None:
        """Let commands find no part of an outlet that has failed, and may fail in this, too."""
        with suppress(Exception):
            for name in outlet.parts:
                self._parts.pop(name, None)

    def close(self) -> None:
        """End all outlets, and wait until a recording is written; may be called twice."""
        for name, part in (*self._outlets.items(), *reversed(self._shared.items())):
            with failing_alone(name):
                part.close()


def _members(telemetry: Mapping[str, Any]) -> Iterable[tuple[str, Any]]:
    """Return what an outlet tells, if telemetry has a place for it.

    Raises:
        ValueError: it has none, or one that the core fills.
    """
    for name in telemetry.keys() - MEMBERS:
        raise ValueError(f"telemetry takes no {name!r}; valid are {', '.join(sorted(MEMBERS))}")
    return telemetry.items()


def _started(outlet: Outlet) -> tuple[()]:
    outlet.start()
    return ()


def _failure(name: str, error: Exception) -> str:
    why = reason_of(error)
    return phrase(f"The feature {name} has failed: {why}.")
