"""Whoever reads a picture gets the pixels that left the sensor, and people are told."""

from __future__ import annotations

import logging
from pathlib import Path

import cv2
import numpy as np
import pytest
from camera_sources import lens
from exif_pictures import tiff_header, with_exif

from app.features.lab.calibrate.pictures import read_grey
from app.features.lab.localize.pictures.sequence import read_sequence
from app.features.recordings.replay.decoding import picture_of
from app.features.ros.message_types import new, to_cdr
from robot.cameras.choice import open_camera
from robot.cameras.settings import CameraSourceSettings

GREY = np.add.outer(np.arange(48) * 3, np.arange(64) * 1.5).astype(np.uint8)


def png(orientation: int) -> bytes:
    return with_exif(cv2.imencode(".png", GREY)[1].tobytes(), tiff_header(orientation))


@pytest.mark.parametrize("orientation", range(1, 9))
def test_calibration_localization_and_a_camera_read_alike(
    orientation: int, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    path = tmp_path / "12.25.png"
    path.write_bytes(png(orientation))
    (stamped,) = read_sequence(tmp_path)
    for picture in (read_grey(path), stamped.read()):
        grey = picture.pixels if picture.pixels.ndim == 2 else picture.pixels[..., 0]
        np.testing.assert_array_equal(grey, GREY)
        assert picture.asks_to_be_turned == (orientation > 1)
    with caplog.at_level(logging.WARNING):
        settings = CameraSourceSettings(source=str(tmp_path))
        camera = open_camera(lens(64, 48), settings, lambda: 0.0)
        frame = camera.newest()
        camera.close()
    assert frame is not None
    grey = frame.image if frame.image.ndim == 2 else frame.image[..., 0]
    np.testing.assert_array_equal(grey, GREY)
    told = [record.getMessage() for record in caplog.records]
    assert any("by EXIF that it is to be turned" in line for line in told) == (orientation > 1)


@pytest.mark.parametrize("orientation", range(1, 9))
def test_a_recorded_picture_is_replayed_as_it_left_the_sensor(orientation: int) -> None:
    message = new(
        "sensor_msgs/msg/CompressedImage",
        header=new(
            "std_msgs/msg/Header",
            stamp=new("builtin_interfaces/msg/Time", sec=1, nanosec=0),
            frame_id="camera",
        ),
        format="png",
        data=np.frombuffer(png(orientation), np.uint8),
    )
    _, grey = picture_of(to_cdr(message, "sensor_msgs/msg/CompressedImage"), (48, 64))
    np.testing.assert_array_equal(grey, GREY)
