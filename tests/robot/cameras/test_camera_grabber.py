"""The thread that takes pictures: newest wins, and what stalls is opened again."""

import logging
import threading

import numpy as np
import pytest
from camera_sources import lens, until

from robot.cameras import grabber as grabbing
from robot.cameras.camera import PictureError
from robot.cameras.grabber import Grabber
from robot.interface import Frame

LENS = lens()


def frame(stamp):
    return Frame(stamp, np.zeros((LENS.height, LENS.width), np.uint8))


class Clock:
    """Stands, until a test moves it."""

    def __init__(self):
        self.now = 100.0

    def __call__(self):
        return self.now


class Scripted:
    """A device whose every answer stands in a list; then it waits for more, and gives none."""

    name = "the scripted camera"

    def __init__(self, clock, *answers, openings=()):
        self.clock = clock
        self.answers = list(answers)
        self.openings = list(openings)
        self.opened = self.closed = self.waits = 0

    def open(self):
        self.opened += 1
        if self.openings and (failure := self.openings.pop(0)):
            raise failure

    def grab(self, timeout):
        if not self.answers:
            self.waits += 1
            threading.Event().wait(0.001)
            return None
        answer = self.answers.pop(0)
        if isinstance(answer, Exception):
            raise answer
        return answer

    def close(self):
        self.closed += 1


@pytest.fixture
def run():
    started = []

    def start(device, rate=30.0, first_retry=0.001):
        started.append(Grabber(device, LENS, rate, device.clock, first_retry))
        started[-1].start()
        return started[-1]

    yield start
    for one in started:
        one.close()


def test_the_newest_picture_wins(run):
    device = Scripted(Clock(), frame(1.0), frame(2.0), frame(3.0))
    camera = run(device)
    until(lambda: device.waits)
    assert camera.newest().stamp == 3.0
    assert camera.newest() is None


def test_a_picture_that_was_sent_before_is_no_picture(run):
    device = Scripted(Clock(), frame(1.0), frame(2.0))
    camera = run(device)
    until(lambda: device.waits)
    assert camera.newest().stamp == 2.0
    device.answers += [frame(2.0), frame(1.5)]
    until(lambda: not device.answers)
    assert camera.newest() is None


@pytest.mark.parametrize(("rate", "patience"), [(30.0, 0.5), (2.0, 1.5)])
def test_a_stall_is_a_problem_and_the_device_is_opened_again(run, rate, patience):
    device = Scripted(Clock(), frame(100.0))
    camera = run(device, rate)
    until(camera.newest)
    device.clock.now += patience - 0.01
    waits = device.waits
    until(lambda: device.waits > waits + 2)
    assert camera.problem is None
    assert device.opened == 1
    device.clock.now += 0.02
    assert "no pictures any more" in camera.problem
    assert camera.newest() is None
    until(lambda: device.opened == 2)
    assert device.closed == 1
    device.answers.append(frame(102.0))
    assert until(camera.newest).stamp == 102.0
    assert camera.problem is None


def test_a_driver_that_hangs_is_told_though_its_thread_hangs_too(run):
    entered, leave = threading.Event(), threading.Event()
    device = Scripted(Clock(), frame(100.0))
    script = device.grab

    def grab(timeout):
        if device.answers:
            return script(timeout)
        entered.set()
        leave.wait(20)
        return None

    device.grab = grab
    camera = run(device)
    assert entered.wait(20)
    assert camera.problem is None
    device.clock.now += 0.51
    assert "no pictures any more" in camera.problem
    leave.set()


def test_the_first_picture_may_take_longer_than_others(run):
    device = Scripted(Clock())
    camera = run(device)
    until(lambda: device.waits)
    device.clock.now += 2.9
    waits = device.waits
    until(lambda: device.waits > waits + 2)
    assert device.opened == 1
    assert "is being started" in camera.problem
    device.clock.now += 0.2
    until(lambda: device.opened == 2)


def test_what_a_driver_throws_is_told_logged_and_tried_again(run, caplog):
    device = Scripted(Clock(), frame(1.0), ZeroDivisionError("by the driver"), frame(2.0))
    camera = run(device)
    until(lambda: device.waits)
    assert camera.newest().stamp == 2.0
    assert device.opened == 2
    assert "the scripted camera failed" in caplog.text


def test_the_reason_why_a_device_cannot_be_opened_is_told_until_it_can(run):
    absent = [PictureError("plug it in")] * 3
    device = Scripted(Clock(), openings=absent)
    camera = run(device)
    until(lambda: camera.problem == "plug it in")
    until(lambda: device.waits)
    assert (device.opened, device.closed) == (4, 3)
    assert camera.problem == "plug it in"
    device.answers.append(frame(1.0))
    until(camera.newest)
    assert camera.problem is None


def test_attempts_come_after_half_a_second_then_one_then_two_up_to_eight():
    device = Scripted(Clock(), openings=[PictureError("absent")] * 20)
    camera = Grabber(device, LENS, 30.0, device.clock)
    pauses = []

    class Stopping(threading.Event):
        def wait(self, timeout=None):
            pauses.append(timeout)
            if len(pauses) == 9:
                self.set()
            if len(pauses) == 6:
                device.openings.insert(0, None)
                device.answers = [frame(1.0), PictureError("lost")]
            return self.is_set()

    camera._thread.stopping = Stopping()
    camera.start()
    until(lambda: len(pauses) == 9)
    camera.close()
    # It worked before the seventh pause.
    assert pauses == [0.5, 1, 2, 4, 8, 8, 0.5, 1, 2]


def test_a_device_that_cannot_be_closed_is_told(run, caplog):
    device = Scripted(Clock(), PictureError("lost"), frame(1.0))

    def close():
        device.closed += 1
        if device.closed == 1:
            raise OSError("stuck")

    device.close = close
    camera = run(device)
    until(lambda: device.waits)
    assert camera.newest().stamp == 1.0
    assert "could not be closed" in caplog.text


@pytest.mark.parametrize("call", ["open", "grab", "close"])
def test_a_driver_that_hangs_is_told_to_hang_and_not_to_be_started_anew(run, call):
    """As picamera2 does when the ribbon works loose."""
    inside, leave = threading.Event(), threading.Event()
    device = Scripted(Clock(), frame(1.0), PictureError("lost"))
    usual = getattr(device, call)

    def hang(*arguments):
        if call != "grab" or len(device.answers) < 2:
            inside.set()
            leave.wait(20)
        return usual(*arguments)

    setattr(device, call, hang)
    camera = run(device)
    assert inside.wait(20)
    device.clock.now += grabbing.HUNG_S + 0.1
    assert "the scripted camera's driver hangs" in camera.problem
    assert "start the program again" in camera.problem
    leave.set()
    until(lambda: device.waits)
    assert "hangs" not in (camera.problem or "")


def test_closing_closes_the_device_and_ends_the_thread(run):
    device = Scripted(Clock(), frame(1.0))
    camera = run(device)
    until(lambda: device.waits)
    camera.close()
    camera.close()
    assert device.closed == 1
    assert camera.newest() is None
    assert "camera" not in {thread.name for thread in threading.enumerate()}


def test_closing_interrupts_the_wait_before_the_next_attempt(run):
    device = Scripted(Clock(), openings=[PictureError("absent")])
    camera = run(device, first_retry=3600.0)
    until(lambda: device.closed)
    camera.close()
    assert not camera._thread.alive


def test_a_thread_that_does_not_end_is_complained_about(run, monkeypatch, caplog):
    opening, leave = threading.Event(), threading.Event()
    device = Scripted(Clock())
    device.open = lambda: opening.set() or leave.wait(20)
    monkeypatch.setattr(grabbing, "JOIN_S", 0.01)
    camera = run(device)
    assert opening.wait(20)
    with caplog.at_level(logging.ERROR):
        camera.close()
    assert "did not end within" in caplog.text
    leave.set()
    until(lambda: not camera._thread.alive)


def test_closing_what_was_never_started_is_fine():
    Grabber(Scripted(Clock()), LENS, 30.0).close()
