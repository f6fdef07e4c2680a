"""Supply and fault lines."""

from __future__ import annotations

import re

import pytest
from hat_boards import Bench
from hypothesis import given
from hypothesis import strategies as st

from sim.hat.firmware.power import Power

DUMP = ["Motor power fault", " Port 4D 4E 4F", *(f"   {port}  BA 2C 8A" for port in range(4))]


@given(st.floats(0, 18))
def test_the_supply_is_told_to_a_step_of_the_converter(volts: float) -> None:
    bench = Bench(motors=0)
    bench.board.supply_v = volts
    found = re.fullmatch(rb"\r\n(\d+\.\d\d) V\r\n", bench.say("vin"))
    assert found is not None
    assert float(found[1]) == pytest.approx(volts, abs=0.0091)


def test_ten_volts_have_two_digits_before_the_point() -> None:
    bench = Bench(motors=0)
    bench.board.supply_v = 10.1
    assert bench.say("vin") == b"\r\n10.10 V\r\n"


def test_the_converter_ends_at_its_range() -> None:
    assert Power(supply_v=40.0).millivolts == 18805
    assert Power(supply_v=-1.0).millivolts == 0


def test_a_lower_supply_turns_the_motor_more_slowly() -> None:
    bench = Bench()
    bench.say("port 0;port_plimit 1;set 1", 1.0)
    fast = bench.plants.plant(0).speed
    bench.board.supply_v = 5.0
    bench.board.advance(1.0)
    assert bench.plants.plant(0).speed < 0.7 * fast


def test_a_motor_fault_is_told_after_10_ms_and_every_1011_ms() -> None:
    bench = Bench(motors=0)
    bench.board.power.motor_fault = True
    assert bench.until("Motor power fault", 0.1) == pytest.approx(0.013, abs=0.001)
    assert bench.until("Motor power fault", 2.0) == pytest.approx(1.011, abs=0.001)
    assert bench.lines(1.2)[-6:] == DUMP


def test_a_motor_fault_stops_no_motor() -> None:
    bench = Bench()
    bench.say("port 0;port_plimit 1;set 1")
    bench.board.power.motor_fault = True
    bench.board.advance(0.5)
    assert bench.board.duty(0) == 1.0


@pytest.mark.parametrize("line", ["motor_fault", "port_fault"])
def test_a_fault_of_10_ms_is_not_told(line: str) -> None:
    bench = Bench(motors=0)
    setattr(bench.board.power, line, True)
    bench.board.advance(0.010)
    setattr(bench.board.power, line, False)
    assert bench.lines(1.5) == []


def test_a_motor_fault_that_is_over_is_not_told_again() -> None:
    bench = Bench(motors=0)
    bench.board.power.motor_fault = True
    bench.until("8A\r\n   3  BA 2C 8A\r\n", 0.1)
    bench.board.power.motor_fault = False
    assert bench.say("clear_faults", 2.0) == b"\r\n"


def test_a_port_fault_is_told_once_a_second() -> None:
    bench = Bench(motors=0)
    bench.board.power.port_fault = True
    assert bench.until("Port power fault", 0.1) == pytest.approx(0.013, abs=0.001)
    assert bench.until("Port power fault", 2.0) == pytest.approx(1.0, abs=0.001)
    assert bench.lines(2.5) == 2 * ["Port power fault"]
