"""Opens the camera that a name stands for, or the one that is there."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from pathlib import Path

from robot.camera import Lens
from robot.cameras.camera import Camera, PictureError, SourceError
from robot.cameras.files import FileCamera, FolderPictures, VideoPictures
from robot.cameras.grabber import Device, Grabber
from robot.cameras.pi_camera import PiCamera
from robot.cameras.picture_socket import PictureSocket
from robot.cameras.settings import CameraSourceSettings
from robot.cameras.v4l2 import V4l2Device, video_nodes
from robot.interface import Frame

TRIAL_S = 2.0
"""How long to wait for a camera's first picture before the next camera is tried [s]."""


class AutoCamera:
    """A device that searches for a working camera each time it is opened."""

    def __init__(self, candidates: Callable[[], Sequence[Device]]) -> None:
        """``candidates`` lists the cameras that exist now, the preferred first."""
        self._candidates = candidates
        self._found: Device | None = None
        self._first: Frame | None = None

    @property
    def name(self) -> str:
        """Name of the camera that was found."""
        return self._found.name if self._found else "the camera"

    def open(self) -> None:
        """Open the first camera that delivers a picture.

        Raises:
            PictureError: no camera does; the message says why for each.
        """
        reasons = []
        for device in self._candidates():
            reason = self._try(device)
            if reason is None:
                self._found = device
                return
            reasons.append(reason)
            device.close()
        raise PictureError(f"no camera was found: {'; '.join(reasons) or 'there is none'}")

    def _try(self, device: Device) -> str | None:
        """Open a camera and take its first picture; return the reason if that fails."""
        try:
            device.open()
            self._first = device.grab(TRIAL_S)
        except PictureError as error:
            return str(error)
        except Exception as error:  # a driver's own failure: the next camera may work
            return f"{device.name} failed: {error}"
        return None if self._first else f"{device.name} sends no pictures"

    def grab(self, timeout: float) -> Frame | None:
        """Wait for the next picture of the camera that was found."""
        if self._found is None:
            raise PictureError("no camera is open")
        first, self._first = self._first, None
        return first or self._found.grab(timeout)

    def close(self) -> None:
        """Close the camera that was found."""
        result, self._found, self._first = self._found, None, None
        if result is not None:
            result.close()


VALID = (
    'valid are "auto", "pi", a camera such as /dev/video0 or its number, a folder of pictures, '
    "a video file, or the emulator's socket (PATH.sock)"
)


def open_camera(
    lens: Lens,
    settings: CameraSourceSettings,
    clock: Callable[[], float] = time.monotonic,
) -> Camera:
    """Open and start the camera that the settings name.

    Args:
        lens: gives the size of the pictures and the readout time of their rows.
        settings: how to take pictures. The source is "auto" (a Pi camera if there is one, else the
            first of ``/dev/video*`` that delivers pictures), "pi", a device node or its number, a
            folder, a video, or a socket.
        clock: the clock of the frames' stamps [s].

    Raises:
        SourceError: no camera can have this name; the message says what is valid. A camera that is
            only absent at the moment reports it as its ``problem`` and is tried again.
    """
    source = settings.source
    path = Path(f"/dev/video{source}" if source.isdecimal() else source)
    if path.is_dir():
        folder = FolderPictures(path)
        return FileCamera(folder, lens, settings.frame_rate, settings.rotation, clock)
    if path.is_file():
        video = VideoPictures(path)
        rate = video.frame_rate or settings.frame_rate
        return FileCamera(video, lens, rate, settings.rotation, clock)
    grabber = Grabber(_device(path, lens, settings, clock), lens, settings.frame_rate, clock)
    grabber.start()
    return grabber


def _device(
    path: Path, lens: Lens, settings: CameraSourceSettings, clock: Callable[[], float]
) -> Device:
    source = settings.source
    if source == "auto":
        return AutoCamera(lambda: _candidates(lens, settings, clock))
    if source == "pi":
        return PiCamera(lens, settings, clock)
    if path.is_socket() or (not path.exists() and path.suffix in (".sock", ".socket")):
        return PictureSocket(path, lens, settings.rotation)
    if path.is_char_device() or path.is_relative_to("/dev"):
        return V4l2Device(path, lens, settings, clock)
    raise SourceError(f"there is no camera {source!r}; {VALID}")


def _candidates(
    lens: Lens, settings: CameraSourceSettings, clock: Callable[[], float]
) -> list[Device]:
    nodes = [V4l2Device(path, lens, settings, clock) for path in video_nodes()]
    return [PiCamera(lens, settings, clock), *nodes]
