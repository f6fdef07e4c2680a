"""The serial port itself: opened or refused, found by the Pi's model, given up, and left."""

import errno
import os
import threading
from contextlib import closing

import pytest
import serial
from pseudo_terminals import PATIENCE

from robot.errors import PortError
from robot.hat import serial_port
from robot.hat.serial_port import SerialPort, find_device

pytestmark = pytest.mark.usefixtures("nothing_is_left")


def test_a_board_that_wakes_up_hears_the_farewell_on_a_line_of_its_own(pty):
    with closing(SerialPort(pty.name)) as port:
        port.put(b"x" * 1_000_000)
        port.exchange(0)
        heard = []

        def board():
            heard.append(b"")
            while not heard[0].endswith(b"stop\r"):
                heard[0] += pty.read(1)

        reader = threading.Thread(target=board)
        reader.start()
        assert port.finish(b"stop\r", PATIENCE)
        reader.join(PATIENCE)
    assert heard[0].endswith(b"x\rstop\r")
    assert len(heard[0]) < 100_000


def test_a_port_that_takes_nothing_for_long_is_given_up(pty):
    now = [0.0]
    with closing(SerialPort(pty.name, clock=lambda: now[0])) as port:
        port.put(b"x" * 1_000_000)
        with pytest.raises(PortError, match="accepts no data"):
            for _ in range(10_000):
                now[0] += serial_port.STUCK_S + 0.1
                port.exchange(0)


@pytest.mark.parametrize(
    ("error", "cure"),
    [
        (errno.ENOENT, "raspi-config"),
        (errno.EACCES, "dialout"),
        (errno.EBUSY, "another program"),
        (errno.EAGAIN, "another program"),
        (errno.EIO, "cannot be opened"),
    ],
)
def test_what_cannot_be_opened_says_why_and_the_cure(monkeypatch, error, cure):
    def refuse(*args, **kwargs):
        raise serial.SerialException(error, os.strerror(error))

    monkeypatch.setattr(serial.Serial, "open", refuse)
    with pytest.raises(PortError, match=cure):
        SerialPort("/dev/serial0")


def test_what_is_no_serial_port_is_refused(tmp_path):
    (tmp_path / "file").write_bytes(b"")
    with pytest.raises(PortError, match="cannot be opened as a serial port"):
        SerialPort(str(tmp_path / "file"))


@pytest.mark.parametrize(
    ("model", "device"),
    [
        ("Raspberry Pi 5 Model B Rev 1.0\0", "/dev/ttyAMA0"),
        ("Raspberry Pi 500 Rev 1.0\0", "/dev/ttyAMA0"),
        ("Raspberry Pi Compute Module 5 Rev 1.0\0", "/dev/ttyAMA0"),
        ("Raspberry Pi 4 Model B Rev 1.5\0", "/dev/serial0"),
        ("Raspberry Pi Zero 2 W Rev 1.0\0", "/dev/serial0"),
        ("Raspberry Pi Compute Module 4 Rev 1.5\0", "/dev/serial0"),
        (None, "/dev/serial0"),
    ],
)
def test_the_port_on_the_header_by_the_pis_model(tmp_path, model, device):
    path = tmp_path / "model"
    if model is not None:
        path.write_text(model, encoding="utf-8")
    assert find_device(path) == device
