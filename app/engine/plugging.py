"""What takes part in a process: the features, and the engine's tables with what they add."""

from __future__ import annotations

import threading
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from importlib import import_module

from app.engine.command_row import CommandRow, collected
from app.engine.companions import Companion, Companions, NewCompanion
from app.engine.robot_kind import RobotKind
from app.engine.value import Value
from app.feature import Feature
from app.feature_search import Features, failure_of, find_features
from app.messages.message import CommandMessage, Message
from app.messages.schema import MESSAGES, parts_of
from app.settings.config import Config
from robot.errors import BrickPoseError
from robot.fields.field import Field
from robot.interface import Robot
from robot.localization.filter_kinds import OURS, FilterKind, offer_filters

ROOMS_WITH_COMMANDS = (
    "app.engine.driving_commands",
    "app.engine.pose_commands",
    "app.engine.filter_commands",
    "app.engine.profile_command",
    "app.engine.fault_commands",
    "app.page.commands",
)
"""Modules of the core with rows, as ``COMMANDS``. They are named and not imported: the engine does
not know the page."""
ROOM_WITH_VALUES = "app.engine.values"
ROOM_WITH_ROBOTS = "app.engine.simulated_robots"


@dataclass(frozen=True)
class Plugged:
    """The engine's tables, ours first."""

    features: Features
    """Those that take part; one whose commands or values cannot be used is among the failures."""
    rows: Mapping[type[CommandMessage], CommandRow]
    """How each type of command is carried out."""
    values: tuple[Value, ...]
    """What ticks show."""
    companions: tuple[tuple[str, NewCompanion], ...]
    """What goes along with each engine, and whose it is."""
    robots: Mapping[str, RobotKind]
    """What ``--robot`` chooses from, by name."""
    messages: tuple[type[Message], ...]
    """What is sent."""
    filters: tuple[FilterKind, ...] = ()
    """What the parameter ``filter`` chooses from, besides the core's."""

    @property
    def all_messages(self) -> tuple[type[Message], ...]:
        """What is sent and what is taken."""
        return (*self.rows, *self.messages)

    @classmethod
    def of_core(cls, features: Features) -> Plugged:
        """Return our tables before a feature adds to them."""
        rows = [row for room in ROOMS_WITH_COMMANDS for row in import_module(room).COMMANDS]
        values: tuple[Value, ...] = import_module(ROOM_WITH_VALUES).VALUES
        robots = {kind.name: kind for kind in import_module(ROOM_WITH_ROBOTS).ROBOTS}
        return cls(features, collected(rows), values, (), robots, MESSAGES)

    def with_feature(self, feature: Feature) -> Plugged:
        """Return the tables with what a feature adds: all of it.

        Raises:
            ValueError: a command, a message, a value, a robot or a filter has a name that is taken.
            TypeError: something is of another type than its hook takes.
        """
        rows = [row for make in feature.commands for row in make()]
        values = [value for make in feature.values for value in make()]
        companions = tuple((feature.name, make) for make in feature.companions)
        robots = {kind.name: kind for make in feature.robots for kind in make()}
        messages = [message for make in feature.messages for message in make()]
        filters = [kind for make in feature.filters for kind in make()]
        collected_rows = collected((*self.rows.values(), *rows))
        _require_new(values, self.values)
        _require_messages((*collected_rows, *messages), self.all_messages)
        for name in robots.keys() & self.robots.keys():
            raise ValueError(f"there is a robot {name!r} already")
        _require_filters(filters, (*OURS, *self.filters))
        return replace(
            self,
            rows=collected_rows,
            values=(*self.values, *values),
            companions=(*self.companions, *companions),
            robots={**self.robots, **robots},
            messages=(*self.messages, *messages),
            filters=(*self.filters, *filters),
        )


_PLUGGED: list[Plugged] = []
"""The tables of this process; none until somebody asks for them."""
_LOCK = threading.RLock()


def plug_in(features: Features) -> Features:
    """Let features take part in this process, in place of those before.

    Returns:
        The features, with those named as failures whose commands or values cannot be used.
    """
    tables = Plugged.of_core(features)

    def add(feature: Feature) -> Iterable[None]:
        nonlocal tables
        tables = tables.with_feature(feature)
        return ()

    _, failures = features.made(add)
    features = replace(features, failures=(*features.failures, *failures))
    with _LOCK:
        offer_filters(tables.filters)
        _PLUGGED[:] = [replace(tables, features=features)]
    return features


def plugged() -> Plugged:
    """Return the tables of this process; by default, all features that are installed take part."""
    with _LOCK:
        if not _PLUGGED:
            plug_in(find_features())
        return _PLUGGED[0]


def companions_of(config: Config, robot: Robot, field: Field) -> Companions:
    """Return what goes along with a new engine; a feature that makes nothing harms no other."""
    made: list[tuple[str, Companion]] = []
    failures: dict[str, str] = {}
    for name, make in plugged().companions:
        try:
            made += [(name, companion) for companion in make(config, robot, field)]
        except BrickPoseError:
            raise
        except Exception as error:
            failures[name] = failure_of(name, error)
    return Companions(made, failures)


def _require_new(values: Iterable[Value], known: Iterable[Value]) -> None:
    names = {value.name for value in known}
    for value in values:
        if not isinstance(value, Value):
            raise TypeError(f"a value is {value!r}; valid is a Value")
        if value.name in names:
            raise ValueError(f"there is a value {value.name!r} already")
        names.add(value.name)


def _require_filters(kinds: Iterable[FilterKind], known: Iterable[FilterKind]) -> None:
    names = {kind.name for kind in known}
    for kind in kinds:
        if not isinstance(kind, FilterKind):
            raise TypeError(f"a filter is {kind!r}; valid is a FilterKind")
        if kind.name in names:
            raise ValueError(f"there is a filter {kind.name!r} already")
        names.add(kind.name)


def _require_messages(messages: Iterable[object], known: Iterable[type[Message]]) -> None:
    classes: list[type[Message]] = []
    for message in messages:
        if not (isinstance(message, type) and issubclass(message, Message)):
            raise TypeError(f"a message is {message!r}; valid is a class of messages")
        classes.append(message)
    names = {each.__name__: each for each in parts_of(known)}
    for each in parts_of(classes):
        name = each.__name__
        if names.setdefault(name, each) is not each:
            raise ValueError(f"there is a message {name} already")
