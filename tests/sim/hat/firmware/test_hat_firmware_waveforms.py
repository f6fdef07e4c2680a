"""Setpoints that change with time."""

from __future__ import annotations

import numpy as np
import pytest
from hat_boards import Bench
from hypothesis import given
from hypothesis import strategies as st

from sim.hat.firmware.drive import Waveform, WaveShape


def _next(wave: Waveform) -> float:
    wave.advance()
    return wave.setpoint


def test_a_ramp_is_linear_and_then_stays() -> None:
    wave = Waveform()
    wave.begin(WaveShape.RAMP, 2.0, 4.0, 1.0)
    levels = [_next(wave) for _ in range(99)]
    np.testing.assert_allclose(levels, 2 + 0.02 * np.arange(1, 100), atol=1e-5)
    ended = [wave.advance() for _ in range(3)]
    assert ended.count(WaveShape.RAMP) == 1
    assert _next(wave) == 4.0


@given(st.floats(0.02, 60))
def test_a_pulse_ends_within_two_ticks_and_rounding_of_its_length(length: float) -> None:
    wave = Waveform()
    wave.begin(WaveShape.PULSE, 1.0, -1.0, length)
    ticks = 1
    while wave.advance() is None:
        assert wave.setpoint == 1.0
        ticks += 1
    assert length - 1e-3 * length <= ticks * 0.01 <= length + 0.02 + 1e-3 * length
    assert wave.setpoint == -1.0
    assert wave.advance() is None


@pytest.mark.parametrize("period", [0.0, -5.0, 0.001])
def test_the_shortest_length_is_20_ms(period: float) -> None:
    wave = Waveform()
    wave.begin(WaveShape.PULSE, 1.0, 0.0, period)
    assert [wave.advance() for _ in range(3)] == [None, WaveShape.PULSE, None]


def test_a_ramp_without_a_duration_is_done_after_15_ms() -> None:
    bench = Bench()
    bench.board.receive(b"port 0;pwm;set ramp 0 1 0 0\r")
    bench.until("\r\n", 0.05)
    assert bench.until("P0: ramp done\r\n", 0.1) == pytest.approx(0.015, abs=0.008)


def test_a_renewed_pulse_starts_again_and_the_old_one_is_never_done() -> None:
    bench = Bench()
    bench.say("port 0;port_plimit 1;pwm", 0.05)
    heard = b""
    for _ in range(10):
        heard += bench.say("port 0;set pulse 0.5 0 0.2 0", 0.1)
        assert bench.board.duty(0) == 127 / 255
    assert b"done" not in heard
    assert bench.until("P0: pulse done", 1.0) == pytest.approx(0.11, abs=0.02)
    assert bench.steps(1) == [0]


def test_a_pulse_that_a_constant_replaces_is_never_done() -> None:
    bench = Bench()
    bench.say("port 0;pwm;set pulse 0.5 0 0.2 0")
    assert bench.say("set 0", 1.0) == b"\r\n"


def test_an_empty_port_tells_of_no_end_once_its_settings_are_gone() -> None:
    assert Bench(motors=0).say("port 2;pwm;set pulse 1 0 0.5 0", 1.5) == b"\r\n"


def test_a_lost_motor_tells_of_no_end() -> None:
    bench = Bench()
    bench.say("port 0;pwm;set pulse 1 0 1 0", 0.02)
    bench.board.unplug(0)
    lines = bench.lines(2.0)
    assert lines == ["P0: timeout during data phase: disconnecting", "P0: disconnected"]


def test_an_end_within_the_time_out_is_told() -> None:
    bench = Bench()
    bench.say("port 0;pwm;set pulse 1 0 0.3 0", 0.02)
    bench.board.unplug(0)
    assert bench.lines(2.0)[0] == "P0: pulse done"


@pytest.mark.parametrize("shape", ["square 0 1 1 0", "sine 0 1 1 0", "triangle 0 1 1 0"])
def test_other_shapes_are_not_emulated(shape: str) -> None:
    assert Bench().say(f"port 0;set {shape}") == b"\r\nError\r\n"
