"""A USB camera that is not there: it behaves as OpenCV's VideoCapture on V4L2."""

import queue
import time

import cv2
from camera_sources import SLOW_S, Threaded

from robot.cameras.v4l2 import V4l2Device


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
