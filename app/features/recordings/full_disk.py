"""A disk that was full when something was recorded to it, and is until there is room again."""

from __future__ import annotations

import shutil
from dataclasses import dataclass
from pathlib import Path

ROOM = 1 << 20
"""A disk with so much free space is not full [bytes]."""


@dataclass(frozen=True)
class FullDisk:
    """What was found; the next program knows it, too."""

    folder: Path
    """A folder on the disk."""
    words: str
    """What was not written, for people."""

    @property
    def problem(self) -> str | None:
        """The words, as long as the disk is full; None when it has room."""
        try:
            free = shutil.disk_usage(self.folder).free
        except OSError:  # the disk is gone
            return self.words
        return None if free >= ROOM else self.words
