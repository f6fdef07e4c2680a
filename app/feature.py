"""The one record by which anything is added to the program, ours or a stranger's.

A package declares its features as entry points of the group ``brickpose.features``, as ours are in
``pyproject.toml``; each names a ``Feature``. ``docs/extending.md`` has every hook.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, fields
from pathlib import Path
from pkgutil import resolve_name
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from argparse import ArgumentParser

    from fastapi import APIRouter

    from app.command_parser import CommandParser
    from app.engine.added_models import NewModels
    from app.engine.command_row import CommandRow
    from app.engine.companions import NewCompanion
    from app.engine.compiling.functions import Compiled
    from app.engine.program import Program
    from app.engine.robot_kind import RobotKind
    from app.engine.start import Start
    from app.engine.value import Value
    from app.messages.message import Message
    from app.page.outlets import Outlet, Outlets
    from app.settings.config import Config
    from app.tools.doctor.finding import Finding
    from robot.camera import Lens
    from robot.fields.field import Field
    from robot.hooks import FieldSource
    from robot.localization.filter_kinds import FilterKind
    from sim.engines import PhysicsEngine


NewGate = Callable[[Any], Any]
"""Makes an ASGI application of the one within, to which it passes what it lets in."""


@dataclass(frozen=True)
class Late:
    """A function by its name, imported when it is first called.

    Records of features are read at each start, also for ``--help``; what they name is not.
    """

    target: str
    """``package.module:function``; or a constant, which is then what the function returns."""

    def __call__(self, *arguments: Any) -> Any:
        """Call the function."""
        named = resolve_name(self.target)
        return named(*arguments) if callable(named) else named


@dataclass(frozen=True)
class Subcommand:
    """A command of ``brickpose``."""

    name: str
    """What is typed."""
    about: str
    """What ``brickpose --help`` says of it."""
    options: Callable[[CommandParser], None]
    """Adds its options to its parser, and sets the default ``command``: what carries it out, a
    function of the parsed options that returns the exit code. Called if it is typed."""


@dataclass(frozen=True)
class RunOptions:
    """Options of ``run`` and of the other commands that serve the page with a robot."""

    add: Callable[[ArgumentParser], None]
    """Adds them to a command's parser; what is not typed has no value."""
    apply: Callable[[Config, Mapping[str, Any]], Config]
    """Returns the settings with what was typed, given by the options' names."""
    replays: bool = False
    """Whether ``replay`` has them, too."""


@dataclass(frozen=True)
class SettingOption:
    """An option that sets one setting, whose type and default it has; its help is the meaning."""

    path: str
    """The setting's, as ``ros2.dds``; of the feature's own as ``NAME.setting``."""
    settings: Callable[[], Any] | None = None
    """The feature's ``settings``, if it is one of them; none is the program's."""
    metavar: str | None = None
    """What help calls its value; none is its name in capitals."""
    name: str = ""
    """What is typed after ``--``, with ``_`` for ``-``; none is the setting's name."""
    replays: bool = False
    """Whether ``replay`` has it, too."""

    @property
    def key(self) -> str:
        """Its name among what was typed."""
        return self.name or self.path.rpartition(".")[2]

    @property
    def flag(self) -> str:
        """What is typed, as ``--pose-file``."""
        return f"--{self.key.replace('_', '-')}"

    def add(self, parser: ArgumentParser) -> None:
        """Add it to a command's parser."""
        Late("app.options:add_setting")(parser, self)

    def apply(self, config: Config, given: Mapping[str, Any]) -> Any:
        """Return the ``Config`` with what was typed."""
        return Late("app.options:with_setting")(config, self, given)


@dataclass(frozen=True)
class Guest:
    """A program whose pages come from a site of their own, and open one WebSocket by a link."""

    name: str
    """Its name, for people."""
    path: str
    """Of the WebSocket, as ``/foxglove``: a route of the feature. The link has a token besides."""


@dataclass(frozen=True)
class Panel:
    """A panel of the page, which its own script fills."""

    name: str
    """Its name among the feature's panels."""
    title: str
    """What stands above it."""
    script: Path
    """An ES module in a folder that has nothing secret: the page may load all of it. It exports
    ``panel(body, program)``: ``body`` is the element to fill, ``program.order(command)`` sends a
    command; it returns an object whose ``show(telemetry)`` is called with each message."""

    def __post_init__(self) -> None:
        """Refuse a script that there is not: the page could not be served."""
        if not self.script.is_file():
            raise FileNotFoundError(f"the panel {self.name} has no script {self.script}")


@dataclass(frozen=True, kw_only=True)
class Feature:
    """What plugs into the program: all that it adds, by the hooks that it uses."""

    name: str
    """The name of its entry point, by which ``--without NAME`` leaves it out."""
    about: str
    """What it is, in a few words: ``brickpose doctor`` shows it of other packages."""
    subcommands: tuple[Subcommand, ...] = ()
    """Commands of ``brickpose``; their names must be new."""
    settings: Callable[[], Any] | None = None
    """Makes its settings with their defaults: a frozen dataclass of ``robot.settings.setting``s.
    Their table in a file of settings has the feature's name; ``Config.group`` returns them."""
    run_options: tuple[RunOptions | SettingOption, ...] = ()
    """Options of the commands that serve the page with a robot."""
    guests: tuple[Callable[[Config], Iterable[Guest]], ...] = ()
    """Each gives programs of other sites that may come in by a link, which is printed."""
    routers: tuple[Callable[[Program], APIRouter], ...] = ()
    """Each makes routes for the page's server: of a program, which is another one after the page
    has changed the field or opened a recording."""
    commands: tuple[Callable[[], Iterable[CommandRow]], ...] = ()
    """Each gives rows of the table of commands, which the page, programs, recordings and replays
    then have; the types of their commands must be new."""
    planners: tuple[Callable[[], Iterable[Any]], ...] = ()
    """Each gives ``robot.navigation.planners.PlannerKind``s, which ``[navigation]`` can choose."""
    controllers: tuple[Callable[[], Iterable[Any]], ...] = ()
    """Each gives ``robot.navigation.controllers.ControllerKind``s, in the same way."""
    messages: tuple[Callable[[], Iterable[type[Message]]], ...] = ()
    """Each gives messages of its routes, which ``/docs`` describes and the page's types have as
    they have commands; their names must be new."""
    robots: tuple[Callable[[], Iterable[RobotKind]], ...] = ()
    """Each gives robots that ``--robot`` can choose; their names must be new."""
    filters: tuple[Callable[[], Iterable[FilterKind]], ...] = ()
    """Each gives filters that the parameter ``filter`` can choose; their names must be new."""
    engines: tuple[Callable[[], Iterable[PhysicsEngine]], ...] = ()
    """Each gives engines of physics that ``[sim] engine`` can choose; their names must be new."""
    compiled: tuple[Callable[[], Iterable[Compiled]], ...] = ()
    """Each gives functions that numba compiles at the first start, and not while the robot
    drives."""
    builders: tuple[Callable[[Config, bool], Program | None], ...] = ()
    """Each builds the program that is served, in place of ours: as one whose engine runs elsewhere;
    None leaves it to the next. The second argument says that this process has no other thread."""
    companions: tuple[NewCompanion, ...] = ()
    """Each makes what looks at each tick of an engine, and may give commands: ``Companion``s."""
    starts: tuple[Callable[[Config, Field], Start | None], ...] = ()
    """Each may say where a run begins, before the settings do; None, or no place, leaves it."""
    models: tuple[NewModels, ...] = ()
    """Each makes models of sensor and motion, ``AddedModels``, which are chosen by name as ours;
    their names must be new."""
    gates: tuple[Callable[[Config], Iterable[NewGate]], ...] = ()
    """Each gives what stands before the page's server and sees requests first, as a sign-in; that
    of the last feature by name comes first of all."""
    outlet: Callable[[Outlets], Outlet] | None = None
    """Makes what runs as long as a program: threads, files, routes, layers of the 3D view, parts of
    telemetry, and what carries out commands outside the engine."""
    lens_files: tuple[Callable[[Path], Lens], ...] = ()
    """Each reads the lens beside a robot's description from a file that is not as we write it, or
    raises a ``CameraError``; then the next one is asked."""
    fields: tuple[Callable[[], Iterable[FieldSource]], ...] = ()
    """Each gives fields besides the drawings: made by name, or read from files."""
    values: tuple[Callable[[], Iterable[Value]], ...] = ()
    """Each gives values that ticks show on the page, on ROS and in recordings; their names must be
    new."""
    topics: tuple[Callable[[], Iterable[Any]], ...] = ()
    """Each gives topics, ``app.features.ros.topics.Topic``, that rosbridge, Foxglove, DDS and
    recordings have as they have ours; their names must be new."""
    panels: tuple[Panel, ...] = ()
    """Panels of the page."""
    documents: tuple[Path, ...] = ()
    """Markdown files, which ``/help`` lists with ours; their names must be new."""
    checks: tuple[Callable[[Config], Iterable[Finding]], ...] = ()
    """Each gives lines of ``brickpose doctor``."""

    def __post_init__(self) -> None:
        """Refuse what would fail only later, where it is used."""
        kinds: dict[str, tuple[type, ...]] = {
            "subcommands": (Subcommand,),
            "documents": (Path,),
            "panels": (Panel,),
            "run_options": (RunOptions, SettingOption),
        }
        for hook in fields(self):
            given = getattr(self, hook.name)
            if hook.default is None and not (given is None or callable(given)):
                raise TypeError(f"{hook.name} is {given!r}; valid is a function")
            if hook.default != ():
                continue
            if not isinstance(given, tuple):
                raise TypeError(f"{hook.name} is {given!r}; valid is a tuple of them")
            known = kinds.get(hook.name)
            for each in given:
                if not (isinstance(each, known) if known else callable(each)):
                    valid = " or a ".join(kind.__name__ for kind in known or ()) or "function"
                    raise TypeError(f"{hook.name} has {each!r}; valid is a {valid}")
