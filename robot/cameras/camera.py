"""What all cameras have in common: the interface, time stamps, checks of pictures."""

from __future__ import annotations

import sys
import time
from typing import Any, Protocol, runtime_checkable

import cv2
import numpy as np
from numpy.typing import NDArray

from robot.camera import Lens
from robot.errors import BrickPoseError
from robot.interface import Frame

LONGEST_WAY_S = 1.0
"""Largest age of a picture on arrival [s]; a stamp that is older is of another clock."""
Picture = NDArray[np.uint8]
"""(h, w) grey or (h, w, 3) BGR."""


def middle_of_exposure(readout_start: float, exposure: float, readout: float) -> float:
    """Return the middle of the exposure of the middle row [s].

    Args:
        readout_start: when the readout of the first row began [s]. Its exposure ended then: a
            rolling shutter reads each row at the end of its exposure.
        exposure: how long each row was exposed [s].
        readout: time from the first row to the last [s].
    """
    return readout_start - exposure / 2 + readout / 2


def on_monotonic(stamp: float, current: float, asleep: float) -> float | None:
    """Convert a driver's stamp [s] to the clock of ``time.monotonic``; None if no clock fits.

    Drivers stamp by CLOCK_MONOTONIC or by CLOCK_BOOTTIME. CLOCK_BOOTTIME also counts the time for
    which the machine was suspended. libcamera documents CLOCK_BOOTTIME, but passes on the kernel's
    stamp, which is by CLOCK_MONOTONIC. Only one of the two interpretations lies in the last second,
    unless both clocks agree.

    Args:
        stamp: the driver's stamp [s].
        current: when the picture arrived, by CLOCK_MONOTONIC [s].
        asleep: how far CLOCK_BOOTTIME is ahead of CLOCK_MONOTONIC [s].
    """
    for candidate in (stamp, stamp - asleep):
        if 0 <= current - candidate <= LONGEST_WAY_S:
            return candidate
    return None


def suspend_time() -> float:
    """Return how long the machine has been suspended since its start [s]."""
    if sys.platform != "linux":
        return 0.0  # only a Pi's camera stamps by the clock that counts it
    return time.clock_gettime(time.CLOCK_BOOTTIME) - time.monotonic()


class PictureError(BrickPoseError, RuntimeError):
    """No picture is available at the moment; the message says why, and the cure."""


class SourceError(BrickPoseError, ValueError):
    """No camera can have this name; the message says what is valid."""


@runtime_checkable
class Camera(Protocol):
    """A camera that takes pictures by itself and hands out the newest."""

    @property
    def name(self) -> str:
        """Name of the camera in messages."""
        ...

    def newest(self) -> Frame | None:
        """Return the newest picture, or None if it was handed out before; do not wait.

        Its stamp is the middle of the exposure of the middle row on the clock of
        ``time.monotonic`` [s]. Its size is that of the lens.
        """
        ...

    @property
    def problem(self) -> str | None:
        """Why no pictures come, with the cure; None while they come."""
        ...

    def close(self) -> None:
        """Release the camera; may be called twice."""
        ...


def check_size(shape: tuple[int, ...], lens: Lens, name: str) -> None:
    """Refuse a picture (h, w) or (h, w, 3) whose size is not the size in the lens description.

    It is not scaled: a camera that gives another size often sees another part of the floor.

    Raises:
        PictureError: the sizes differ; the message names both.
    """
    if tuple(shape[:2]) != (lens.height, lens.width):
        raise PictureError(
            f"{name} gives pictures of {shape[1]} x {shape[0]} px, but the lens is described for "
            f"{lens.width} x {lens.height} px: set the camera to that size, or calibrate it at "
            "its own and describe that lens in the robot's camera_info file"
        )


def upright(picture: Any, rotation: int) -> Picture:
    """Return a picture turned by 0 or 180 degrees."""
    if rotation:
        picture = cv2.rotate(picture, cv2.ROTATE_180)
    return np.asarray(picture, dtype=np.uint8)
