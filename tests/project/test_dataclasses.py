"""No dataclass compares arrays: since Python 3.13 its ``==`` would raise or be an array itself."""

import importlib
import importlib.util
import pkgutil
from collections.abc import Iterator
from dataclasses import dataclass, fields, is_dataclass
from typing import get_type_hints

import numpy as np

import app
import benchmarks
import robot
import sim

PROGRAMS = ("__main__", "stub", "dashboard")
"""Last names of modules that are run, or are parts of a student's file."""
ABSENT = () if importlib.util.find_spec("jupyterhub") else ("app.features.classroom.hub.",)
"""What needs packages that are not here."""


def modules() -> Iterator[object]:
    for package in (robot, sim, app, benchmarks):
        for found in pkgutil.walk_packages(package.__path__, f"{package.__name__}."):
            if not found.name.startswith(ABSENT) and found.name.rpartition(".")[2] not in PROGRAMS:
                yield importlib.import_module(found.name)


def dataclasses() -> Iterator[type]:
    for module in modules():
        for item in vars(module).values():
            if isinstance(item, type) and is_dataclass(item) and item.__module__ == module.__name__:
                yield item


def compared_arrays(kind: type) -> list[str]:
    """The fields with arrays that the ``==`` written by ``@dataclass`` compares."""
    if not kind.__dataclass_params__.eq or kind.__eq__.__code__.co_filename != "<string>":
        return []
    types = resolved(kind)
    return [one.name for one in fields(kind) if one.compare and "ndarray" in str(types[one.name])]


def resolved(kind: type) -> dict[str, object]:
    """The types of its fields; what is imported for type checkers alone is some object."""
    missing: dict[str, object] = {}
    while True:
        try:
            return get_type_hints(kind, localns=missing)
        except NameError as error:
            missing[error.name] = object


@dataclass
class Compared:
    name: str
    places: tuple[np.ndarray, ...] = ()


@dataclass(eq=False)
class ComparedByIdentity:
    places: np.ndarray


@dataclass
class ComparedByHand:
    places: np.ndarray

    def __eq__(self, other: object) -> bool:
        return isinstance(other, ComparedByHand) and np.array_equal(self.places, other.places)

    __hash__ = None


def test_a_dataclass_that_compares_arrays_is_noticed():
    assert compared_arrays(Compared) == ["places"]
    assert compared_arrays(ComparedByIdentity) == compared_arrays(ComparedByHand) == []


def test_dataclasses_with_arrays_are_equal_to_themselves_alone():
    found = list(dataclasses())
    assert len(found) > 300
    wrong = {f"{kind.__module__}.{kind.__name__}": compared_arrays(kind) for kind in found}
    assert {name: arrays for name, arrays in wrong.items() if arrays} == {}, (
        "write @dataclass(eq=False), or an __eq__ by hand"
    )
