"""The board as a whole: its clock, its wire, its start, and what it survives."""

from __future__ import annotations

import pytest
from hat_boards import COMBINED, Bench

from sim.hat.bootloader import checksum
from sim.hat.emulated_board import EmulatedBoard
from sim.hat.motor_figures import DeviceError
from sim.hat.plants import FreeMotors

IMAGE = b"an image 1737564117 2025-01-22T16:41:57+00:00 as it says itself"
SIGNATURE = bytes(range(64))


def load(bench: Bench, image: bytes = IMAGE) -> bytes:
    """Everything that the host does before it starts an image; what the board said to it."""
    heard = bench.say("clear", 0.1)
    heard += bench.say(f"load {len(image)} {checksum(image)}", 0.1)
    heard += bench.say(b"\x02" + image + b"\x03", 0.1)
    heard += bench.say("signature 64", 0.1)
    heard += bench.say(b"\x02" + SIGNATURE + b"\x03", 0.1)
    return heard


def test_time_passes_only_by_advancing_and_parts_of_a_millisecond_add_up() -> None:
    board = Bench().board
    for _ in range(25):
        board.advance(0.0002)
    assert board.now == pytest.approx(0.005)
    board.receive(b"vin\r")
    assert board.advance(0.0) == b""
    assert board.advance(0.0009) == b""
    with pytest.raises(DeviceError, match="0 or more"):
        board.advance(-0.1)


def test_bytes_leave_at_115200_baud() -> None:
    bench = Bench(motors=0)
    bench.board.print_text("x" * 2000)
    assert len(bench.board.advance(0.1)) == pytest.approx(1152, abs=1)
    assert len(bench.board.advance(0.1)) == 2000 - 1152


def test_bytes_arrive_at_115200_baud() -> None:
    bench = Bench(motors=0)
    bench.board.receive(b" " * 112 + b"vin\r")
    assert bench.until("\r\n", 0.05) == pytest.approx(116 / 11520, abs=0.0015)


def test_a_silent_board_says_and_hears_nothing_and_time_goes_on() -> None:
    bench = Bench()
    bench.say(f"port 0;{COMBINED}")
    bench.board.silent = True
    assert bench.say("port_plimit 1;set 1", 0.5) == b""
    bench.board.silent = False
    assert bench.steps(1) == [0]
    assert bench.lines(0.1) != []


def test_a_bad_wire_spoils_bytes_the_same_way_for_the_same_seed() -> None:
    heard = []
    for seed in (1, 1, 2):
        bench = Bench(motors=0, seed=seed)
        bench.board.garble = 0.05
        bench.board.print_text("abc" * 1000)
        heard.append(bench.board.advance(0.5))
    assert heard[0] == heard[1] != heard[2]
    assert b"\0" in heard[0]
    assert set(heard[0]) > set(b"abc\0")
    with pytest.raises(DeviceError, match="0 to 1"):
        bench.board.garble = 2.0


def test_a_bad_wire_spoils_what_comes_in_as_what_goes_out() -> None:
    heard = []
    for seed in (1, 1, 2):
        bench = Bench(motors=0, seed=seed)
        bench.say("echo 1")
        bench.board.garble_in = 0.05
        bench.board.receive((b"#" + b"ab" * 100 + b"\r") * 20)
        heard.append(bench.board.advance(1.0))
    assert heard[0] == heard[1] != heard[2]
    assert b"\0" in heard[0], "zeroed"
    assert set(heard[0]) > set(b"#ab\0\r\n"), "changed by a bit"
    assert b"aa" in heard[0] or b"bb" in heard[0], "lost or doubled"
    with pytest.raises(DeviceError, match="0 to 1"):
        bench.board.garble_in = 2.0


def test_a_line_that_loses_bytes_on_the_way_in_makes_an_upload_time_out() -> None:
    bench = Bench(motors=0, warm=False)
    bench.board.advance(0.1)
    bench.say(f"load 5000 {checksum(bytes(5000))}", 0.1)
    bench.board.loss = 0.001
    bench.board.receive(b"\x02" + bytes(5000) + b"\x03")
    assert bench.until("Timed out waiting for data", 3.0) == pytest.approx(1.43, abs=0.05)
    with pytest.raises(DeviceError, match="0 to 1"):
        bench.board.loss = -0.1


def test_settings_survive_a_client_that_leaves() -> None:
    bench = Bench()
    bench.say(f"port 0;{COMBINED};port_plimit 1;set 1;echo 1")
    bench.board.advance(30.0)
    assert bench.board.duty(0) == 1.0
    assert b"P0>" in bench.say("port 0")


@pytest.mark.parametrize("late", [3, 17])
def test_a_late_pass_is_told_and_its_drive_ticks_are_made_up(late: int) -> None:
    bench = Bench(motors=0)
    bench.board.late(late)
    assert bench.lines(0.1) == [f"deltat={late:08X}"]


def test_a_pass_of_2_ms_is_not_told() -> None:
    bench = Bench(motors=0)
    bench.board.late(2)
    assert bench.lines(0.1) == []


def test_a_warm_board_greets_nobody() -> None:
    assert Bench(motors=4).lines(1.0) == []


def test_a_cold_board_waits_in_its_bootloader() -> None:
    bench = Bench(warm=False)
    assert bench.board.advance(0.1) == b"\r\nType help <RETURN> for help\r\nBHBL> "
    assert bench.say("list") == b"list\r\nError\r\nBHBL> "
    assert bench.board.duty(0) is None


def test_an_uploaded_firmware_starts_with_its_banner_and_finds_the_motors() -> None:
    bench = Bench(motors=2, warm=False)
    bench.board.advance(0.1)
    assert b"Checksum OK" in load(bench)
    bench.board.receive(b"reboot\r")
    bench.until("Rebooting...\r\n", 0.5)
    # The jump is 100 ms after the line was made, but the line has others to wait for on the wire.
    assert 0.05 <= bench.until("Type help <RETURN> for help\r\n", 0.2) <= 0.106
    banner = bench.lines(0.25)
    assert banner == [
        "Initialising ports",
        "Resetting drivers: 0123",
        "Reading driver dumps: before port_initdriver(): 0123",
        "Reading driver dumps: after port_initdriver(): 0123",
        "Done initialising ports",
    ]
    assert bench.until("P0: connecting", 0.4) < 0.25
    assert bench.until("P0: established", 3.0) == pytest.approx(2.1, abs=0.1)
    bench.until("P1: established", 0.5)
    assert b" 00 01 02 03 " in bench.say("signature")
    assert b" 1737564117 2025-01-22T16:41:57+00:00" in bench.say("version")


def test_a_reset_stops_the_motors_and_forgets_the_firmware() -> None:
    bench = Bench()
    bench.say(f"port 0;{COMBINED};port_plimit 1;set 1", 0.5)
    bench.board.reset()
    assert bench.board.in_bootloader
    assert bench.plants.plant(0).duty is None
    assert bench.board.advance(0.5) == b"\r\nType help <RETURN> for help\r\nBHBL> "
    bench.board.advance(1.0)
    assert bench.plants.plant(0).speed == 0, "it has run out"


def test_another_version_is_another_board_until_it_is_loaded() -> None:
    plants = FreeMotors()
    board = EmulatedBoard(plants, {}, version=1670596313)
    board.receive(b"version\r")
    assert board.advance(0.1) == b"\r\nFirmware version: 1670596313 2022-12-09T14:31:53+00:00\r\n"


def test_what_is_asked_of_the_board_is_checked() -> None:
    bench = Bench()
    with pytest.raises(DeviceError, match="0 to 3"):
        bench.board.unplug(4)
    with pytest.raises(DeviceError, match="framing, checksum, silence"):
        bench.board.setup_fails(0, "boredom")
    with pytest.raises(DeviceError, match="1 or more"):
        bench.board.late(0)
    bench.board.reset()
    with pytest.raises(DeviceError, match="bootloader"):
        bench.board.setup_fails(0, "framing")


def test_two_motors_at_100_hz_take_40_percent_of_the_wire() -> None:
    bench = Bench(motors=2)
    bench.say(f"plimit 1;port 0;{COMBINED};set 1;port 1;{COMBINED};set -1", 9.0)
    assert 0.35 <= len(bench.board.advance(1.0)) / 11520 <= 0.42
