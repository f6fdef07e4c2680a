"""Reads the lens beside a robot's description, whichever program wrote the file."""

from __future__ import annotations

from pathlib import Path

from robot.camera import Lens
from robot.lens_files.reading import read_lens_file


def read_lens(path: Path) -> Lens:
    """Return the lens of a file.

    Raises:
        CameraError: as ``read_lens_file``.
    """
    return read_lens_file(path).lens
