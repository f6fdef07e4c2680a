"""The serial port without a wire."""

from __future__ import annotations

import os
import select
from pathlib import Path

import pytest
import serial

from robot.errors import PortError
from sim.hat_emulator.pseudo_terminal import PseudoTerminal


@pytest.fixture
def terminal():
    made = PseudoTerminal()
    yield made
    made.close()


def open_descriptors() -> int:
    return len(list(Path("/proc/self/fd").iterdir()))


def received(terminal: PseudoTerminal, count: int) -> bytes:
    """The bytes that come within a second."""
    data = b""
    while len(data) < count and select.select([terminal], [], [], 1)[0]:
        data += terminal.read()
    return data


def test_every_byte_passes_both_ways_unchanged(terminal: PseudoTerminal) -> None:
    everything = bytes(range(256))
    with serial.Serial(terminal.name, 115200, timeout=1) as port:
        port.write(everything)
        assert received(terminal, 256) == everything
        assert terminal.write(everything) == 256
        assert port.read(256) == everything


def test_it_is_raw_before_anybody_has_opened_it(terminal: PseudoTerminal) -> None:
    end = os.open(terminal.device, os.O_RDWR | os.O_NOCTTY)
    try:
        terminal.write(b"echoed?\r\n")
        assert os.read(end, 100) == b"echoed?\r\n"
        assert terminal.read() == b""
        os.write(end, b"version\r")
        assert received(terminal, 8) == b"version\r"
    finally:
        os.close(end)


def test_reading_nothing_is_empty_before_between_and_after_programs(
    terminal: PseudoTerminal,
) -> None:
    assert terminal.read() == b""
    for _ in range(2):
        with serial.Serial(terminal.name):
            assert terminal.read() == b""
        assert terminal.read() == b""


def test_what_nobody_reads_is_dropped_without_waiting(terminal: PseudoTerminal) -> None:
    taken = [terminal.write(b"x" * 1024) for _ in range(200)]
    assert taken[0] == 1024
    assert taken[-1] == 0


def test_what_was_left_by_another_program_is_flushed_when_one_opens(
    terminal: PseudoTerminal,
) -> None:
    terminal.write(b"old\r\n")
    with serial.Serial(terminal.name, timeout=1) as port:
        terminal.write(b"new\r\n")
        assert port.readline() == b"new\r\n"


def test_a_link_leads_to_the_device_and_goes_with_it(tmp_path: Path) -> None:
    link = tmp_path / "hat"
    terminal = PseudoTerminal(link)
    assert terminal.name == str(link)
    assert str(link.readlink()) == terminal.device
    terminal.close()
    terminal.close()
    assert not link.is_symlink()


def test_a_link_left_by_a_program_that_was_killed_is_replaced(tmp_path: Path) -> None:
    link = tmp_path / "hat"
    link.symlink_to("/dev/pts/nothing")
    terminal = PseudoTerminal(link)
    assert str(link.readlink()) == terminal.device
    terminal.close()


def test_a_link_that_is_another_program_s_by_now_stays(tmp_path: Path) -> None:
    link = tmp_path / "hat"
    first, second = PseudoTerminal(link), PseudoTerminal(link)
    first.close()
    assert str(link.readlink()) == second.device
    second.close()


def test_a_file_is_never_replaced_by_a_link(tmp_path: Path) -> None:
    file = tmp_path / "precious"
    file.write_text("precious")
    descriptors = open_descriptors()
    with pytest.raises(PortError, match="precious is there and no link"):
        PseudoTerminal(file)
    assert file.read_text() == "precious"
    assert open_descriptors() == descriptors
    with pytest.raises(PortError, match="can be made: No such file"):
        PseudoTerminal(tmp_path / "nowhere" / "hat")


def test_after_closing_it_says_so(terminal: PseudoTerminal) -> None:
    terminal.close()
    with pytest.raises(PortError, match="closed"):
        terminal.read()
