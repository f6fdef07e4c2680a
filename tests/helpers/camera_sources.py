"""What cameras look at in tests: pictures that are exposed one by one; files and the emulator."""

import socket
import threading
import time
from dataclasses import replace

import cv2
import numpy as np

from robot.camera import Lens
from robot.cameras.choice import open_camera
from robot.cameras.grabber import Grabber
from robot.cameras.picture_socket import HEADER, MARK, PictureSocket
from robot.cameras.settings import CameraSourceSettings

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
        settings = replace(self.settings, source=str(path))
        return open_camera(self.lens, settings, clock=self.now)

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


class Threaded(Source):
    def grabber(self, device):
        made = Grabber(device, self.lens, self.settings.frame_rate, first_retry=0.01)
        made.start()
        return made


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
