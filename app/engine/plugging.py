"""What takes part in a process: the features, and the engine's tables with what they add."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, replace
from importlib import import_module
from pathlib import Path
from typing import Any, TypeVar

from app.engine.added_models import AddedModels, NewModels
from app.engine.command_row import CommandRow, collected
from app.engine.companions import Companions, NewCompanion
from app.engine.program import Program
from app.engine.robot_kind import Blueprint, RobotKind, require_robot
from app.engine.start import Start, start
from app.engine.value import Value
from app.feature import Feature
from app.feature_search import Features, failure_of, find_features, named
from app.messages.message import CommandMessage, Message
from app.messages.schema import MESSAGES, parts_of
from app.settings.config import AUTO, DOCS, Config
from robot.camera import Lens
from robot.errors import BrickPoseError
from robot.fields.field import Field
from robot.hooks import FieldSource
from robot.interface import Robot
from robot.localization.filter_kinds import OURS, FilterKind
from robot.localization.models.motion_models import MOTION_MODELS
from robot.localization.models.sensor_models import SENSOR_MODELS
from sim.engines import OUR_CHOICES, PhysicsEngine

ROOMS_WITH_COMMANDS = (
    "app.engine.driving_commands",
    "app.engine.pose_commands",
    "app.engine.filter_commands",
    "app.engine.profile_command",
    "app.page.commands",
)
"""Modules of the core with rows, as ``COMMANDS``. They are named and not imported: the engine does
not know the page."""
ROOM_WITH_VALUES = "app.engine.values"
ROOM_WITH_ROBOTS = "app.engine.simulated_robots"

M = TypeVar("M")
Named = TypeVar("Named", Value, RobotKind, FilterKind, PhysicsEngine)
T = TypeVar("T")


@dataclass(frozen=True)
class Plugged:
    """The engine's tables, ours first."""

    features: Features
    """Those that take part."""
    rows: Mapping[type[CommandMessage], CommandRow]
    """How each type of command is carried out."""
    values: tuple[Value, ...]
    """What ticks show."""
    companions: tuple[tuple[str, NewCompanion], ...]
    """What goes along with each engine, and whose it is."""
    starts: tuple[tuple[str, Callable[[Config, Field], Start | None]], ...]
    """What may say where a run begins, and whose it is."""
    models: tuple[tuple[str, NewModels], ...]
    """What makes models of sensor and motion, and whose they are."""
    robots: Mapping[str, RobotKind]
    """What ``--robot`` chooses from, by name."""
    messages: tuple[type[Message], ...]
    """What is sent."""
    builders: tuple[Callable[[Config, bool], Program | None], ...] = ()
    """What builds programs to serve, in place of ours."""
    filters: tuple[FilterKind, ...] = ()
    """What the parameter ``filter`` chooses from, besides the core's."""
    engines: tuple[PhysicsEngine, ...] = ()
    """Engines of physics besides the core's."""
    lens_files: tuple[Callable[[Path], Lens], ...] = ()
    """Readers of lens files that are not as ours are."""
    fields: tuple[FieldSource, ...] = ()
    """Fields besides the drawings."""
    documents: tuple[Path, ...] = ()
    """Documents besides the core's."""

    @property
    def without(self) -> str:
        """The end of a refusal, which names the features that were left out; else empty."""
        return "".join(f"; without {name}" for name in self.features.left_out)

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
        return cls(features, collected(rows), values, (), (), (), robots, MESSAGES)

    def with_feature(self, feature: Feature) -> Plugged:
        """Return the tables with what a feature adds: all of it.

        Raises:
            ValueError: something has a name that is taken.
            TypeError: something is of another type than its hook takes.
        """
        rows = [_command_row(feature, row) for make in feature.commands for row in make()]
        values = [value for make in feature.values for value in make()]
        companions = tuple((feature.name, make) for make in feature.companions)
        models = tuple((feature.name, make) for make in feature.models)
        robots = [kind for make in feature.robots for kind in make()]
        messages = [message for make in feature.messages for message in make()]
        lens_files = (named(feature, read) for read in feature.lens_files)
        fields = [_field_source(feature, each) for make in feature.fields for each in make()]
        filters = [kind for make in feature.filters for kind in make()]
        engines = [engine for make in feature.engines for engine in make()]
        collected_rows = collected((*self.rows.values(), *rows))
        _require_new("value", Value, values, self.values)
        _require_messages((*collected_rows, *messages), self.all_messages)
        _require_new("robot", RobotKind, robots, self.robots.values(), (AUTO,))
        documents = {path.name: path for path in (*DOCS.glob("*.md"), *self.documents)}
        for path in feature.documents:
            if documents.setdefault(path.name, path) is not path:
                raise ValueError(f"there is a document {path.name!r} already")
            path.stat()
        _require_new("filter", FilterKind, filters, self.filters, OURS)
        _require_new("physics engine", PhysicsEngine, engines, self.engines, OUR_CHOICES)
        return replace(
            self,
            rows=collected_rows,
            values=(*self.values, *values),
            companions=(*self.companions, *companions),
            starts=(*self.starts, *((feature.name, each) for each in feature.starts)),
            models=(*self.models, *models),
            robots={**self.robots, **{kind.name: _robot_kind(feature, kind) for kind in robots}},
            documents=(*self.documents, *feature.documents),
            messages=(*self.messages, *messages),
            lens_files=(*self.lens_files, *lens_files),
            fields=(*self.fields, *fields),
            filters=(*self.filters, *filters),
            builders=(*self.builders, *(named(feature, build) for build in feature.builders)),
            engines=(*self.engines, *engines),
        )


_PLUGGED: list[Plugged] = []
"""The tables of this process; none until somebody asks for them."""
_LOCK = threading.RLock()


def plug_in(features: Features) -> Features:
    """Let features take part in this process, in place of those before.

    Returns:
        Those of the features that can be used, and why the others cannot.
    """
    tables = Plugged.of_core(features)

    def add(feature: Feature) -> Iterable[Feature]:
        nonlocal tables
        tables = tables.with_feature(feature)
        return (feature,)

    usable, failures = features.made(add)
    failures = [*features.failures, *failures]
    features = replace(features, active=tuple(usable), failures=tuple(failures))
    with _LOCK:
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
    return Companions(*_of_each(plugged().companions, lambda make: make(config, robot, field)))


def start_of(config: Config, field: Field) -> Start:
    """Return where a run begins: where a feature says, else the configured pose or the field's.

    Raises:
        FieldError: the configured pose is not on the field.
    """

    def asked(begins: Callable[[Config, Field], Start | None]) -> list[Start]:
        said = begins(config, field)
        return [] if said is None else [said]

    said, failures = _of_each(plugged().starts, asked)
    begins = [begin for _, begin in said if begin.hypotheses] or [start(config.start_pose, field)]
    complaints = [begin.complaint for _, begin in said if begin.complaint]
    complaint = " ".join((*complaints, *failures.values()))
    return replace(begins[0], complaint=complaint or None)


def models_of(config: Config, field: Field) -> tuple[AddedModels, ...]:
    """Return what features add to our models, as they clear scans; the last names failures."""
    taken = {*SENSOR_MODELS, *MOTION_MODELS}

    def sound(make: NewModels) -> list[AddedModels]:
        made = list(make(config, field))
        names = {name for each in made for name in each.choice.sensors + each.choice.motions}
        for name in names & taken:
            raise ValueError(f"there is a model {name!r} already")
        taken.update(names)
        return made

    added, failures = _of_each(plugged().models, sound)
    made = sorted((models for _, models in added), key=lambda models: models.clearing)
    return *made, AddedModels(failures)


def _of_each(
    makers: Iterable[tuple[str, M]], make: Callable[[M], Iterable[T]]
) -> tuple[list[tuple[str, T]], dict[str, str]]:
    """Return what each feature makes, with its name, and why some could not."""
    made: list[tuple[str, T]] = []
    failures: dict[str, str] = {}
    for name, maker in makers:
        try:
            made += [(name, part) for part in make(maker)]
        except BrickPoseError:
            raise
        except Exception as error:
            failures[name] = failure_of(name, error)
    return made, failures


def _require_new(
    hook: str,
    kind: type[Named],
    parts: Iterable[Named],
    known: Iterable[Named],
    taken: Iterable[str] = (),
) -> None:
    names = {*taken, *(part.name for part in known)}
    for part in parts:
        if not isinstance(part, kind):
            raise TypeError(f"a {hook} is {part!r}; valid is a {kind.__name__}")
        if part.name in names:
            raise ValueError(f"there is a {hook} {part.name!r} already")
        names.add(part.name)


def _command_row(feature: Feature, row: object) -> CommandRow:
    if not isinstance(row, CommandRow):
        raise TypeError(f"a row of the commands is {row!r}; valid is a CommandRow")
    parts = ("apply", "act", "allowed", "check", "check_field")
    guarded: dict[str, Any] = {part: named(feature, getattr(row, part)) for part in parts}
    return replace(row, **guarded)


def _robot_kind(feature: Feature, kind: RobotKind) -> RobotKind:
    def build(blueprint: Blueprint) -> Robot:
        return require_robot(kind.build(blueprint))

    described = named(feature, kind.description)
    return replace(kind, build=named(feature, build), description=described)


def _field_source(feature: Feature, source: object) -> FieldSource:
    if not isinstance(source, FieldSource):
        raise TypeError(f"fields are {source!r}; valid is a FieldSource")
    return replace(source, has=named(feature, source.has), make=named(feature, source.make))


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
