"""Finds the features that are installed, ours and other packages', and loads their records."""

from __future__ import annotations

import tomllib
import traceback
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field, is_dataclass, replace
from functools import lru_cache
from importlib.metadata import Distribution, EntryPoint, entry_points
from pathlib import Path
from typing import TYPE_CHECKING, Any, Generic, ParamSpec, TypeVar

from app.feature import Feature, Guest, NewGate, Panel
from app.languages.marking import phrase
from robot.errors import BrickPoseError, one_line
from robot.settings import SettingError

if TYPE_CHECKING:
    from argparse import ArgumentParser

    from fastapi import APIRouter

    from app.engine.program import Program
    from app.settings.config import Config
    from app.tools.doctor.finding import Finding

GROUP = "brickpose.features"
"""The group of entry points by which packages declare their features."""

OURS = "brickpose"
"""The name of our own package."""

ROOT = Path(__file__).resolve().parents[1]
PROJECT = ROOT / "pyproject.toml"
"""Of a checkout; beside what is installed from a wheel there may be another package's."""
OUR_CODE = tuple(str(ROOT / name) for name in ("app", "robot", "sim"))
LIBRARY = str(Path(traceback.__file__).parent)
"""Python's own modules, as those that import."""
CALLERS = frozenset({"anyio", "fastapi", "importlib_metadata", "starlette", "uvicorn"})
"""What loads features, and calls their routes."""

P = ParamSpec("P")
T = TypeVar("T")


class FeatureError(BrickPoseError, RuntimeError):
    """A feature cannot be used; the message says why, and how to do without it."""


@dataclass(frozen=True, eq=False)
class Features:
    """The features of one start of the program."""

    active: tuple[Feature, ...] = ()
    """Those that were loaded, by name."""
    failures: tuple[str, ...] = ()
    """Why others could not be: for people."""
    left_out: tuple[str, ...] = ()
    """Those that were to be left out, by name."""
    packages: Mapping[str, str] = field(default_factory=dict)
    """What pip calls the package of each, by the features' names."""

    def adding(self, feature: Feature) -> Features:
        """Return these and one more."""
        return replace(self, active=(*self.active, feature))

    @property
    def documents(self) -> tuple[Path, ...]:
        """The documents of all of them."""
        return tuple(path for feature in self.active for path in feature.documents)

    @property
    def panels(self) -> dict[str, tuple[Panel, ...]]:
        """The panels of each feature that has some, by its name."""
        return {feature.name: feature.panels for feature in self.active if feature.panels}

    @property
    def settings(self) -> dict[str, Any]:
        """The settings of each feature that has some, with their defaults, by its name.

        Raises:
            FeatureError: a feature's own code fails; names it.
        """
        made: dict[str, Any] = {}
        for feature in self.active:
            if feature.settings is not None:
                try:
                    made[feature.name] = settings = feature.settings()
                    if not is_dataclass(settings):
                        words = f"its settings are a {type(settings).__name__}"
                        raise FeatureError(f"{words}; valid is a dataclass")
                except Exception as error:  # also a default that its own limits refuse
                    raise FeatureError(failure_of(feature.name, error)) from error
        return made

    def add_run_options(self, parser: ArgumentParser, *, replays: bool = False) -> None:
        """Add the features' options to a command that serves the page with a robot, or a replay.

        Raises:
            FeatureError: a feature's own code fails; names it.
        """
        for feature in self.active:
            with _named(feature):
                for options in feature.run_options:
                    if options.replays or not replays:
                        options.add(parser)

    def with_run_options(self, config: Config, given: Mapping[str, Any]) -> Config:
        """Return the settings with what was typed of the features' options.

        Raises:
            SettingError: a value is invalid.
            FeatureError: a feature's own code fails; names it.
        """
        for feature in self.active:
            with _named(feature):
                for options in feature.run_options:
                    config = options.apply(config, given)
        return config

    def guests(self, config: Config) -> tuple[Guest, ...]:
        """Return the programs of other sites that may come in by a link.

        Raises:
            FeatureError: a feature's own code fails; names it.
        """
        return tuple(self._asked(config, lambda feature: feature.guests, Guest))

    def gates(self, config: Config) -> list[NewGate]:
        """Return what stands before the page's server; raises as ``guests``."""
        return self._asked(config, lambda feature: feature.gates, Callable)

    def _asked(self, config: Config, hooks: Callable[[Feature], Any], kind: Any) -> list[Any]:
        asked: list[Any] = []
        for feature in self.active:
            with _named(feature):
                asked += (_of_type(kind, each) for make in hooks(feature) for each in make(config))
        return asked

    def routers(self, program: Program) -> tuple[list[APIRouter], list[str]]:
        """Return the routers for a program, and why there are none of some features."""
        from fastapi import APIRouter  # noqa: PLC0415 - help needs no web server

        def made(feature: Feature) -> list[APIRouter]:
            return [_of_type(APIRouter, make(program)) for make in feature.routers]

        return self.made(made)

    def findings(self, config: Config) -> Iterator[Finding]:
        """Yield what the features' checks find, as soon as it is found; a failure is a problem."""
        from app.tools.doctor.finding import Finding, problem  # noqa: PLC0415 - as above

        for feature in self.active:
            try:
                for check in feature.checks:
                    for each in check(config):
                        yield _of_type(Finding, each)
            except Exception as error:
                yield problem(failure_of(feature.name, error))

    def made(self, make: Callable[[Feature], Iterable[T]]) -> tuple[list[T], list[str]]:
        """Return what each feature makes, and why some could not: one of them harms no other."""
        parts: list[T] = []
        failures: list[str] = []
        for feature in self.active:
            try:
                parts += make(feature)
            except Exception as error:
                failures.append(failure_of(feature.name, error))
        return parts, failures


def find_features(without: Sequence[str] = (), taken: Iterable[str] = ()) -> Features:
    """Load the records of all features but those to be left out.

    Args:
        without: the names of features to be left out.
        taken: names of subcommands that no feature may have.

    Raises:
        SettingError: there is no feature of a name to be left out; names those that exist.
    """
    known = sorted(declared(), key=lambda entry: entry.name)
    names = dict.fromkeys(entry.name for entry in known)
    for name in without:
        if name not in names:
            raise SettingError(
                f"there is no feature {name} to leave out; valid are {', '.join(names) or 'none'}"
            )
    loaded: dict[str, Feature] = {}
    packages: dict[str, str] = {}
    failures: list[str] = []
    commands = set(taken)
    for entry in known:
        if entry.name in without:
            continue
        package = OURS if entry.dist is None else _name_of(entry.dist)
        if packages.setdefault(entry.name, package) != package:
            failures.append(_twins(entry.name, package, packages[entry.name]))
            continue
        try:
            feature = _load(entry, commands)
        except (Exception, SystemExit) as error:
            failures.append(failure_of(entry.name, error))
        else:
            loaded[feature.name] = feature
            commands |= {each.name for each in feature.subcommands}
    left_out = tuple(dict.fromkeys(without))
    return Features(tuple(loaded.values()), tuple(failures), left_out, packages)


def declared() -> Iterator[EntryPoint]:
    """Yield the entry points of all features.

    An editable installation keeps the entry points of the day when it was made. So in a checkout
    ours are read where they are written.
    """
    project = _project()
    for name, target in project.get("entry-points", {}).get(GROUP, {}).items():
        yield EntryPoint(name, target, GROUP)
    for entry in entry_points(group=GROUP):
        if not (project and entry.dist is not None and _name_of(entry.dist) == OURS):
            yield entry


@lru_cache(maxsize=64)
def _name_of(package: Distribution) -> str:
    """Return a package's name; each time it is read from its file."""
    return package.name


def _project() -> dict[str, Any]:
    """Return what ``pyproject.toml`` says of our project; nothing if this is no checkout."""
    if not PROJECT.is_file():
        return {}
    project: dict[str, Any] = tomllib.loads(PROJECT.read_text(encoding="utf-8")).get("project", {})
    return project if project.get("name") == OURS else {}


def _load(entry: EntryPoint, taken: Collection[str]) -> Feature:
    """Return the record of a feature.

    Raises:
        FeatureError: it is no such record, or has a command whose name is taken.
    """
    feature = entry.load()
    if not isinstance(feature, Feature):
        raise FeatureError(f"{entry.value} is a {type(feature).__name__}; valid is a Feature")
    if feature.name != entry.name:
        raise FeatureError(
            f"{entry.value} calls itself {feature.name}; valid is its entry point's name"
        )
    for subcommand in feature.subcommands:
        if subcommand.name in taken:
            raise FeatureError(f"there is a command {subcommand.name} already")
    return feature


def _twins(name: str, package: str, other: str) -> str:
    """Return that two packages have a feature of one name: ``--without`` would leave out both."""
    return phrase(
        f"The feature {name} of the package {package} cannot be used: the package {other} has one "
        "of that name; uninstall one of them, or rename its entry point."
    )


def _of_type(kind: type[T], part: object) -> T:
    if not isinstance(part, kind):
        raise TypeError(f"it makes a {type(part).__name__}; valid is a {kind.__name__}")
    return part


def failure_of(name: str, error: BaseException) -> str:
    """Return that a feature cannot be used, and why, for people."""
    why = reason_of(error)
    return phrase(f"The feature {name} cannot be used: {why}; --without {name} leaves it out.")


def reason_of(error: BaseException) -> str:
    """Return why a feature failed, for people.

    What is no refusal has its type, and its file and line: those of the feature's own code, where
    it last was in it.
    """
    why = one_line(str(error)) or "no reason is given"
    if isinstance(error, BrickPoseError):
        return why
    place = f" ({where})" if (where := _place_of(error)) else ""
    return f"{type(error).__name__}: {why}{place}"


def _place_of(error: BaseException) -> str:
    """Return file and line by which people find a mistake; empty if only ours are known."""
    if isinstance(error, SyntaxError):
        return ""  # its text has both
    frames = traceback.extract_tb(error.__traceback__)
    lines = [(_module_of(each.filename), each.lineno) for each in frames if not _is_ours(each)]
    lines = [(file, line) for file, line in lines if file.parts[0] not in CALLERS]
    own = [(file, line) for file, line in lines if file.parts[0] == lines[0][0].parts[0]]
    return f"{own[-1][0].as_posix()}:{own[-1][1]}" if own else ""


def _is_ours(frame: traceback.FrameSummary) -> bool:
    """Whether a frame is of our own package, or of Python itself."""
    file = frame.filename
    library = file.startswith((LIBRARY, "<")) and "site-packages" not in file
    return library or file.startswith(OUR_CODE)


def _module_of(file: str) -> Path:
    """Return a module's file below the folder from which Python imports its package."""
    folder = Path(file).parent
    while (folder / "__init__.py").is_file():
        folder = folder.parent
    return Path(file).relative_to(folder)


@contextmanager
def _named(feature: Feature) -> Iterator[None]:
    """Raise a FeatureError, which names the feature, if its own code raises what is no refusal."""
    try:
        yield
    except BrickPoseError:
        raise
    except Exception as error:
        raise FeatureError(failure_of(feature.name, error)) from error


@dataclass(frozen=True)
class _Named(Generic[P, T]):
    feature: Feature
    function: Callable[P, T]

    def __call__(self, *given: P.args, **by_name: P.kwargs) -> T:
        with _named(self.feature):
            return self.function(*given, **by_name)


def named(feature: Feature, function: Callable[P, T]) -> Callable[P, T]:
    """Return a feature's function.

    It raises a FeatureError, which names the feature, if the feature's own code raises anything.
    """
    return _Named(feature, function)
