"""Finds, loads and builds a model from a user's own file."""

from __future__ import annotations

import contextlib
import importlib
import inspect
import linecache
import os
import sys
import types
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from app.features.own_models.error_messages import (
    MODULE_PREFIX,
    OwnModelError,
    errors_named_after,
    line_of,
    place,
)
from robot.settings import SettingError

_brought: set[str] = set()
"""Names of modules that users' files imported from their own folders."""


@dataclass(frozen=True, slots=True)
class ModelFile:
    """A model's class in a file."""

    path: Path
    class_name: str

    @property
    def name(self) -> str:
        """The model's name on the page: ``my_model.py:MyModel``."""
        return f"{self.path.name}:{self.class_name}"

    @classmethod
    def find(cls, text: str) -> ModelFile:
        """Find the class that a text ``FILE.py:CLASS`` names.

        Raises:
            SettingError: the text has another form, or the file does not exist.
        """
        file, _, class_name = text.rpartition(":")
        if not (file.endswith(".py") and class_name.isidentifier()):
            raise SettingError(f"{text!r} is no model; valid is FILE.py:CLASS")
        path = Path(os.path.abspath(file))  # noqa: PTH100 - a link keeps its own name
        if not path.is_file():
            raise SettingError(f"there is no file {path} for the model {text}")
        return cls(path, class_name)


def load(model: ModelFile) -> Callable[..., Any]:
    """Run the file as it is now, and return the class.

    Raises:
        OwnModelError: the file cannot be read or run, or has no such class.
    """
    path = model.path
    with errors_named_after(path):
        source = path.read_bytes()
        module = types.ModuleType(MODULE_PREFIX + path.stem)
        module.__file__ = str(path)
        sys.modules[module.__name__] = module  # dataclasses look their module up by name
        linecache.checkcache(str(path))
        with _neighbours(path.parent):
            exec(compile(source, str(path), "exec"), module.__dict__)
    result = getattr(module, model.class_name, None)
    if not callable(result):
        has = [name for name, value in vars(module).items() if _is_own_class(value, module)]
        raise OwnModelError(
            f"{place(path, None)}there is no class {model.class_name}; "
            f"it has {', '.join(has) or 'none'}"
        )
    made: Callable[..., Any] = result
    return made


def build(model: ModelFile, made: Callable[..., Any], offered: Mapping[str, object]) -> object:
    """Call the class with those of the offered arguments that its parameters name.

    Raises:
        OwnModelError: the class needs another argument, or fails.
    """
    line = line_of(getattr(made, "__init__", made), model.path)
    with errors_named_after(model.path, line):
        arguments = {}
        for name, asked in inspect.signature(made).parameters.items():
            if name in offered:
                arguments[name] = offered[name]
            elif asked.default is asked.empty and asked.kind not in (
                asked.VAR_POSITIONAL,
                asked.VAR_KEYWORD,
            ):
                on_offer = ", ".join(sorted(offered))
                raise OwnModelError(f"{model.class_name} asks for {name}; on offer: {on_offer}")
        return made(**arguments)


def _is_own_class(value: object, module: types.ModuleType) -> bool:
    return isinstance(value, type) and value.__module__ == module.__name__


@contextlib.contextmanager
def _neighbours(folder: Path) -> Iterator[None]:
    """Let a file import its neighbours, as they are now; installed modules take precedence."""
    for name in [name for name in sys.modules if name.partition(".")[0] in _brought]:
        del sys.modules[name]
    importlib.invalidate_caches()
    loaded, before = set(sys.modules), list(sys.path)
    sys.path.append(str(folder))
    try:
        yield
    finally:
        sys.path[:] = before
        # Only new modules are noted: those that the program imported before must stay loaded.
        new = {name for name in set(sys.modules) - loaded if "." not in name}
        _brought.update(name for name in new if _lies_in(sys.modules[name], folder))


def _lies_in(module: types.ModuleType, folder: Path) -> bool:
    """Return whether a module is a file in a folder, or a subfolder of it."""
    file = getattr(module, "__file__", None)
    places = [Path(file).parent] if file else []
    places += [Path(path).parent for path in getattr(module, "__path__", ())]
    return folder in places
