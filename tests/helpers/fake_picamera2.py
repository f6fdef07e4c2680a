"""A Pi's ribbon camera that is not there: it behaves as picamera2's manual says."""

import queue
import time
from types import SimpleNamespace

import numpy as np
from camera_sources import Threaded

from robot.cameras.pi_camera import PiCamera


class Request:
    """A picture in one of a few buffers of the camera; the buffer is given back by release."""

    def __init__(self, fake, image, metadata):
        self._fake, self._image, self._metadata = fake, image, metadata
        self._held = True

    def make_array(self, name):
        """As picamera2 gives YUV420: rows padded to 64 bytes, colour in further rows."""
        assert name == "main" and self._held
        height, width = self._image.shape
        planes = np.full((height * 3 // 2, -(-width // 64) * 64), 128, np.uint8)
        planes[:height, :width] = self._image
        return planes

    def get_metadata(self):
        assert self._held
        return dict(self._metadata)

    def release(self):
        assert self._held
        self._held = False
        self._fake.buffers += 1


class FakePicamera2:
    """Behaves as picamera2's manual and docstrings say, as far as it is used."""

    def __init__(self, source, number):
        if not source.plugged:
            raise RuntimeError("Failed to acquire camera: Device or resource busy")
        self._source = source
        self.number = number
        self.started = False
        self.buffers = 0
        self.camera_controls = {"FrameDurationLimits": (1, 2, 3), **source.more_controls}
        source.opened.append(self)

    @property
    def sensor_modes(self):
        return self._source.modes

    def create_video_configuration(self, main, transform, sensor, controls, buffer_count):
        return locals()

    def configure(self, configuration):
        self.configuration = configuration
        self.buffers = configuration["buffer_count"]

    def stream_configuration(self, name):
        return {"size": self._source.size, "format": self.configuration[name]["format"]}

    def start(self):
        self.started = True

    def capture_request(self, wait):
        assert wait is False and self.started
        return object()

    def wait(self, job, timeout):
        assert self.started
        image, metadata = self._take(timeout)
        # Without a free buffer a camera takes no more pictures.
        assert self.buffers > 0, "requests were not released"
        self.buffers -= 1
        return Request(self, image, metadata)

    def _take(self, timeout):
        try:
            sent = self._source.sent.get(timeout=timeout)
        except queue.Empty:
            raise TimeoutError from None
        if sent is None:
            raise RuntimeError("Camera frontend has timed out")
        return sent

    def close(self):
        self.started = False
        self.closed = True


def mode(width, height, fps, crop):
    return {"size": (width, height), "fps": fps, "bit_depth": 10, "crop_limits": crop}


WHOLE = (0, 0, 3280, 2464)
IMX219_MODES = [
    mode(640, 480, 103.33, (1000, 752, 1280, 960)),
    mode(1640, 1232, 41.85, WHOLE),
    mode(1920, 1080, 47.57, (680, 692, 1920, 1080)),
    mode(3280, 2464, 21.19, WHOLE),
]


class PiRibbon(Threaded):
    plugged = True
    cameras = ({"Id": "/base/soc/i2c0mux/i2c@1/imx219@10", "Model": "imx219", "Num": 0},)
    modes = IMX219_MODES
    asleep = 0.0
    exposure = 0.008

    def make(self, tmp_path):
        self.sent = queue.Queue()
        self.opened = []
        self.more_controls = {}
        return self.grabber(self.device())

    def device(self, clock=time.monotonic):
        return PiCamera(self.lens, self.settings, clock, lambda: self.asleep, self.module)

    def module(self, name):
        if name == "libcamera":
            manual = SimpleNamespace(AfModeEnum=SimpleNamespace(Manual=0))
            return SimpleNamespace(Transform=SimpleNamespace, controls=manual)
        made = lambda number: FakePicamera2(self, number)  # noqa: E731
        made.global_camera_info = lambda: list(self.cameras)
        return SimpleNamespace(Picamera2=made)

    def send(self, image):
        stamp = round((time.monotonic() + self.asleep) * 1e9)
        told = {"SensorTimestamp": stamp, "ExposureTime": round(self.exposure * 1e6)}
        self.sent.put((image, told))
