"""Hooks of the robot's rooms: what features add to them, asked for if needed.

The robot knows no feature. Whoever knows them says how they are found: ``app/__init__.py``. A
program of the robot's rooms alone has what they have themselves.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol, TypeVar

T = TypeVar("T")


@dataclass(frozen=True)
class FieldSource:
    """Fields that are made when they are asked for by name, or read from files."""

    words: str
    """The names for people, as ``generated-0 to generated-99``; of files the ending, ``.yaml``."""
    has: Callable[[str], bool]
    """Whether it makes the field of a name, or reads a file of this name."""
    make: Callable[[str], Any]
    """Returns the ``Field``, or raises a ``FieldError``."""
    examples: tuple[str, ...] = ()
    """Names that the page lists with those of the drawings."""
    files: bool = False
    """Whether its names are paths of files: these nobody can ask for on the page."""


class Hooks(Protocol):
    """What features add."""

    @property
    def lens_files(self) -> Sequence[Callable[[Path], Any]]:
        """Readers of lenses: each returns a ``Lens``, or raises a ``CameraError``."""
        ...

    @property
    def fields(self) -> Sequence[FieldSource]:
        """Fields besides the drawings."""
        ...

    @property
    def filters(self) -> Sequence[Any]:
        """Each a ``FilterKind``."""
        ...

    @property
    def engines(self) -> Sequence[Any]:
        """Each a ``PhysicsEngine``."""
        ...

    @property
    def without(self) -> str:
        """The end of a refusal, which names the features that were left out; else empty."""
        ...


@dataclass(frozen=True)
class _Nothing:
    lens_files: tuple[()] = ()
    fields: tuple[()] = ()
    filters: tuple[()] = ()
    engines: tuple[()] = ()
    without: str = ""


_FIND: list[Callable[[], Hooks]] = [_Nothing]


def find_by(find: Callable[[], Hooks]) -> None:
    """Have ``find`` asked from now on, whenever a room needs what features add."""
    _FIND[:] = [find]


def added() -> Hooks:
    """Return what features add."""
    return _FIND[0]()


class Offered(Mapping[str, T]):
    """What can be chosen by name; features are asked only where ours are not enough."""

    def __init__(self, ours: Mapping[str, T], everything: Callable[[], Mapping[str, T]]) -> None:
        """``everything`` returns ours and what features add, in the order in which it is shown."""
        self._ours = ours
        self._everything = everything

    def __contains__(self, name: object) -> bool:
        return name in self._ours or name in self._everything()

    def __getitem__(self, name: str) -> T:
        return self._ours[name] if name in self._ours else self._everything()[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._everything())

    def __len__(self) -> int:
        return len(self._everything())

    def __bool__(self) -> bool:
        return True
