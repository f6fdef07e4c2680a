"""Chooses one camera of a file that describes several."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

from robot.camera import CameraError

MOST_LISTED = 8
"""Cameras that are listed for people to choose from."""


class SeveralCamerasError(CameraError):
    """A file has several cameras, and it is not said which one is the robot's."""

    def __init__(self, message: str, cameras: Mapping[str, str] = MappingProxyType({})) -> None:
        super().__init__(message)
        self.cameras = cameras
        """What is known of each camera, by its name, for people."""


@dataclass(frozen=True)
class OneCamera:
    """One camera of a file."""

    entry: Any
    """What the file says of it."""
    about: str = ""
    """What is known of it, for people."""
    other_names: tuple[str, ...] = ()


def chosen(form: str, cameras: Mapping[str, OneCamera], name: str) -> Any:
    """Return what a file says of one of its cameras.

    Args:
        form: what kind of file it is, for people.
        cameras: those that it has, by name.
        name: which one; none is needed if there is only one.

    Raises:
        SeveralCamerasError: there are several, and none is named, or another one.
    """
    if len(cameras) == 1 and not name:
        return next(iter(cameras.values())).entry
    wanted = name.strip("/")
    named = [
        camera.entry
        for key, camera in cameras.items()
        if wanted and wanted in (key, *camera.other_names)
    ]
    if len(named) == 1:
        return named[0]
    known = {key: camera.about for key, camera in list(cameras.items())[:MOST_LISTED]}
    listed = ", ".join(f"{key} ({words})" if words else key for key, words in known.items())
    has = f"it has no camera {name!r:.60}" if name else f"it is {form} of several cameras"
    raise SeveralCamerasError(f"{has}; valid is one of {listed}", known)
