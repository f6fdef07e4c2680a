"""A folder of results that is either whole or not there."""

from __future__ import annotations

import json
import os
import shutil
import tempfile
import uuid
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from robot.settings import SettingError

RESULTS = "results.json"
"""Comes last and goes first: where it is, the rest is of the same run."""


@contextmanager
def written_whole(folder: Path) -> Iterator[Path]:
    """A folder to write to, whose content replaces that of the same names when all is done.

    On an error nothing of it is left, and what was there before is as it was.

    Args:
        folder: where results belong; it is made if it is not there.

    Raises:
        SettingError: it cannot be a folder.
        OSError: it cannot be written.
    """
    make_folder(folder)
    beside = Path(tempfile.mkdtemp(prefix=".unfinished-", dir=folder))
    try:
        yield beside
        (folder / RESULTS).unlink(missing_ok=True)
        for new in sorted(beside.iterdir(), key=lambda path: path.name == RESULTS):
            old = folder / new.name
            if old.is_dir():
                shutil.rmtree(old)
            new.replace(old)
    finally:
        shutil.rmtree(beside, ignore_errors=True)


@contextmanager
def file_written_whole(path: Path) -> Iterator[Path]:
    """A file to write, which takes a path when all is done; on an error it is as it was.

    At any moment, also after a power cut, the path holds a whole file or none. Several programs
    may write to the same path: one of them wins.

    Raises:
        OSError: it cannot be written.
    """
    path.parent.mkdir(parents=True, exist_ok=True)
    new = path.with_name(f".unfinished-{uuid.uuid4().hex}{path.suffix}")
    try:
        yield new
        with new.open("rb") as written:
            os.fsync(written.fileno())
        new.replace(path)
    finally:
        new.unlink(missing_ok=True)


def make_folder(folder: Path) -> None:
    """Make a folder for results, before there are any.

    Raises:
        SettingError: it cannot be one.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise SettingError(
            f"{folder} cannot be written to: {error.strerror}; valid is a folder"
        ) from error


def write_json(path: Path, content: dict[str, Any]) -> None:
    """Write a table so that people can read it too; no number is without a value."""
    path.write_text(json.dumps(content, indent=1, allow_nan=False) + "\n", encoding="utf-8")
