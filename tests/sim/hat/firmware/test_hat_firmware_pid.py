"""Closed loops: the controller's arithmetic and its habits."""

from __future__ import annotations

from struct import pack

import numpy as np
import pytest
from hat_boards import COMBINED, Bench
from hypothesis import given
from hypothesis import strategies as st

from sim.hat.firmware.drive import Controller, ControlMode
from sim.hat.firmware.variables import MODES, ModeData, Variable

SPEED_PID = "pid 0 0 0 s1 1 0 0.003 0.01 0 100 0.01"
GAINS = st.floats(-10, 10, width=32)
F = np.float32


def received(*modes: bytes) -> list[list[ModeData]]:
    """Four ports that have received the same, from mode 0 on."""
    data = [ModeData() for _ in range(MODES)]
    for place, payload in zip(data, modes, strict=False):
        place.store(payload)
    return 4 * [data]


@given(
    GAINS,
    GAINS,
    GAINS,
    st.floats(0, 5, width=32),
    st.floats(0, 3, width=32),
    st.lists(st.tuples(st.integers(-(2**15), 2**15 - 1), GAINS), min_size=1, max_size=20),
)
def test_the_terms_are_those_of_the_formula_in_single_precision(
    p: float, i: float, d: float, windup: float, dead_zone: float, run: list[tuple[int, float]]
) -> None:
    controller = Controller()
    controller.control, controller.variable = ControlMode.VALUE, Variable(0, 0, 0, "s2", 0.125, 0.0)
    controller.proportional_gain, controller.integral_gain = p, i
    controller.derivative_gain, controller.windup, controller.dead_zone = d, windup, dead_zone
    integral = last = F(0)
    for value, setpoint in run:
        error = F(value) * F(0.125) - F(setpoint)
        error = F(0) if abs(error) < F(dead_zone) else error
        slope, last = F(float(error - last) / 0.01), error
        integral = F(float(integral) + float(error) * 0.01)
        integral = min(max(integral, F(-windup)), F(windup))
        expected = -((error * F(p) + integral * F(i)) + slope * F(d))
        assert controller.drive(received(pack("<h", value)), setpoint) == float(expected)


def test_without_data_the_last_drive_stays() -> None:
    bench = Bench()
    bench.say("port 0;port_plimit 1;pwm;set 0.5")
    bench.say("pid 0 7 0 s1 1 0 1 0 0 0 0;set 0")
    assert bench.steps(5) == 5 * [127]


def test_the_integral_outlives_every_command_until_its_windup_is_none() -> None:
    bench = Bench()
    bench.plants.plant(0).stalled = True
    bench.say(f"port 0;{COMBINED};selrate 0;select;port_plimit 1;{SPEED_PID};set 20", 3.0)
    for innocent in ("set 0", "coast", "pwm;set 0", SPEED_PID):
        bench.say(innocent)
    bench.say(f"{SPEED_PID};set 0", 0.03)
    assert bench.board.duty(0) == pytest.approx(0.6, abs=0.02), "3 s times 20, by 0.01"
    bench.say("pid 0 0 0 s1 1 0 0.003 0.01 0 0 0.01;set 0", 0.03)
    bench.say(SPEED_PID)
    assert bench.duties(1) == [0.0]


def test_a_blocked_run_bursts_in_the_next_slow_one() -> None:
    bench = Bench()
    shaft = bench.plants.plant(0)
    loop = "pid 0 0 0 s1 1 0 0.003 0.01 0 100 0.01"
    bench.say(f"port 0;{COMBINED};port_plimit 0.1;{loop};set 60", 2.0)
    bench.say(f"port_plimit 1;{loop};set 10", 0.3)
    assert shaft.speed > 200


def test_a_selection_of_another_mode_freezes_what_the_controller_sees() -> None:
    bench = Bench()
    bench.say(f"port 0;{COMBINED};port_plimit 1;{SPEED_PID};set 20", 1.0)
    bench.say("select 4;selrate 0;port_plimit 0", 0.1)
    bench.say("port_plimit 1", 0.02)
    assert bench.plants.plant(0).speed < 50, "it was about 200"
    begin = bench.board.duty(0)
    bench.board.advance(0.5)
    assert bench.board.duty(0) == pytest.approx(begin, abs=0.05), "it still sees the old speed"


@given(st.lists(st.integers(-400, 400), min_size=1, max_size=30))
def test_a_variable_on_a_circle_is_counted_on_over_its_ends(steps: list[int]) -> None:
    variable = Variable(0, 0, 0, "s2", 1.0, 1000.0)
    at, value = 0, 0.0
    assert variable.read(received(pack("<h", 0)), False, 0.0) == 0.0
    for step in steps:
        at += step
        wrapped = (at + 500) % 1000 - 500
        read = variable.read(received(pack("<h", wrapped)), False, value)
        assert read is not None
        value = read
    assert value == at


def test_a_rate_is_the_difference_of_10_ms_times_100() -> None:
    variable = Variable(0, 0, 0, "s2", 0.5, 0.0)
    assert variable.read(received(pack("<h", 7)), True, 0.0) == 0.0
    assert variable.read(received(pack("<h", 9)), True, 0.0) == 100.0
    on_circle = Variable(0, 0, 0, "s2", 1.0, 360.0)
    on_circle.read(received(pack("<h", 179)), True, 0.0)
    assert on_circle.read(received(pack("<h", -179)), True, 0.0) == 200.0


def test_pid_diff_holds_a_speed_of_the_absolute_position() -> None:
    bench = Bench()
    bench.say(
        f"port 0;{COMBINED};port_plimit 1;pid_diff 0 0 5 s2 0.0027777778 1 0 2.5 0 .4 0.01;set 1",
        1.0,
    )
    start = bench.plants.plant(0).angle
    bench.board.advance(2.0)
    assert bench.plants.plant(0).angle - start == pytest.approx(720, rel=0.03)


def test_a_controller_of_one_motor_can_watch_another() -> None:
    bench = Bench(motors=2)
    bench.plants.plant(1).angle = -45.0
    bench.say(f"port 1;{COMBINED};select")
    bench.say("port 0;port_plimit 1;pid 1 0 5 s2 0.01 0 1 0 0 1 0;set 0")
    assert bench.steps(1) == [114]


def test_a_ramp_under_a_position_controller_holds_its_end() -> None:
    bench = Bench()
    shaft = bench.plants.plant(0)
    bench.say(f"port 0;{COMBINED};port_plimit 0.7;pwmparams 0.65 0.01")
    bench.say("port 0;pid 0 0 1 s4 0.0027777778 0 5 0 .1 3 0.01;set ramp 0.0 1.0 1.0 0", 2.0)
    assert shaft.angle == pytest.approx(360, abs=5)
    shaft.load = 0.03
    bench.board.advance(1.0)
    assert shaft.angle == pytest.approx(360, abs=40)
