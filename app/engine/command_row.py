"""A row of the table of commands: how commands of one type are checked, carried out, repeated."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from enum import Enum, auto
from types import MappingProxyType
from typing import Any, Generic, Protocol, TypeVar, cast, get_args

from app.engine.controls import Controls
from app.engine.driver import Driver
from app.engine.localization import Localization
from app.engine.program import Program
from app.messages.message import CommandMessage
from robot.driving.odometry import OdometryState
from robot.errors import CommandError
from robot.fields.field import Field

C = TypeVar("C", bound=CommandMessage)
T = TypeVar("T")


class Repeat(Enum):
    """How a replay repeats a recorded command, and how long a viewer's own command holds there."""

    NEVER = auto()
    """Not repeated: a recording cannot be driven; or the filter does not need the command."""
    RECORDED = auto()
    """Carried out as recorded."""
    MOMENT = auto()
    """Carried out as recorded; a viewer's own command holds until somebody seeks."""
    SETTING = auto()
    """Carried out as recorded, but a viewer's own command overrides it for the whole replay."""


@dataclass(frozen=True, slots=True)
class TickContext(Generic[C]):
    """A command in the engine's thread, between a reading and its picture."""

    command: C
    controls: Controls
    """What the command may act on."""
    odometry: OdometryState

    @property
    def localization(self) -> Localization:
        """Scanner and filter."""
        return self.controls.localization


@dataclass(frozen=True, slots=True)
class Part(Generic[T]):
    """The name of a part of a program that carries out commands, as what draws maps."""

    name: str


class Arbiter(Protocol):
    """Decides which client drives, and passes commands on to the engine: ``Drivers``."""

    def put(self, driver: Driver, command: CommandMessage) -> None:
        """Pass a client's command on; a CommandError says why it may not drive."""
        ...

    def renew(self, driver: Driver, command: CommandMessage) -> bool:
        """Pass on what continues a client's drive; False if it no longer drives."""
        ...

    def require_free(self, driver: Driver) -> None:
        """Raise a CommandError if another client drives."""
        ...


@dataclass(frozen=True, slots=True)
class Request(Generic[C]):
    """A checked command in the thread of the client that sent it."""

    command: C
    driver: Driver
    """The client."""
    arbiter: Arbiter
    parts: Mapping[str, object]

    def part(self, part: Part[T]) -> T:
        """Return a part of the program.

        Raises:
            CommandError: this program does not have it.
        """
        if part.name not in self.parts:
            raise CommandError(f"this program runs without the {part.name}")
        return cast(T, self.parts[part.name])

    def pass_on(self) -> None:
        """Pass the command on to the engine.

        Raises:
            CommandError: another client drives, or a stop holds.
        """
        self.arbiter.put(self.driver, self.command)


def nothing(*_: object) -> None:
    """Check or carry out nothing."""


@dataclass(frozen=True)
class CommandRow:
    """How commands of one type are checked, carried out and repeated.

    A row stands with what carries the command out. It is carried out in the program, by ``act``, if
    it has that, or else in the engine, by ``apply``. An ``act`` may pass its command on to the
    engine.
    """

    command: type[CommandMessage]
    apply: Callable[[TickContext[Any]], None] = nothing
    """Carries it out in the engine's thread, in a tick; recordings have the commands of ticks."""
    repeat: Repeat = Repeat.NEVER
    act: Callable[[Request[Any]], None] = Request.pass_on
    """Carries it out in the thread of the client that sent it, and raises a CommandError if that
    cannot be; by default the engine does."""
    allowed: Callable[[Program], None] = nothing
    """Raises a CommandError if this program does not take such commands, whatever they say."""
    check: Callable[[Any, Program], None] = nothing
    """Raises a CommandError if this robot or these parameters do not allow the command."""
    check_field: Callable[[Any, Field], None] = nothing
    """Raises a CommandError if the field does not allow it, or the numbers make no sense; replays
    ask it of recorded commands as well."""
    drives: bool = False
    """Whether the robot has to stop when everybody has left who sent such commands."""
    slow: bool = False
    """Whether it may take more than some milliseconds; an event loop leaves it to a thread."""
    harmless: bool = False
    """Whether also those may send it who only watch."""
    after_failure: bool = False
    """Whether it is taken after the engine has failed."""
    urgent: bool = False
    """Whether it is taken however many commands wait."""


def collected(rows: Iterable[CommandRow]) -> Mapping[type[CommandMessage], CommandRow]:
    """Return rows by the type of their command.

    Raises:
        ValueError: two rows have commands of the same type.
        TypeError: what one is for is no command.
    """
    table: dict[str, CommandRow] = {}
    for row in rows:
        if not (issubclass(row.command, CommandMessage) and "type" in row.command.model_fields):
            raise TypeError(
                f"{row.command.__name__} is no command; valid is a CommandMessage with a type"
            )
        name = type_of(row.command)
        if name in table:
            raise ValueError(f"two rows are for the command {name!r}; valid is one")
        table[name] = row
    return MappingProxyType({row.command: row for row in table.values()})


def type_of(command: type[CommandMessage]) -> str:
    """Return what a command's class has as ``type``: the word by which JSON names it."""
    (name,) = get_args(command.model_fields["type"].annotation)
    return str(name)
