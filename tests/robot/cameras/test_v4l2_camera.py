"""USB cameras on a capture that behaves as OpenCV's on Video4Linux does."""

import os

import cv2
import pytest
from camera_sources import READOUT, AtRest, lens, picture
from fake_v4l2 import Webcam

from robot.cameras.camera import PictureError
from robot.cameras.settings import CameraSourceSettings
from robot.cameras.v4l2 import V4l2Device, video_nodes

NOW = AtRest.NOW


class Bench(AtRest, Webcam):
    def stamp_of(self, told):
        self.sent.put((picture(0, *self.size), told))
        return self.open().grab(1.0).stamp

    def asked_for(self, which):
        return [value for asked, value in self.asked if asked == which]


def fourcc(kind):
    return cv2.VideoWriter.fourcc(*kind)


def test_the_drivers_stamp_is_that_of_the_first_row(tmp_path):
    bench = Bench(tmp_path, CameraSourceSettings(exposure=0.012))
    assert bench.stamp_of(NOW - 0.03) == pytest.approx(NOW - 0.03 - 0.006 + READOUT / 2)


@pytest.mark.parametrize("told", [0.0, -0.001, NOW + 0.5, NOW - 2.0, 1.7e9])
def test_without_a_stamp_of_this_clock_the_arrival_counts(tmp_path, told):
    bench = Bench(tmp_path, CameraSourceSettings(exposure_delay=0.055))
    assert bench.stamp_of(told) == pytest.approx(NOW - 0.055)


def test_the_lens_size_and_the_pace_are_asked_for(tmp_path):
    bench = Bench(tmp_path, CameraSourceSettings(frame_rate=25))
    bench.open()
    assert bench.asked_for(cv2.CAP_PROP_FRAME_WIDTH) == [96]
    assert bench.asked_for(cv2.CAP_PROP_FRAME_HEIGHT) == [64]
    assert bench.asked_for(cv2.CAP_PROP_FPS) == [25]
    assert bench.asked_for(cv2.CAP_PROP_BUFFERSIZE) == [2]
    assert bench.asked[0][0] == cv2.CAP_PROP_FOURCC


def test_small_pictures_come_unpacked_and_large_ones_as_jpeg(tmp_path):
    bench = Bench(tmp_path)
    bench.open()
    assert bench.asked_for(cv2.CAP_PROP_FOURCC) == [fourcc("YUYV")]
    bench.asked.clear()
    bench.lens, bench.size = lens(1280, 720), (1280, 720)
    bench.open()
    assert bench.asked_for(cv2.CAP_PROP_FOURCC) == [fourcc("MJPG")]


def test_a_camera_without_the_format_is_asked_for_the_other(tmp_path):
    bench = Bench(tmp_path, formats=(fourcc("MJPG"),))
    bench.open()
    assert bench.asked_for(cv2.CAP_PROP_FOURCC) == [fourcc("YUYV"), fourcc("MJPG")]


def test_another_size_is_refused_naming_both(tmp_path):
    with pytest.raises(PictureError, match=r"320 x 240 px.* 96 x 64 px"):
        Bench(tmp_path, size=(320, 240)).open()


def test_an_absent_camera_is_told_with_the_cure(tmp_path):
    device = V4l2Device(tmp_path / "video3", lens(), CameraSourceSettings())
    with pytest.raises(PictureError, match=r"video3 is not there: plug it in"):
        device.open()


def test_a_camera_that_may_not_be_opened_is_told_with_the_cure(tmp_path, monkeypatch):
    bench = Bench(tmp_path)
    monkeypatch.setattr(os, "access", lambda path, mode: False)
    with pytest.raises(PictureError, match=r"usermod -aG video"):
        bench.open()


def test_a_busy_camera_is_told(tmp_path):
    with pytest.raises(PictureError, match=r"another program uses it .*fuser -v .*video0"):
        Bench(tmp_path, plugged=False).open()


def test_what_is_no_camera_is_told_by_opencv_itself(tmp_path):
    path = tmp_path / "video0"
    path.touch()
    device = V4l2Device(path, lens(), CameraSourceSettings())
    with pytest.raises(PictureError, match="cannot be opened"):
        device.open()
    device.close()


def test_opencv_waits_two_seconds_instead_of_ten_unless_told_otherwise(tmp_path, monkeypatch):
    name = "OPENCV_VIDEOIO_V4L_SELECT_TIMEOUT"
    monkeypatch.setenv(name, "7")
    Bench(tmp_path).open()
    assert os.environ[name] == "7"
    monkeypatch.delenv(name)
    Bench(tmp_path).open()
    assert os.environ[name] == "2"


def test_a_picture_that_does_not_come_is_a_failure(tmp_path):
    bench = Bench(tmp_path)
    device = bench.open()
    bench.sent.put(None)
    with pytest.raises(PictureError, match="check its cable"):
        device.grab(0.1)


def test_a_damaged_picture_is_none_and_the_next_comes(tmp_path):
    bench = Bench(tmp_path)
    device = bench.open()
    bench.sent.put((None, NOW))
    bench.sent.put((picture(0, *bench.size), NOW))
    assert device.grab(0.1) is None
    assert device.grab(0.1) is not None


def test_closing_releases_the_camera_and_may_be_done_unopened(tmp_path):
    bench = Bench(tmp_path)
    device = bench.open()
    device.close()
    device.close()
    assert bench.opened[0].released
    with pytest.raises(PictureError):
        device.grab(0.1)


def test_device_nodes_are_listed_by_number(tmp_path):
    for name in ("video10", "video2", "video0", "videos", "media0"):
        (tmp_path / name).touch()
    assert [path.name for path in video_nodes(tmp_path)] == ["video0", "video2", "video10"]
