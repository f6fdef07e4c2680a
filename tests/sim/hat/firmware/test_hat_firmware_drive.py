"""What the driver of a port puts out: limits, steps, slots, stops and their hazards."""

from __future__ import annotations

import pytest
from hat_boards import COMBINED, Bench
from hypothesis import given
from hypothesis import strategies as st

from sim.hat.firmware.drive import HBridge, fixed_point

SPEED_PID = "pid 0 0 0 s1 1 0 0.003 0.01 0 100 0.01"


def test_a_port_puts_out_a_tenth_until_it_is_told_otherwise() -> None:
    bench = Bench()
    bench.say("port 0;set 1")
    assert bench.steps(1) == [25]
    bench.say("port_plimit 1")
    assert bench.steps(1) == [255]


def test_plimit_is_for_all_ports_and_port_plimit_for_one() -> None:
    bench = Bench(motors=2)
    bench.say("port 0;set 1;port 1;set 1;plimit 0.5;port_plimit 1")
    bench.duties(1)
    assert (bench.board.duty(0), bench.board.duty(1)) == (127 / 255, 1.0)


@pytest.mark.parametrize(("asked", "steps"), [("7", 255), ("-1", 0), ("0.5", 127)])
def test_a_limit_is_brought_within_0_and_1(asked: str, steps: int) -> None:
    bench = Bench()
    bench.say(f"port 0;port_plimit {asked};set 5")
    assert bench.steps(1) == [steps]


@given(st.floats(-2, 2))
def test_steps_are_rounded_down_on_both_sides_of_zero(wanted: float) -> None:
    bridge = HBridge()
    bridge.limit = 65536
    bridge.drive(wanted)
    assert bridge.steps is not None
    assert bridge.steps == pytest.approx(max(-1, min(1, wanted)) * 255 - 0.5, abs=0.51)


def test_the_driver_has_255_steps() -> None:
    bridge = HBridge()
    bridge.limit = 65536
    seen = set()
    for number in range(-1000, 1001):
        bridge.drive(number / 1000)
        seen.add(bridge.steps)
    assert seen == set(range(-255, 256))


def test_drives_below_the_least_are_none() -> None:
    bench = Bench()
    bench.say("port 0;port_plimit 1;pwmparams 0 0.1;set 0.09")
    assert bench.steps(1) == [0]
    bench.say("set 0.11")
    assert bench.steps(1) == [28]


@given(st.integers(1, 64), st.sampled_from([-1, 1]))
def test_small_drives_are_whole_slots_at_the_threshold_in_the_right_proportion(
    percent: int, sign: int
) -> None:
    bridge = HBridge()
    bridge.limit, bridge.threshold = 65536, fixed_point(0.65)
    slots = []
    for _ in range(650):
        bridge.drive(sign * percent / 100)
        slots.append(bridge.steps)
    full = 165 if sign > 0 else -166
    assert set(slots) <= {0, full}
    assert slots.count(full) == pytest.approx(650 * percent / 65, abs=1)


def test_slots_are_10_ms_long() -> None:
    bench = Bench()
    bench.say("port 0;port_plimit 1;pwmparams 0.6 0;set 0.2")
    slots = bench.steps(30)
    assert slots.count(153) == 10
    assert all(slots[tick] == slots[tick + 3] for tick in range(27))


def test_drives_at_the_threshold_pass() -> None:
    bench = Bench()
    bench.say("port 0;port_plimit 1;pwmparams 0.5 0;set 0.5")
    assert bench.steps(4) == 4 * [127]


def test_a_limit_below_the_threshold_scales_the_slots() -> None:
    bench = Bench()
    bench.say("port 0;port_plimit 0.3;pwmparams 0.6 0;set 0.3")
    assert set(bench.steps(10)) == {0, 76}


def test_coast_switches_the_driver_off_and_a_setpoint_switches_it_on() -> None:
    bench = Bench()
    bench.say("port 0;port_plimit 1;set 1;coast")
    assert bench.duties(1) == [None]
    for again in ("set 0.5", "on", "off", "pwm", SPEED_PID, "set ramp 0 1 1 0"):
        bench.say(f"pwm;set 0;coast;{again}", 0.06)
        assert bench.board.duty(0) is not None


def test_time_of_a_shape_runs_on_while_coasting() -> None:
    bench = Bench()
    bench.board.receive(b"port 0;pwm;set pulse 1 0 0.2 0;coast\r")
    assert bench.until("P0: pulse done", 1.0) == pytest.approx(0.205, abs=0.01)
    assert bench.board.duty(0) is None


def test_both_wheels_of_one_line_change_in_the_same_tick() -> None:
    bench = Bench(motors=2)
    bench.board.receive(b"plimit 1;port 0;pwm;set .5;port 1;pwm;set -.5\r")
    while bench.board.duty(0) == 0:
        assert bench.board.duty(1) == 0
        bench.board.advance(0.001)
    assert (bench.board.duty(0), bench.board.duty(1)) == (127 / 255, -128 / 255)


def test_off_under_a_position_controller_drives_back_to_zero() -> None:
    bench = Bench()
    shaft = bench.plants.plant(0)
    bench.say(f"port 0;{COMBINED};port_plimit 1;pid 0 0 1 s4 0.0027777778 0 5 0 .1 3 0.01;set 1", 2)
    assert shaft.angle == pytest.approx(360, abs=6)
    bench.say("off", 2)
    assert shaft.angle == pytest.approx(0, abs=6)


def test_a_bare_pwm_drives_with_the_setpoint_of_the_controller() -> None:
    bench = Bench()
    bench.say(f"port 0;{COMBINED};port_plimit 1;{SPEED_PID};set 20", 0.3)
    assert bench.duties(1)[0] != 1
    bench.say("pwm")
    assert bench.duties(1) == [1.0]
    bench.say("pwm;set 0")
    assert bench.duties(1) == [0.0]


def test_a_controller_without_a_dead_zone_is_an_error_and_full_drive() -> None:
    bench = Bench()
    bench.say(f"port 0;{COMBINED};port_plimit 1;{SPEED_PID};set 20", 0.3)
    assert bench.say("select;pid 0 0 0 s1 1 0 0.003 0.01 0 100").endswith(b"Error\r\n")
    assert bench.duties(1) == [1.0]


def test_a_bad_shape_leaves_the_setpoint() -> None:
    bench = Bench()
    bench.say("port 0;port_plimit 1;set 0.5")
    assert bench.say("set pulse 1 0 1") == b"\r\nError\r\n"
    assert bench.say("set") == b"\r\nError\r\n"
    assert bench.steps(1) == [127]


def test_the_last_setpoint_lasts_for_ever() -> None:
    bench = Bench()
    bench.say("port 0;port_plimit 1;set 1")
    bench.board.silent = True
    bench.board.advance(20.0)
    assert bench.board.duty(0) == 1.0


def test_an_empty_port_drives_nothing_and_forgets_its_limit_within_100_ms() -> None:
    bench = Bench(motors=0)
    bench.say("port 0;port_plimit 1;set 1", 0.02)
    assert bench.steps(12) == 12 * [0]
    bench.say("debug 0")
    assert bench.board.duty(0) == 0.0


def test_the_limit_is_a_tenth_again_after_a_disconnection() -> None:
    bench = Bench()
    bench.say("port 0;port_plimit 1;set 1")
    bench.board.unplug(0)
    bench.board.advance(0.7)
    bench.board.plug(0, bench.motors[0])
    bench.until("established", 4.0)
    bench.say("port 0;set 1")
    assert bench.steps(1) == [25]
