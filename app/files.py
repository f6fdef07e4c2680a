"""Writes files as a whole: an error, or a power cut, leaves no unfinished content."""

from __future__ import annotations

import os
import sys
import time
import uuid
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

PATIENCE_S = 2.0
"""How long a file may be in use by another program that replaces or reads it [s]."""
LOOK_S = 0.02


@contextmanager
def atomic_file(path: Path) -> Iterator[Path]:
    """Yield a temporary path to write to; when the block ends, move that file to ``path``.

    If the block raises an error, ``path`` stays as it was. At any moment, even after a power cut,
    ``path`` holds a complete file or none. Several programs may write to the same path: one of
    them wins.

    Raises:
        OSError: the file cannot be written.
    """
    path.parent.mkdir(parents=True, exist_ok=True)
    new = path.with_name(f".unfinished-{uuid.uuid4().hex}{path.suffix}")
    try:
        yield new
        with new.open("r+b") as written:  # Windows flushes only what is open for writing
            os.fsync(written.fileno())
        replace_file(new, path)
    except OSError as error:
        if error.filename is not None and os.fspath(error.filename) == str(new):
            error.filename = str(path)  # nobody knows the other name
        raise
    finally:
        new.unlink(missing_ok=True)


def replace_file(new: Path, old: Path) -> None:
    """Put a file into another's place.

    Windows refuses that while any program has the old one open: a virus scanner, or our own page.

    Raises:
        OSError: it cannot be done; on Windows after ``PATIENCE_S``.
    """
    end = time.monotonic() + (PATIENCE_S if sys.platform == "win32" else 0.0)
    while True:
        try:
            new.replace(old)
        except PermissionError:
            if time.monotonic() >= end:
                raise
            time.sleep(LOOK_S)
        else:
            return
