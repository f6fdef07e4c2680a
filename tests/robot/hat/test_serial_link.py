"""The thread at the Build HAT's port, over real pseudo-terminals."""

import queue
import threading
from contextlib import closing, contextmanager

import pytest
from pseudo_terminals import PATIENCE, Pty

from robot.errors import PortError
from robot.hat import serial_link
from robot.hat.serial_link import SerialLink
from robot.hat.start.reset_line import ResetError

pytestmark = pytest.mark.usefixtures("nothing_is_left")


class Listener:
    """A talker that tells the test what it was told."""

    def __init__(self, answers=None):
        self.told = queue.Queue()
        self.answers = answers or {}
        self.wants_reset = False
        self.ticks = queue.Queue()

    def _tell(self, *what):
        self.told.put(what)
        answer = self.answers.get(what[0], b"")
        if isinstance(answer, Exception):
            raise answer
        return answer

    def opened(self, now):
        return self._tell("opened")

    def receive(self, data, now):
        return self._tell("receive", data)

    def tick(self, now):
        self.ticks.put(now)
        answer = self.answers.get("tick", b"")
        if isinstance(answer, Exception):
            raise answer
        return answer

    def lost(self, reason, now):
        self._tell("lost", reason)

    def was_reset(self, now):
        self.wants_reset = False
        self._tell("was_reset")

    def cannot_reset(self, reason, now):
        self.wants_reset = False
        self._tell("cannot_reset", reason)

    def farewell(self):
        return self._tell("farewell")

    def next(self):
        return self.told.get(timeout=PATIENCE)


@contextmanager
def linked(device, talker, **more):
    link = SerialLink(device, talker, **more)
    link.start()
    try:
        yield link
    finally:
        link.close()
        assert not link.alive


def test_bytes_go_both_ways_and_nothing_is_translated(pty):
    everything = bytes(range(256))
    talker = Listener({"opened": b"hello\r", "receive": everything})
    with linked(pty.name, talker):
        assert talker.next() == ("opened",)
        assert pty.read(6) == b"hello\r"
        pty.write(b"\0\r\n\xff\x11\x13\x03")
        assert talker.next() == ("receive", b"\0\r\n\xff\x11\x13\x03")
        assert pty.read(256) == everything


def test_the_thread_has_its_name_and_ticks_at_its_period(pty):
    talker = Listener({"tick": b"."})
    with linked(pty.name, talker, period=0.005) as link:
        stamps = [talker.ticks.get(timeout=PATIENCE) for _ in range(20)]
        assert "build hat" in {thread.name for thread in threading.enumerate()}
        assert pty.read(20) == b"." * 20
        assert link.alive
    assert stamps[-1] - stamps[0] >= 19 * 0.005 - 1e-3


def test_a_farewell_is_sent_before_the_port_is_closed(pty):
    talker = Listener({"farewell": b"port 0;pwm;off\r"})
    with linked(pty.name, talker):
        talker.next()
    assert pty.read(15) == b"port 0;pwm;off\r"
    assert talker.next() == ("farewell",)


def test_closing_twice_or_before_the_start_is_fine(pty):
    link = SerialLink(pty.name, Listener())
    link.close()
    link = SerialLink(pty.name, Listener())
    link.start()
    link.close()
    link.close()
    assert not link.alive


def test_a_board_that_takes_nothing_does_not_keep_the_thread(pty, monkeypatch):
    """The farewell cuts in: what waits is dropped, and the cut line is ended before it."""
    monkeypatch.setattr(serial_link, "FAREWELL_S", 0.05)
    talker = Listener({"opened": b"x" * 1_000_000, "farewell": b"stop\r"})
    with linked(pty.name, talker):
        assert talker.next() == ("opened",)
        talker.ticks.get(timeout=PATIENCE)
    assert talker.next() == ("farewell",)


def test_a_port_that_goes_away_is_told_and_opened_again(pty, tmp_path, monkeypatch):
    monkeypatch.setattr(serial_link, "REOPEN_S", 0.01)
    device = tmp_path / "hat"
    device.symlink_to(pty.name)
    talker = Listener()
    with linked(str(device), talker):
        assert talker.next() == ("opened",)
        device.unlink()
        pty.close()
        what, reason = talker.next()
        assert (what, "is gone" in reason) == ("lost", True)
        what, reason = talker.next()
        assert (what, "no serial port" in reason) == ("lost", True)
        with closing(Pty()) as another:
            device.symlink_to(another.name)
            assert talker.next() == ("opened",)
            another.write(b"7.98 V\r\n")
            assert talker.next() == ("receive", b"7.98 V\r\n")


def test_a_second_program_is_told_that_the_port_is_taken(pty):
    talker, other = Listener(), Listener()
    with linked(pty.name, talker):
        assert talker.next() == ("opened",)
        with linked(pty.name, other):
            what, reason = other.next()
            assert (what, "another program" in reason) == ("lost", True)
    with linked(pty.name, other):
        assert other.next() == ("opened",)


@pytest.mark.parametrize("where", ["opened", "receive", "tick"])
def test_a_talker_that_fails_stops_the_motors_and_is_told(pty, where, caplog):
    failure = ZeroDivisionError("a defect")
    talker = Listener({where: failure, "farewell": b"stop\r"})
    with linked(pty.name, talker) as link:
        assert talker.next() == ("opened",)
        pty.write(b"x")
        assert pty.read(5) == b"stop\r"
        link._thread.join(PATIENCE)
        assert link.failure is failure
        assert not link.alive
    assert "driver failed" in caplog.text


def test_a_talker_that_fails_as_the_port_goes_away_is_still_what_is_told(pty, caplog):
    failure = ZeroDivisionError("a defect")
    talker = Listener({"receive": failure, "farewell": PortError("/dev/x is gone")})
    with linked(pty.name, talker) as link:
        assert talker.next() == ("opened",)
        pty.write(b"x")
        link._thread.join(PATIENCE)
        assert link.failure is failure
    assert "could not be told to stop: /dev/x is gone" in failure.__notes__[0]


def test_a_reset_that_is_wanted_is_done_and_told(pty):
    pulled = []
    talker = Listener()
    talker.wants_reset = True
    with linked(pty.name, talker, reset=lambda: pulled.append(1)):
        assert [talker.next(), talker.next()] == [("opened",), ("was_reset",)]
    assert pulled == [1]


def test_a_reset_that_cannot_be_is_told(pty):
    def busy():
        raise ResetError("GPIO4 is busy", "free it")

    for reset, said in ((busy, "GPIO4 is busy; free it"), (None, "this program has no reset pin")):
        talker = Listener()
        talker.wants_reset = True
        with linked(pty.name, talker, reset=reset):
            assert [talker.next(), talker.next()] == [("opened",), ("cannot_reset", said)]
