"""Cameras of every kind on what stands in for their hardware, driven picture by picture."""

import queue
import socket
import threading
import time
from types import SimpleNamespace

import cv2
import numpy as np

from robot.camera import Lens
from robot.cameras.choice import open_camera
from robot.cameras.grabber import Grabber
from robot.cameras.pi_camera import PiCamera
from robot.cameras.picture_socket import HEADER, MARK, PictureSocket
from robot.cameras.settings import CameraSourceSettings
from robot.cameras.v4l2 import V4l2Device

READOUT = 0.016
SLOW_S = 10.0


def lens(width=96, height=64):
    matrix = np.array([[80.0, 0, width / 2], [0, 80.0, height / 2], [0, 0, 1]])
    return Lens(width, height, matrix, np.zeros(5), READOUT)


def grey(number):
    """What the pictures of a source are told apart by."""
    return 30 + 20 * (number % 10)


def picture(number, width, height):
    """All grey, but for a white corner at the top left."""
    image = np.full((height, width), grey(number), np.uint8)
    image[: height // 4, : width // 4] = 255
    return image


def until(condition):
    """What a condition gives as soon as it gives something; a bounded wait for a thread."""
    deadline = time.monotonic() + SLOW_S
    while not (found := condition()):
        assert time.monotonic() < deadline, "it did not happen"
        threading.Event().wait(0.001)
    return found


class Source:
    """A camera and the world that it looks at; pictures are exposed when a test says so."""

    def __init__(self, tmp_path, settings=None, size=None):
        self.lens = lens()
        self.settings = settings or CameraSourceSettings()
        self.size = size or (self.lens.width, self.lens.height)
        self.exposed = 0
        self.camera = self.make(tmp_path)

    def expose(self):
        """One more picture comes from the sensor; tells its number."""
        self.send(picture(self.exposed, *self.size))
        self.exposed += 1
        return self.exposed - 1

    def next(self):
        """Expose a picture and fetch it."""
        self.expose()
        return until(self.camera.newest)

    def close(self):
        self.wake()
        self.camera.close()

    def now(self):
        return time.monotonic()

    def wake(self):
        """Let a driver that waits for a picture give up, as its own time-out would."""


# --- files -----------------------------------------------------------------------------------


class Folder(Source):
    """Pictures are exposed by the clock."""

    def make(self, tmp_path):
        folder = tmp_path / "pictures"
        folder.mkdir()
        for number in range(10):
            cv2.imwrite(str(folder / f"{number:02d}.png"), picture(number, *self.size))
        return self.open(folder)

    def open(self, path):
        self.time = 100.0
        return open_camera(str(path), self.lens, self.settings, clock=self.now)

    def send(self, image):
        if self.exposed:
            self.time += 1 / self.settings.frame_rate

    def now(self):
        return self.time


class Video(Folder):
    def make(self, tmp_path):
        path = tmp_path / "video.avi"
        writer = cv2.VideoWriter(str(path), cv2.VideoWriter.fourcc(*"MJPG"), 30, self.size)
        for number in range(10):
            writer.write(cv2.cvtColor(picture(number, *self.size), cv2.COLOR_GRAY2BGR))
        writer.release()
        return self.open(path)


# --- cameras with a thread -------------------------------------------------------------------


class Threaded(Source):
    def grabber(self, device):
        made = Grabber(device, self.lens, self.settings.frame_rate, first_retry=0.01)
        made.start()
        return made


class FakeCapture:
    """Behaves as OpenCV's VideoCapture on V4L2: sizes snap, grab waits and then fails."""

    def __init__(self, source):
        self._source = source
        self._asked = {}
        self._image = None
        self.released = False
        source.opened.append(self)

    def isOpened(self):  # noqa: N802
        return self._source.plugged

    def set(self, which, value):
        self._asked[which] = value
        self._source.asked.append((which, value))
        return which != cv2.CAP_PROP_FOURCC or value in self._source.formats

    def get(self, which):
        width, height = self._source.size
        known = {
            cv2.CAP_PROP_FRAME_WIDTH: width,
            cv2.CAP_PROP_FRAME_HEIGHT: height,
            cv2.CAP_PROP_POS_MSEC: self._source.stamp * 1000,
        }
        return float(known.get(which, -1))

    def grab(self):
        assert not self.released
        sent = self._source.sent.get(timeout=SLOW_S)
        if sent is None:
            return False
        self._image, self._source.stamp = sent
        return True

    def retrieve(self):
        """A JPEG that cannot be decoded gives True and nothing."""
        image = self._image
        return True, None if image is None else cv2.cvtColor(image, cv2.COLOR_GRAY2BGR)

    def release(self):
        self.released = True


class Webcam(Threaded):
    plugged = True
    formats = (cv2.VideoWriter.fourcc(*"YUYV"), cv2.VideoWriter.fourcc(*"MJPG"))
    stamp = 0.0

    def make(self, tmp_path):
        self.sent = queue.Queue()
        self.opened, self.asked = [], []
        self.path = tmp_path / "video0"
        self.path.touch()
        return self.grabber(self.device())

    def device(self, clock=time.monotonic):
        return V4l2Device(self.path, self.lens, self.settings, clock, lambda *_: FakeCapture(self))

    def send(self, image):
        self.sent.put((image, time.monotonic()))

    def wake(self):
        self.sent.put(None)


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


class Emulator(Threaded):
    """A picture server at a Unix socket."""

    def make(self, tmp_path):
        self.path = tmp_path / "pictures.sock"
        self.listen()
        return self.grabber(PictureSocket(self.path, self.lens, self.settings.rotation))

    def listen(self):
        self.server = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
        self.server.settimeout(SLOW_S)
        self.server.bind(str(self.path))
        self.server.listen(1)
        self.client = None

    def send(self, image):
        self.send_bytes(wire(image, time.monotonic()))

    def send_bytes(self, sent):
        if self.client is None:
            self.client, _ = self.server.accept()
            self.client.settimeout(SLOW_S)
        self.client.sendall(sent)

    def end(self):
        """As an emulator that is stopped."""
        if self.client is not None:
            self.client.close()
        self.server.close()
        self.path.unlink()

    def close(self):
        self.camera.close()
        if self.server.fileno() >= 0:
            self.end()


def wire(image, stamp):
    """A picture as the emulator sends it."""
    height, width, *channels = image.shape
    header = HEADER.pack(MARK, stamp, height, width, *(channels or [1]))
    return header + image.tobytes()


KINDS = {
    "folder": Folder,
    "video": Video,
    "webcam": Webcam,
    "pi": PiRibbon,
    "emulator": Emulator,
}


class AtRest:
    """A source's device alone, without its thread, at a standing clock; mixed in before it."""

    NOW = 5000.0

    def __init__(self, folder=None, settings=None, **world):
        self.lens = lens()
        self.size = (self.lens.width, self.lens.height)
        self.settings = settings or CameraSourceSettings()
        for name, value in world.items():
            setattr(self, name, value)
        self.make(folder)

    def grabber(self, device):
        return None

    def open(self):
        device = self.device(clock=lambda: self.NOW)
        device.open()
        return device
