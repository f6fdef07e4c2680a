"""What any camera must do, for all that there are."""

import threading

import numpy as np
import pytest
from camera_sources import Emulator, Folder, Video, grey, until
from fake_picamera2 import PiRibbon
from fake_v4l2 import Webcam

from robot.cameras.camera import Camera
from robot.cameras.settings import CameraSourceSettings
from robot.settings import SettingError

KINDS = {
    "folder": Folder,
    "video": Video,
    "webcam": Webcam,
    "pi": PiRibbon,
    "emulator": Emulator,
}
WITH_A_THREAD = ("webcam", "pi", "emulator")


@pytest.fixture
def make(tmp_path):
    made = []

    def one(kind, **options):
        made.append(KINDS[kind](tmp_path, **options))
        return made[-1]

    yield one
    for source in made:
        source.close()
    assert "camera" not in {thread.name for thread in threading.enumerate()}


@pytest.fixture(params=KINDS)
def source(request, make):
    return make(request.param)


def test_it_is_a_camera_with_a_name(source):
    assert isinstance(source.camera, Camera)
    assert source.camera.name


def test_pictures_have_the_size_of_the_lens_and_cannot_be_changed(source):
    frame = source.next()
    assert frame.image.shape[:2] == (source.lens.height, source.lens.width)
    assert frame.image.dtype == np.uint8
    with pytest.raises(ValueError, match="read-only"):
        frame.image[0, 0] = 0


def test_each_picture_is_handed_out_once_and_in_order(source):
    for _ in range(5):
        frame = source.next()
        assert frame.image[-1, -1].mean() == pytest.approx(grey(source.exposed - 1), abs=6)
        assert source.camera.newest() is None


def test_stamps_are_on_the_clock_and_rise(source):
    stamps, times = [], []
    for _ in range(5):
        times.append(source.now())
        stamps.append(source.next().stamp)
        # A picture's middle may lie half a readout after its first row came in.
        assert times[-1] - 0.1 < stamps[-1] <= source.now() + source.lens.readout / 2
    assert np.all(np.diff(stamps) > 0)


def test_there_is_no_problem_while_pictures_come(source):
    source.next()
    assert source.camera.problem is None


@pytest.mark.parametrize("kind", KINDS)
def test_a_picture_of_another_size_is_a_problem_that_names_both(make, kind):
    source = make(kind, size=(128, 80))
    if kind != "webcam":  # whose size is asked for before the first picture
        source.expose()

    def named():
        assert source.camera.newest() is None
        told = source.camera.problem or ""
        return "128 x 80" in told and "96 x 64" in told

    until(named)


@pytest.mark.parametrize("kind", [kind for kind in KINDS if kind != "pi"])
def test_a_camera_mounted_upside_down_is_turned(make, kind):
    source = make(kind, settings=CameraSourceSettings(rotation=180))
    image = source.next().image
    assert image[-1, -1].mean() > 240
    assert image[0, 0].mean() < 200


def test_after_closing_there_are_no_pictures(source):
    source.next()
    source.expose()
    source.close()
    source.camera.close()
    assert source.camera.newest() is None
    assert "closed" in source.camera.problem


@pytest.mark.parametrize("kind", WITH_A_THREAD)
def test_without_a_picture_so_far_there_is_a_problem(make, kind):
    source = make(kind)
    assert source.camera.newest() is None
    assert "is being started" in source.camera.problem


@pytest.mark.parametrize("kind", ["webcam", "pi"])
def test_a_camera_that_fails_is_a_problem_and_opened_again(make, kind):
    source = make(kind)
    before = source.next()
    source.sent.put(None)
    until(lambda: source.camera.problem)
    assert source.camera.newest() is None
    until(lambda: len(source.opened) >= 2)
    after = source.next()
    assert after.stamp > before.stamp
    assert source.camera.problem is None


@pytest.mark.parametrize("kind", ["webcam", "pi"])
def test_a_camera_that_is_taken_by_others_is_a_problem_until_it_is_free(make, kind):
    source = make(kind)
    source.next()
    source.plugged = False
    source.sent.put(None)
    until(lambda: "another program" in (source.camera.problem or ""))
    source.plugged = True
    source.expose()
    assert until(source.camera.newest)
    assert source.camera.problem is None


@pytest.mark.parametrize("rotation", [-180, 90, 179, 360])
def test_pictures_are_turned_by_half_a_turn_or_not_at_all(rotation):
    with pytest.raises(SettingError, match=r"rotation is .*180"):
        CameraSourceSettings(rotation=rotation)
