"""Detects saved files, and finds the models in a folder without running any file."""

from __future__ import annotations

import ast
from dataclasses import dataclass
from pathlib import Path

from app.features.own_models.error_messages import OwnModelError, errors_named_after
from app.features.own_models.model_file import ModelFile
from app.languages.marking import phrase

MOST_FILES = 100
"""Most files of a folder that are read, so that a huge folder is not searched through."""

Signature = tuple[int, int]


def signature(path: Path) -> Signature | None:
    """Return a file's time [ns] and size, which change on a save; None if it is not there."""
    try:
        result = path.stat()
    except OSError:
        return None
    return result.st_mtime_ns, result.st_size


class FileWatch:
    """Watches one file; a save counts only after the editor has finished writing."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self._known = self._seen = signature(path)

    def saved(self) -> bool:
        """Return whether the file was saved, and has not changed since the call before.

        Each save is returned once. A missing file does not count as saved: some editors put the new
        file in its place a moment later.
        """
        current = signature(self._path)
        rests = current == self._seen
        self._seen = current
        if current is None or current == self._known or not rests:
            return False
        self._known = current
        return True


@dataclass(frozen=True, slots=True)
class ModelList:
    """The models in one file or folder."""

    sensors: tuple[ModelFile, ...] = ()
    motions: tuple[ModelFile, ...] = ()
    faults: tuple[str, ...] = ()
    """Messages about files that are not valid Python, with the line."""


class ModelFolder:
    """A folder for models; its files are read, but not run."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._known: dict[Path, tuple[Signature | None, ModelList]] = {}

    def look(self) -> ModelList:
        """Return the models that are in the folder now."""
        try:
            paths = sorted(self._folder.glob("[!_.]*.py"))[:MOST_FILES]
        except OSError as error:
            return ModelList(faults=(phrase(f"{self._folder} cannot be read: {error.strerror}"),))
        self._known = {path: self._look_into(path) for path in paths}
        result = [kept_model for _, kept_model in self._known.values()]
        return ModelList(
            tuple(model for kept_model in result for model in kept_model.sensors),
            tuple(model for each in result for model in each.motions),
            tuple(fault for item in result for fault in item.faults),
        )

    def _look_into(self, path: Path) -> tuple[Signature | None, ModelList]:
        current = signature(path)
        known = self._known.get(path)
        return known if known is not None and known[0] == current else (current, models_in(path))


def models_in(path: Path) -> ModelList:
    """Return the classes of a file that have a model's method, also by inheritance in the file."""
    try:
        with errors_named_after(path):
            tree = ast.parse(path.read_bytes(), str(path))
    except OwnModelError as error:
        return ModelList(faults=(str(error),))
    methods: dict[str, set[str]] = {}
    for item in tree.body:
        if isinstance(item, ast.ClassDef):
            bases = [base.id for base in item.bases if isinstance(base, ast.Name)]
            methods[item.name] = {
                inner.name for inner in item.body if isinstance(inner, ast.FunctionDef)
            }
            methods[item.name].update(*(methods.get(base, set()) for base in bases))
    return ModelList(
        tuple(ModelFile(path, name) for name, has in methods.items() if "log_likelihood" in has),
        tuple(ModelFile(path, name) for name, has in methods.items() if "sample" in has),
    )
