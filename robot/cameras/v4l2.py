"""Devices of Video4Linux (V4L2): a USB camera, or any other, through OpenCV."""

from __future__ import annotations

import os
import sys
import time
from collections.abc import Callable
from pathlib import Path

import cv2

from robot.camera import Lens
from robot.cameras.camera import PictureError, check_size, middle_of_exposure, on_monotonic, upright
from robot.cameras.settings import CameraSourceSettings
from robot.interface import Frame

SELECT_TIMEOUT_S = 2
"""How long OpenCV waits for a picture [s], instead of 10; it accepts only whole seconds."""

UNPACKED_LIMIT = 20e6
"""Data rate that USB 2 surely carries [byte/s]; above it, pictures are requested as JPEG."""

BUFFERS = 2
"""One buffer is filled while the other is read: with one buffer, drivers skip every other picture.
The thread that reads the buffers lets no pictures queue up."""


class V4l2Device:
    """One camera at a device node such as ``/dev/video0``."""

    def __init__(
        self,
        path: Path,
        lens: Lens,
        settings: CameraSourceSettings,
        clock: Callable[[], float] = time.monotonic,
        capture: Callable[[str, int], cv2.VideoCapture] = cv2.VideoCapture,
    ) -> None:
        """``capture`` opens a path with one of OpenCV's backends."""
        self.name = f"the camera at {path}"
        self._path = path
        self._lens = lens
        self._settings = settings
        self._clock = clock
        self._make_capture = capture
        self._capture: cv2.VideoCapture | None = None

    def open(self) -> None:
        """Open the device node and request pictures of the lens's size.

        Raises:
            PictureError: the camera is absent, not permitted, busy, or its pictures have another
                size.
        """
        self._check_node()
        os.environ.setdefault("OPENCV_VIDEOIO_V4L_SELECT_TIMEOUT", str(SELECT_TIMEOUT_S))
        self._capture = self._make_capture(str(self._path), cv2.CAP_V4L2)
        if not self._capture.isOpened():
            raise PictureError(
                f"{self.name} cannot be opened: no camera, or another program uses it "
                f"(fuser -v {self._path} tells which)"
            )
        self._configure(self._capture)

    def grab(self, timeout: float) -> Frame | None:
        """Wait for the next picture; None if it is damaged. OpenCV's own time-out applies.

        Raises:
            PictureError: no picture came, for example because the camera was unplugged.
        """
        capture = self._capture
        if capture is None or not capture.grab():
            raise PictureError(f"{self.name} sends no pictures; check its cable and plug it again")
        arrival = self._clock()
        stamp = self._stamp(capture.get(cv2.CAP_PROP_POS_MSEC) / 1000, arrival)
        done, picture = capture.retrieve()
        if not done or picture is None or picture.size == 0:
            return None  # an incomplete JPEG, as some cameras send at first
        return Frame(stamp, upright(picture, self._settings.rotation))

    def close(self) -> None:
        """Release the device node."""
        if self._capture is not None:
            self._capture.release()
            self._capture = None

    def _check_node(self) -> None:
        if sys.platform != "linux":
            raise PictureError(
                f"{self.name} can be opened on Linux only; a folder of pictures or a video file "
                "can be shown here"
            )
        if not self._path.exists():
            result = ", ".join(str(path) for path in video_nodes()) or "none at all"
            raise PictureError(f"{self.name} is not there: plug it in; there is {result}")
        if not os.access(self._path, os.R_OK | os.W_OK):
            raise PictureError(
                f"{self.name} may not be opened: run sudo usermod -aG video $USER, "
                "then log out and in again"
            )

    def _configure(self, capture: cv2.VideoCapture) -> None:
        lens, rate = self._lens, self._settings.frame_rate
        packed = 2 * lens.width * lens.height * rate > UNPACKED_LIMIT
        # The format comes first: it decides which sizes and rates are available.
        kinds = ("MJPG", "YUYV") if packed else ("YUYV", "MJPG")
        for kind in kinds:
            if capture.set(cv2.CAP_PROP_FOURCC, cv2.VideoWriter.fourcc(*kind)):
                break
        capture.set(cv2.CAP_PROP_FRAME_WIDTH, lens.width)
        capture.set(cv2.CAP_PROP_FRAME_HEIGHT, lens.height)
        capture.set(cv2.CAP_PROP_FPS, rate)
        capture.set(cv2.CAP_PROP_BUFFERSIZE, BUFFERS)
        given = (cv2.CAP_PROP_FRAME_HEIGHT, cv2.CAP_PROP_FRAME_WIDTH)
        check_size(tuple(int(capture.get(property_id)) for property_id in given), lens, self.name)

    def _stamp(self, given: float, arrival: float) -> float:
        """Return the middle of the exposure [s], from the driver's stamp or else from the arrival.

        The kernel's driver for USB cameras stamps a picture by CLOCK_MONOTONIC when its first
        packet comes. This is when the readout begins.
        """
        stamp = on_monotonic(given, arrival, 0.0)
        if stamp is None:
            return arrival - self._settings.exposure_delay
        return middle_of_exposure(stamp, self._settings.exposure, self._lens.readout)


def video_nodes(folder: Path = Path("/dev")) -> list[Path]:
    """Return the device nodes ``/dev/video*``, sorted by number."""
    nodes = [path for path in folder.glob("video*") if path.name[5:].isdecimal()]
    return sorted(nodes, key=lambda path: int(path.name[5:]))
