"""A folder of results that is either whole or not there."""

from __future__ import annotations

import json
import shutil
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

RESULTS = "results.json"
"""Comes last and goes first: where it is, the rest is of the same run."""


@contextmanager
def written_whole(folder: Path) -> Iterator[Path]:
    """A folder to write to, whose content replaces that of the same names when all is done.

    On an error nothing of it is left, and what was there before is as it was.

    Args:
        folder: where results belong; it is made if it is not there.

    Raises:
        OSError: it cannot be written.
    """
    folder.mkdir(parents=True, exist_ok=True)
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


def write_json(path: Path, content: dict[str, Any]) -> None:
    """Write a table so that people can read it too; no number is without a value."""
    path.write_text(json.dumps(content, indent=1, allow_nan=False) + "\n", encoding="utf-8")
