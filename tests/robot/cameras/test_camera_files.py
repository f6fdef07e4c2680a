"""Folders of pictures and videos as cameras."""

import cv2
import numpy as np
import pytest
from camera_sources import Folder, Video, grey, lens, picture
from hypothesis import given
from hypothesis import strategies as st

from robot.cameras.choice import open_camera
from robot.cameras.files import FileCamera
from robot.cameras.settings import CameraSourceSettings

LENS = lens()
RATE = 25.0
PERIOD = 1 / RATE


class Numbers:
    """Pictures that only count."""

    name = "numbers"

    def __init__(self):
        self.count = -1

    def next(self, skip):
        self.count += skip + 1
        return np.full((LENS.height, LENS.width), self.count % 256, np.uint8)

    def close(self):
        self.closed = True


class Clock:
    def __init__(self, now=100.0):
        self.now = now

    def __call__(self):
        return self.now


@pytest.fixture
def clock():
    return Clock()


@pytest.fixture
def numbers(clock):
    return FileCamera(Numbers(), LENS, RATE, 0, clock)


def number(frame):
    return int(frame.image[0, 0])


def test_the_first_picture_is_due_at_once(numbers, clock):
    frame = numbers.newest()
    assert (number(frame), frame.stamp) == (0, clock.now)


def test_a_picture_is_not_due_before_its_time(numbers, clock):
    numbers.newest()
    clock.now += PERIOD * 0.99
    assert numbers.newest() is None
    clock.now += PERIOD * 0.02
    frame = numbers.newest()
    assert (number(frame), frame.stamp) == (1, pytest.approx(100.0 + PERIOD))


def test_what_was_not_fetched_in_time_is_skipped(numbers, clock):
    numbers.newest()
    clock.now += 5.5 * PERIOD
    frame = numbers.newest()
    assert (number(frame), frame.stamp) == (5, pytest.approx(100.0 + 5 * PERIOD))
    assert numbers.newest() is None


def test_after_a_long_pause_nothing_is_skipped_and_the_pace_starts_anew(numbers, clock):
    numbers.newest()
    clock.now += 3600.0
    frame = numbers.newest()
    assert (number(frame), frame.stamp) == (1, clock.now)
    clock.now += PERIOD
    assert number(numbers.newest()) == 2


@given(pauses=st.lists(st.floats(0.0, 3.0), max_size=30), rate=st.floats(1, 120))
def test_stamps_rise_are_never_ahead_and_no_picture_comes_twice(pauses, rate):
    clock = Clock()
    camera = FileCamera(Numbers(), LENS, rate, 0, clock)
    frames = []
    for pause in pauses:
        clock.now += pause
        frame = camera.newest()
        if frame is not None:
            assert clock.now - 1.0 - 1 / rate < frame.stamp <= clock.now + 1e-5
            frames.append(frame)
    assert np.all(np.diff([frame.stamp for frame in frames]) > 0)


def test_closing_closes_the_file(clock):
    pictures = Numbers()
    FileCamera(pictures, LENS, RATE, 0, clock).close()
    assert pictures.closed


# --- files -----------------------------------------------------------------------------------


@pytest.mark.parametrize("kind", [Folder, Video])
def test_after_the_last_picture_comes_the_first(tmp_path, kind):
    source = kind(tmp_path)
    values = [source.next().image[-1, -1].mean() for _ in range(25)]
    assert values == pytest.approx([grey(n) for n in range(25)], abs=6)
    source.close()


@pytest.mark.parametrize("kind", [Folder, Video])
def test_skipping_goes_over_the_end(tmp_path, kind):
    source = kind(tmp_path)
    source.next()
    source.time += 13 / source.settings.frame_rate
    assert source.camera.newest().image[-1, -1].mean() == pytest.approx(grey(13), abs=6)
    source.close()


def test_pictures_come_in_the_order_of_their_names(tmp_path):
    for name, value in (("b.png", 2), ("a.PGM", 1), ("c.bmp", 3)):
        cv2.imwrite(str(tmp_path / name), np.full((LENS.height, LENS.width), value, np.uint8))
    (tmp_path / "notes.txt").write_text("no picture")
    clock = Clock()
    camera = open_camera(LENS, CameraSourceSettings(source=str(tmp_path)), clock)
    seen = []
    for _ in range(3):
        seen.append(number(camera.newest()))
        clock.now += 1 / 30
    assert seen == [1, 2, 3]


def test_a_grey_picture_stays_grey_and_a_coloured_one_coloured(tmp_path):
    coloured = np.zeros((LENS.height, LENS.width, 3), np.uint8)
    coloured[..., 2] = 200
    cv2.imwrite(str(tmp_path / "0.png"), picture(0, LENS.width, LENS.height))
    cv2.imwrite(str(tmp_path / "1.png"), coloured)
    clock = Clock()
    camera = open_camera(LENS, CameraSourceSettings(source=str(tmp_path)), clock)
    assert camera.newest().image.ndim == 2
    clock.now += 1 / 30
    assert np.array_equal(camera.newest().image, coloured)


def test_a_picture_that_cannot_be_read_is_a_problem_and_the_next_comes(tmp_path):
    (tmp_path / "0.png").write_bytes(b"no picture at all")
    cv2.imwrite(str(tmp_path / "1.png"), picture(1, LENS.width, LENS.height))
    clock = Clock()
    camera = open_camera(LENS, CameraSourceSettings(source=str(tmp_path)), clock)
    assert camera.newest() is None
    assert "0.png is no picture" in camera.problem
    clock.now += 1 / 30
    assert camera.newest() is not None
    assert camera.problem is None


def test_a_folder_without_pictures_is_refused_naming_what_is_one(tmp_path):
    (tmp_path / "notes.txt").write_text("no picture")
    with pytest.raises(ValueError, match=r"has no pictures; valid are .*\.png"):
        open_camera(LENS, CameraSourceSettings(source=str(tmp_path)))


def test_a_file_that_is_no_video_is_refused_naming_what_is_valid(tmp_path):
    path = tmp_path / "video.mp4"
    path.write_bytes(b"no video at all" * 100)
    with pytest.raises(ValueError, match=r"is no video .*folder of pictures"):
        open_camera(LENS, CameraSourceSettings(source=str(path)))


def test_a_video_runs_at_its_own_pace(tmp_path):
    source = Video(tmp_path, settings=CameraSourceSettings(frame_rate=5))
    source.camera.newest()
    source.time += 1 / 30 + 1e-3
    assert source.camera.newest() is not None
    source.close()


def test_a_video_that_vanished_is_a_problem_when_it_is_to_begin_anew(tmp_path):
    source = Video(tmp_path)
    for _ in range(10):
        source.next()
    (tmp_path / "video.avi").unlink()
    source.expose()
    assert source.camera.newest() is None
    assert "cannot be read any more" in source.camera.problem
    source.close()
