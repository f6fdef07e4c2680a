"""Reports: when they come, how often, and how their numbers are written."""

from __future__ import annotations

import pytest
from hat_boards import COMBINED, Bench

from sim.hat.firmware.reports import mode_line
from sim.hat.firmware.variables import ModeData
from sim.hat.lego_motor import Mode, ValueType


def test_zero_is_a_blank_and_a_zero() -> None:
    bench = Bench()
    bench.say(f"port 0;{COMBINED}")
    assert bench.lines(0.03)[-1] == "P0C0:  0  0  0"


def test_numbers_carry_their_sign() -> None:
    bench = Bench()
    bench.say(f"port 0;{COMBINED};port_plimit 1;set -1", 0.3)
    assert bench.lines(0.03)[-1].startswith("P0C0: -")
    bench.say("set 1", 1.0)
    assert bench.lines(0.03)[-1].startswith("P0C0: +")


def test_a_plain_mode_is_reported_by_its_number_every_100_ms() -> None:
    bench = Bench()
    assert bench.say("port 0;select 4", 1.03) == b"\r\n" + 10 * b"P0M4:  0  0\r\n"


def test_statistics_have_as_many_numbers_as_the_mode_says() -> None:
    bench = Bench()
    assert bench.say("port 0;select 5;selrate 0", 0.03).startswith(b"\r\nP0M5:" + 14 * b"  0")


def test_nothing_is_reported_of_a_mode_that_the_device_does_not_have() -> None:
    assert Bench().say("port 0;select 9;selrate 0", 0.2) == b"\r\n"


@pytest.mark.parametrize(("period", "count"), [(10, 100), (25, 40), (100, 10), (1, 90)])
def test_timed_reports_come_at_the_period_asked_for(period: int, count: int) -> None:
    bench = Bench()
    bench.say(f"port 0;select 4;selrate {period}", 0.2)
    lines = bench.lines(1.0)
    if period == 1:
        assert len(lines) > 500, "as many as the wire takes"
    else:
        assert len(lines) == pytest.approx(count, abs=1)


def test_select_brings_the_period_back_to_100_ms() -> None:
    bench = Bench()
    bench.say(f"port 0;{COMBINED};select 0", 0.2)
    assert len(bench.lines(1.0)) == pytest.approx(10, abs=1)


def test_a_period_of_0_reports_each_message() -> None:
    bench = Bench()
    bench.say("port 0;select 4;selrate 0")
    assert len(bench.lines(1.0)) == pytest.approx(100, abs=1)


def test_a_bare_select_ends_reports() -> None:
    bench = Bench()
    bench.say(f"port 0;{COMBINED};port_plimit 1")
    bench.say("select")
    assert bench.lines(0.3) == []


def test_a_combination_forgets_the_selection() -> None:
    bench = Bench()
    bench.say(f"port 0;{COMBINED}")
    bench.say("combi 0 1 0 2 0 3 0", 0.05)
    assert bench.lines(0.3) == []
    bench.say("select 0;selrate 0")
    assert bench.lines(0.1) != []


def test_a_combination_is_written_in_its_own_order() -> None:
    bench = Bench()
    bench.plants.plant(0).angle = 400.0
    bench.say("port 0;combi 3 3 0 2 0;select 3;selrate 0")
    assert bench.lines(0.02)[-1] == "P0C3: +40 +400"


def test_a_removed_combination_is_a_plain_mode_again() -> None:
    bench = Bench()
    bench.say(f"port 0;{COMBINED}")
    bench.say("combi 0;select 0;selrate 0")
    assert bench.lines(0.03)[-1] == "P0M0:  0"


def test_a_combination_that_the_motor_refuses_is_read_out_of_what_it_sends_instead() -> None:
    bench = Bench()
    bench.say("port 0;combi 1 1 0 4 0;select 1;selrate 0")
    assert bench.lines(0.03)[-1] == "P0C1:  0  0"


def test_nothing_is_reported_on_an_empty_port() -> None:
    assert Bench().say(f"port 2;{COMBINED}", 0.5) == b"\r\n"


def test_a_short_message_ends_the_line_early() -> None:
    data = ModeData()
    data.store(b"\1\0\xf6\xff")
    mode = Mode("X", "", ValueType.INT16, 3, 4, 0, 1, 1, 1)
    assert mode_line(1, 2, mode, data) == "P1M2: +1 -10\r\n"
    assert mode_line(1, 2, mode, ModeData()) == ""


@pytest.mark.parametrize(("waiting", "missed"), [(4000, 0), (6000, 16.5), (8000, 33.9)])
def test_reports_wait_while_the_ring_is_half_full(waiting: int, missed: float) -> None:
    """Until less than 4096 of the waiting bytes are left."""
    bench = Bench()
    bench.say("port 0;select 4;selrate 10", 0.2)
    bench.board.print_text("x" * waiting)
    assert bench.board.advance(1.0).count(b"P0M4") == pytest.approx(100 - missed, abs=1.5)


def test_what_does_not_fit_into_the_ring_is_lost() -> None:
    bench = Bench(motors=0)
    bench.board.print_text("x" * 10_000)
    assert bench.board.advance(2.0) == b"x" * 8191
