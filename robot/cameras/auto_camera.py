"""The first of several cameras that delivers pictures."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from robot.cameras.camera import PictureError
from robot.cameras.grabber import Device
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
