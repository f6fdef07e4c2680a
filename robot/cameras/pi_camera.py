"""The camera of a Raspberry Pi at its ribbon cable, through picamera2 and libcamera.

Both come with Raspberry Pi OS, not from PyPI. They are imported when the camera is opened.
"""

from __future__ import annotations

import importlib
import time
from collections.abc import Callable
from typing import Any

import numpy as np

from robot.camera import Lens
from robot.cameras.camera import (
    Picture,
    PictureError,
    check_size,
    middle_of_exposure,
    on_monotonic,
    suspend_time,
)
from robot.cameras.settings import CameraSourceSettings
from robot.interface import Frame

BUFFERS = 4
"""Number of buffers that the camera fills in turn; each is copied and given back at once."""


class PiCamera:
    """The first camera that is not a USB camera: grey pictures, fixed focus and frame rate."""

    name = "the Pi camera"

    def __init__(
        self,
        lens: Lens,
        settings: CameraSourceSettings,
        clock: Callable[[], float] = time.monotonic,
        asleep: Callable[[], float] = suspend_time,
        load: Callable[[str], Any] = importlib.import_module,
    ) -> None:
        """``asleep`` returns how far CLOCK_BOOTTIME is ahead [s]; ``load`` imports a module."""
        self._lens = lens
        self._settings = settings
        self._clock = clock
        self._asleep = asleep
        self._load = load
        self._camera: Any = None
        self._job: Any = None

    def open(self) -> None:
        """Start the camera with the widest view that is fast enough.

        Raises:
            PictureError: picamera2 is missing, or the camera is absent, busy or too slow.
        """
        picamera2, libcamera = self._modules()
        number = self._number(picamera2)
        try:
            self._camera = picamera2.Picamera2(number)
        except Exception as error:
            raise PictureError(
                f"{self.name} cannot be opened; does another program use it? ({error})"
            ) from error
        self._camera.configure(self._configuration(libcamera))
        width, height = self._camera.stream_configuration("main")["size"]
        check_size((height, width), self._lens, self.name)
        self._camera.start()

    def grab(self, timeout: float) -> Frame | None:
        """Wait for the next picture; None if none came within ``timeout`` [s]."""
        if self._job is None:
            self._job = self._camera.capture_request(wait=False)
        try:
            request = self._camera.wait(self._job, timeout=timeout)
        except TimeoutError:
            # The request stays pending: a second one would take a picture that nobody releases.
            return None
        self._job = None
        arrival = self._clock()
        try:
            picture = self._grey(request.make_array("main"))
            return Frame(self._stamp(request.get_metadata(), arrival), picture)
        finally:
            request.release()

    def close(self) -> None:
        """Stop the camera and free it for other programs."""
        camera, self._camera, self._job = self._camera, None, None
        if camera is not None:
            camera.close()

    def _modules(self) -> tuple[Any, Any]:
        try:
            return self._load("picamera2"), self._load("libcamera")
        except ImportError as error:
            raise PictureError(
                f"{self.name} needs picamera2 ({error}): run sudo apt install python3-picamera2, "
                "and let the program's virtual environment see it (python3 -m venv "
                "--system-site-packages)"
            ) from error
        except ValueError as error:
            # A part of picamera2 was compiled for another numpy than this environment's.
            raise PictureError(
                f"{self.name}: picamera2 does not fit this environment's numpy ({error}): remove "
                ".venv and run make install"
            ) from error

    def _number(self, picamera2: Any) -> int:
        """Return the first ribbon-cable camera's number; libcamera lists USB cameras too."""
        for number, about in enumerate(picamera2.Picamera2.global_camera_info()):
            if "/usb" not in about["Id"]:
                return number
        raise PictureError(
            f"{self.name} is not there: switch the Pi off, check both ends of the ribbon cable, "
            "switch it on and see what rpicam-hello --list-cameras says"
        )

    def _configuration(self, libcamera: Any) -> Any:
        period = round(1e6 / self._settings.frame_rate)
        turned = self._settings.rotation == 180
        mode = self._mode()
        return self._camera.create_video_configuration(
            main={"size": (self._lens.width, self._lens.height), "format": "YUV420"},
            # The sensor turns the picture itself and still reads its first row first.
            transform=libcamera.Transform(hflip=turned, vflip=turned),
            sensor={"output_size": mode["size"], "bit_depth": mode["bit_depth"]},
            controls={"FrameDurationLimits": (period, period), **self._focus(libcamera)},
            buffer_count=BUFFERS,
        )

    def _mode(self) -> Any:
        """Return the sensor mode with the widest view of those that are fast enough.

        Of several with that view, it is the smallest.

        By default, the mode whose size is nearest to the picture's is taken. For some sensors that
        is a small piece out of the middle, which would be another lens.
        """
        modes = [mode for mode in self._camera.sensor_modes if "crop_limits" in mode]
        # A mode's rate is rounded to hundredths.
        quick = [mode for mode in modes if mode["fps"] >= self._settings.frame_rate - 0.01]
        if not quick:
            best = max((mode["fps"] for mode in modes), default=0.0)
            raise PictureError(
                f"{self.name} takes at most {best:g} pictures a second; frame_rate is "
                f"{self._settings.frame_rate:g}"
            )
        return max(quick, key=lambda mode: (_area(mode["crop_limits"][2:]), -_area(mode["size"])))

    def _focus(self, libcamera: Any) -> dict[str, Any]:
        """Return controls that hold a movable lens: focusing would invalidate the calibration."""
        if "AfMode" not in self._camera.camera_controls:
            return {}
        return {
            "AfMode": libcamera.controls.AfModeEnum.Manual,
            "LensPosition": 1 / self._settings.focus_distance,
        }

    def _grey(self, planes: Picture) -> Picture:
        """Return the plane of brightness: the first rows, without the padding of each row."""
        return np.ascontiguousarray(planes[: self._lens.height, : self._lens.width])

    def _stamp(self, given: dict[str, Any], arrival: float) -> float:
        """Return the middle of the exposure [s], from the arrival if libcamera's stamp is invalid.

        SensorTimestamp [ns] is when the first row came from the sensor (the interrupt for the start
        of a frame). This is the end of the row's exposure. ExposureTime is in microseconds.
        """
        nanoseconds = given.get("SensorTimestamp")
        if nanoseconds is not None:
            stamp = on_monotonic(nanoseconds / 1e9, arrival, self._asleep())
            if stamp is not None:
                exposure = given.get("ExposureTime", self._settings.exposure * 1e6) / 1e6
                return middle_of_exposure(stamp, exposure, self._lens.readout)
        return arrival - self._settings.exposure_delay


def _area(size: Any) -> int:
    return int(size[0]) * int(size[1])
