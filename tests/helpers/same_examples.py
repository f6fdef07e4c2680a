"""Hypothesis' examples, the same in every run, whatever its process did before.

Hypothesis also tries constants of the product, from all modules that happen to be loaded. Which
these are differs by the tests that ran before, so tests that are repeated exactly tried one thing
alone and another beside others. Here they come from the modules that a test's file imports.
"""

from __future__ import annotations

import ast
import inspect
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from types import ModuleType

from hypothesis.internal.conjecture import providers
from hypothesis.internal.constants_ast import Constants, constants_from_module
from places import ROOT, TESTS

_of: list[ModuleType] = []
"""The file whose tests run now."""


def be_the_same() -> None:
    """From now on take constants of the file of tests that is told, and of no other."""
    providers._get_local_constants = lambda: constants_of(*_of)


def tell(tests: ModuleType) -> None:
    """Whose tests run now."""
    _of[:] = [tests]
    # What may be drawn is kept by the kind of value, not by where it came from.
    providers.CONSTANTS_CACHE.cache.clear()


@cache
def constants_of(*tests: ModuleType) -> Constants:
    """The constants of what files of tests import, in an order of their own."""
    found = Constants()
    for file in {file for each in tests for name in _imported(each) for file in _files(name)}:
        module = ModuleType(file.stem)
        module.__file__ = str(file)
        found |= constants_from_module(module)
    return providers._local_constants | found  # sorted, as these are


def _imported(tests: ModuleType) -> Iterator[str]:
    """Names that may be modules: as they are imported, and where what is imported is defined."""
    for item in ast.walk(ast.parse(inspect.getsource(tests))):
        if isinstance(item, ast.Import):
            yield from (alias.name for alias in item.names)
        elif isinstance(item, ast.ImportFrom) and item.module:
            yield item.module
            yield from (f"{item.module}.{alias.name}" for alias in item.names)
    for value in vars(tests).values():
        if isinstance(module := getattr(value, "__module__", None), str):
            yield module


def _files(name: str) -> Iterator[Path]:
    place = ROOT.joinpath(*name.split("."))
    for file in (place.with_suffix(".py"), place / "__init__.py"):
        if file.is_file() and not file.is_relative_to(TESTS):
            yield file
