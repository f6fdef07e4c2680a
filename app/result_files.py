"""Writes results of commands and features: folders as a whole, and files that must be writable."""

from __future__ import annotations

import errno
import json
import os
import re
import shutil
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from app.files import replace_file
from robot.settings import SettingError

DEVICE = re.compile(r"(?:con|prn|aux|nul|com\d|lpt\d)(?:\..*)?|.*\.", re.IGNORECASE)
"""Names that Windows takes for a device, whatever follows a dot; and a last dot, which it drops."""

RESULTS = "results.json"
"""Written last and removed first: where it exists, the other files are of the same run."""


@contextmanager
def atomic_folder(folder: Path) -> Iterator[Path]:
    """Yield a temporary folder to write to; when the block ends, move its content to ``folder``.

    The new content replaces files and folders of the same names. If the block raises an error, the
    new content is deleted, and ``folder`` keeps what it had before.

    Args:
        folder: where the results belong; it is made if it does not exist.

    Raises:
        SettingError: ``folder`` cannot be a folder.
        OSError: the content cannot be written.
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
            replace_file(new, old)
    finally:
        shutil.rmtree(beside, ignore_errors=True)


def require_writable(*paths: Path) -> None:
    """Make sure that files can be written, before much work is done for them.

    Raises:
        SettingError: one cannot; says why.
    """
    for path in paths:
        try:
            if path.is_dir():
                raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR))
            path.parent.mkdir(parents=True, exist_ok=True)
            _try_to_write(path.parent)
        except OSError as error:
            raise SettingError(
                f"{path} cannot be written: {error.strerror}; valid is a file in a folder that you "
                "may write to"
            ) from error


def require_new(*paths: Path) -> None:
    """Make sure that no file is there whose name a result will have, before any work for it.

    Raises:
        SettingError: names those that are there.
    """
    taken = [str(path) for path in paths if path.exists()]
    if taken:
        raise SettingError(
            f"{', '.join(taken)} would be overwritten; valid is another name, or --force"
        )


def require_new_report(report: Path, profile: Path) -> None:
    """Make sure that a report of a profile overwrites no file of somebody else.

    A profile that is measured again is kept beside the new one, and its report is written anew.

    Raises:
        SettingError: the file is there, and no profile that it could be a report of.
    """
    if not profile.exists():
        require_new(report)


def _try_to_write(folder: Path) -> None:
    """Write a file and remove it; OSError if that fails."""
    with tempfile.NamedTemporaryFile(prefix=".unfinished-", dir=folder):
        pass


def is_portable(name: str) -> bool:
    """Return whether each system takes a file of a name that has no special signs otherwise."""
    return DEVICE.fullmatch(name) is None


def make_folder(folder: Path) -> None:
    """Make a folder for results, before there are any.

    Raises:
        SettingError: the folder cannot be made, or not written to.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
        _try_to_write(folder)
    except OSError as error:
        raise SettingError(
            f"{folder} cannot be written to: {error.strerror}; valid is a folder that you may "
            "write to"
        ) from error


def write_json(path: Path, content: dict[str, Any]) -> None:
    """Write a table as JSON that people can read, too; NaN and infinities are refused."""
    path.write_text(json.dumps(content, indent=1, allow_nan=False) + "\n", encoding="utf-8")
