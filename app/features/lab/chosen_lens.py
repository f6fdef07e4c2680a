"""Reads the file of a lens that the user named, and asks for the camera if it has several."""

from __future__ import annotations

from pathlib import Path

from app.console import say
from app.features.lab.asking import ask_which, can_ask
from robot.lens_files.choosing import SeveralCamerasError
from robot.lens_files.reading import LensFile, read_lens_file


def read_chosen_lens(path: Path, name: str | None) -> LensFile:
    """Read the lens of a file, and say how it was read.

    Args:
        path: the file.
        name: which camera of a camchain (``--camera-name``); None if that was not given.

    Raises:
        CameraError: the file cannot be used, or has several cameras and nobody can be asked.
    """
    try:
        file = read_lens_file(path, name or "")
    except SeveralCamerasError as error:
        chosen = _asked(path, error) if name is None and can_ask() else None
        if chosen is None:
            raise SeveralCamerasError(f"{error}; --camera-name chooses", error.cameras) from error
        file = read_lens_file(path, chosen)
    for remark in file.remarks:
        say(remark)
    return file


def _asked(path: Path, error: SeveralCamerasError) -> str | None:
    names = list(error.cameras)
    place = ask_which(
        f"{path} describes several cameras: which one took the pictures?",
        [f"{name} ({about})" if about else name for name, about in error.cameras.items()],
        "none",
    )
    return None if place is None else names[place]
