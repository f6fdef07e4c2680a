"""Names of files that stand in other files, and how the file's own system writes them."""

from __future__ import annotations

import unicodedata
from pathlib import Path


def as_written(path: Path) -> Path:
    """Return a file by the name that it has where it lies; the path itself if there is none.

    One and the same name may be written in two ways: macOS takes ``é`` apart into a letter and its
    accent when it packs an archive, and leaves the name in the text of a file as it was typed.
    """
    try:
        if path.exists() or path.parent == path:
            return path
        folder, wanted = as_written(path.parent), _composed(path.name)
        alike = [file for file in folder.iterdir() if _composed(file.name) == wanted]
    except (OSError, ValueError):  # no folder, or a name that cannot be one
        return path
    return alike[0] if len(alike) == 1 else path


def _composed(name: str) -> str:
    return unicodedata.normalize("NFC", name)
