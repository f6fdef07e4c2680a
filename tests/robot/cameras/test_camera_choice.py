"""Which camera a name stands for, and the search for any."""

from importlib.util import find_spec

import numpy as np
import pytest
from camera_sources import Emulator, lens, until

from robot.cameras import choice
from robot.cameras.camera import PictureError
from robot.cameras.choice import AutoCamera, open_camera
from robot.cameras.settings import CameraSourceSettings
from robot.interface import Frame

LENS = lens()
not_on_a_pi = pytest.mark.skipif(
    find_spec("picamera2") is not None, reason="a Pi camera may be there"
)


@pytest.fixture
def opened():
    made = []

    def start(source):
        made.append(open_camera(LENS, CameraSourceSettings(source=source)))
        return made[-1]

    yield start
    for camera in made:
        camera.close()


def told(camera):
    return until(lambda: "started" not in (camera.problem or "started") and camera.problem)


def test_an_absent_device_node_is_a_problem_and_no_error(opened):
    assert "/dev/video97 is not there" in told(opened("/dev/video97"))


def test_a_number_is_a_device_node(opened):
    assert opened("97").name == "the camera at /dev/video97"


@not_on_a_pi
def test_the_pi_camera_is_asked_for_by_name(opened):
    camera = opened("pi")
    assert camera.name == "the Pi camera"
    assert told(camera)


def test_an_emulator_that_does_not_run_yet_is_a_problem_and_no_error(opened, tmp_path):
    camera = opened(str(tmp_path / "pictures.sock"))
    assert "start brickpose emulate-hat" in told(camera)


def test_a_socket_is_the_emulators_camera_whatever_its_name(opened, tmp_path):
    source = Emulator(tmp_path)
    source.next()
    socket_path = source.path.rename(tmp_path / "by_another_name")
    source.path = socket_path
    assert str(socket_path) in opened(str(socket_path)).name
    source.close()


def test_a_name_that_can_never_be_is_refused_naming_what_is_valid(tmp_path):
    with pytest.raises(ValueError, match=r"no camera .*auto.*pi.*/dev/video0.*folder.*video.*sock"):
        open_camera(LENS, CameraSourceSettings(source=str(tmp_path / "missing")))


@not_on_a_pi
def test_without_any_camera_the_search_tells_of_each_why(opened, monkeypatch):
    monkeypatch.setattr(choice, "video_nodes", lambda: [choice.Path("/dev/video97")])
    problem = told(opened("auto"))
    assert problem.startswith("no camera was found")
    assert "Pi camera" in problem
    assert "/dev/video97" in problem


# --- the search ------------------------------------------------------------------------------


class Candidate:
    def __init__(self, name, *frames, failure=None):
        self.name = name
        self.frames = list(frames)
        self.failure = failure
        self.is_open = False

    def open(self):
        self.is_open = True
        if self.failure:
            raise self.failure

    def grab(self, timeout):
        return self.frames.pop(0) if self.frames else None

    def close(self):
        self.is_open = False


def frame(stamp):
    return Frame(stamp, np.zeros((LENS.height, LENS.width), np.uint8))


def test_the_first_that_delivers_is_taken_and_the_others_are_left_closed():
    candidates = [
        Candidate("absent", failure=PictureError("plug it in")),
        Candidate("broken", failure=RuntimeError("by the driver")),
        Candidate("silent"),
        Candidate("good", frame(1.0), frame(2.0)),
        Candidate("spare", frame(9.0)),
    ]
    search = AutoCamera(lambda: candidates)
    search.open()
    assert search.name == "good"
    assert [one.is_open for one in candidates] == [False, False, False, True, False]
    # The picture that showed that it delivers is no lost one.
    assert [search.grab(0.1).stamp for _ in range(2)] == [1.0, 2.0]
    assert search.grab(0.1) is None


def test_if_none_delivers_the_reason_of_each_is_told():
    candidates = [
        Candidate("absent", failure=PictureError("plug it in")),
        Candidate("broken", failure=RuntimeError("by the driver")),
        Candidate("silent"),
    ]
    with pytest.raises(PictureError, match=r"plug it in; broken failed: by .*; silent sends no"):
        AutoCamera(lambda: candidates).open()
    assert not any(one.is_open for one in candidates)


def test_cameras_are_listed_anew_at_each_attempt():
    lists = [[], [Candidate("plugged meanwhile", frame(1.0))]]
    search = AutoCamera(lambda: lists.pop(0))
    with pytest.raises(PictureError, match="there is none"):
        search.open()
    search.open()
    assert search.name == "plugged meanwhile"
    search.close()
    search.close()
    assert search.name == "the camera"
    with pytest.raises(PictureError, match="no camera is open"):
        search.grab(0.1)
