"""Results of points, stored by key so that no point is done twice."""

from __future__ import annotations

import json
from pathlib import Path

from app.files import atomic_file
from app.lab.sweep.work import MEASURES, Measured


class ResultCache:
    """A folder with a small file for each point that is done."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder

    def get(self, key: str) -> Measured | None:
        """Return the measures of a point; None if there are none or the file is damaged."""
        try:
            result = json.loads((self._folder / f"{key}.json").read_text(encoding="utf-8"))
        except (OSError, ValueError):
            return None
        whole = isinstance(result, dict) and set(result) == {*MEASURES, "error"}
        return result if whole else None

    def put(self, key: str, measured: Measured) -> None:
        """Store the measures of a point; the file is complete or not there.

        Raises:
            OSError: the file cannot be written.
        """
        with atomic_file(self._folder / f"{key}.json") as new:
            new.write_text(json.dumps(measured), encoding="utf-8")
