"""How devices come and go."""

from __future__ import annotations

import pytest
from hat_boards import COMBINED, LARGE, Bench

from sim.hat.lego_motor import LegoMotor


def test_a_motor_is_seen_after_its_line_was_low_and_usable_two_seconds_later() -> None:
    bench = Bench(motors=0)
    bench.board.plug(1, LegoMotor(LARGE, bench.plants.plant(1)))
    assert 0.1 <= bench.until("P1: connecting to active device\r\n", 1.0) <= 0.31
    assert bench.until("set baud rate to 115200\r\n", 3.0) == pytest.approx(2.0, abs=0.01)
    lines = bench.lines(0.3)
    assert lines[0] == "P1: connected to active ID 4C"
    assert lines[-1] == "P1: established serial communication with active ID 4C"
    listed = bench.say("list", 0.3).decode().split("\r\n")
    assert listed[2 : 2 + len(lines) - 1] == lines[:-1], "the same block"


def test_a_slow_motor_takes_its_time() -> None:
    bench = Bench(motors=0)
    bench.board.plug(0, LegoMotor(LARGE, bench.plants.plant(0), connect_seconds=9.0))
    bench.until("connecting", 1.0)
    assert bench.until("established", 12.0) == pytest.approx(9.1, abs=0.05)


def test_a_connecting_device_is_not_listed() -> None:
    bench = Bench(motors=0)
    bench.board.plug(0, LegoMotor(LARGE, bench.plants.plant(0)))
    bench.until("connecting", 1.0)
    assert b"P0: no device detected" in bench.say("list", 0.1)


def test_a_silent_device_is_lost_after_501_ms_with_both_lines_together() -> None:
    bench = Bench()
    bench.motors[0].responding = False
    heard = bench.until("P0: timeout during data phase: disconnecting\r\n", 1.0)
    assert 0.49 <= heard <= 0.52
    assert bench.lines(0.01) == ["P0: disconnected"]
    assert b"P0: no device detected" in bench.say("list", 0.1)


def test_a_device_that_speaks_again_is_connected_again() -> None:
    bench = Bench()
    bench.motors[0].responding = False
    bench.until("disconnected", 1.0)
    bench.motors[0].responding = True
    bench.until("established", 4.0)


def test_a_quick_replug_is_noticed() -> None:
    bench = Bench()
    bench.board.unplug(0)
    bench.board.advance(0.1)
    bench.board.plug(0, bench.motors[0])
    bench.until("P0: disconnected", 0.6)
    bench.until("established", 4.0)


def test_all_settings_are_gone_after_a_replug() -> None:
    bench = Bench()
    bench.say(f"port 0;{COMBINED};port_plimit 1;pwmparams 0.6 0.1;pwm;set 1")
    bench.board.unplug(0)
    bench.board.advance(0.7)
    assert bench.board.duty(0) == 0.0
    bench.board.plug(0, bench.motors[0])
    bench.until("established", 4.0)
    assert bench.lines(0.3) == []
    assert bench.steps(1) == [0]
    bench.say("select 0;selrate 0;set 0.05", 0.02)
    assert bench.lines(0.02)[-1] == "P0M0:  0", "the combination is gone too"
    assert bench.steps(1) == [12], "and so is the least drive"


def test_the_motor_runs_out_as_soon_as_it_is_unplugged() -> None:
    bench = Bench()
    bench.say("port 0;port_plimit 1;set 1", 0.5)
    bench.board.unplug(0)
    assert bench.plants.plant(0).duty is None
    assert bench.board.duty(0) == 1.0, "the driver itself does not know yet"


def test_position_counts_from_plugging_in() -> None:
    bench = Bench()
    bench.plants.plant(0).angle = 500.0
    bench.board.unplug(0)
    bench.board.advance(0.7)
    bench.board.plug(0, bench.motors[0])
    bench.until("established", 4.0)
    bench.say(f"port 0;{COMBINED}")
    assert bench.lines(0.02)[-1] == "P0C0:  0  0 +140"


@pytest.mark.parametrize(
    ("how", "line", "after"),
    [
        ("framing", "P0: framing error: disconnecting", 0.05),
        ("checksum", "P0: checksum error: disconnecting", 0.05),
        ("silence", "P0: timeout during setup phase: disconnecting", 2.001),
    ],
)
def test_a_failed_introduction_is_told_and_tried_again(how: str, line: str, after: float) -> None:
    bench = Bench(motors=0)
    bench.board.plug(0, LegoMotor(LARGE, bench.plants.plant(0)))
    bench.board.setup_fails(0, how)
    bench.until("connecting to active device\r\n", 1.0)
    assert bench.until(line, 3.0) == pytest.approx(after, abs=0.005)
    lines = bench.lines(3.0)
    assert lines[0] == "P0: connecting to active device", "and no line of a disconnection"
    assert lines[-1] == "P0: established serial communication with active ID 4C"


def test_a_device_unplugged_during_its_introduction_times_out() -> None:
    bench = Bench(motors=0)
    bench.board.plug(0, LegoMotor(LARGE, bench.plants.plant(0)))
    bench.until("connecting to active device\r\n", 1.0)
    bench.board.unplug(0)
    assert bench.lines(3.0) == ["P0: timeout during setup phase: disconnecting"]


def test_more_than_five_errors_end_a_connection() -> None:
    bench = Bench()
    bench.board.data_fails(0, framing=0, checksum=5)
    assert bench.lines(0.3) == []
    bench.board.data_fails(0, framing=2, checksum=4)
    assert bench.lines(0.1) == ["P0: too many errors (2+4): disconnecting", "P0: disconnected"]
    bench.until("established", 4.0)
