"""The serial line lets 11 520 bytes a second through; a full output ring drops the rest."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from sim.hat.transmitter import RING, Receiver, Transmitter

BYTE = 1 / 11_520

WIRES = pytest.mark.parametrize("wire", [Transmitter, Receiver])


@WIRES
def test_a_byte_takes_86_8_microseconds(wire: type[Transmitter | Receiver]) -> None:
    line = wire()
    line.put(b"ab")
    assert line.advance(0.99 * BYTE) == b""
    assert line.advance(0.02 * BYTE) == b"a"
    assert line.advance(0.98 * BYTE) == b""
    assert line.advance(0.02 * BYTE) == b"b"


@WIRES
def test_milliseconds_add_up_to_the_full_rate(wire: type[Transmitter | Receiver]) -> None:
    line = wire()
    line.put(bytes(RING - 1))
    assert sum(len(line.advance(0.001)) for _ in range(500)) == 5760


@WIRES
def test_an_idle_line_saves_nothing_up(wire: type[Transmitter | Receiver]) -> None:
    line = wire()
    assert line.advance(1.0) == b""
    line.put(b"abc")
    assert line.advance(BYTE) == b"a"
    assert line.advance(1.0) == b"bc"
    line.put(b"d")
    assert line.advance(0.9 * BYTE) == b""


@given(st.lists(st.tuples(st.binary(max_size=60), st.floats(0, 0.01)), max_size=40))
def test_bytes_come_out_in_order_and_none_too_early(parts: list[tuple[bytes, float]]) -> None:
    line = Transmitter()
    sent, got, time = b"", b"", 0.0
    for data, seconds in parts:
        line.put(data)
        sent += data
        got += line.advance(seconds)
        time += seconds
        assert sent.startswith(got)
        assert len(got) <= time / BYTE + 1e-3
        assert len(line) == len(sent) - len(got)
    assert got + line.advance(1.0) == sent


def test_a_full_ring_drops_what_comes_last() -> None:
    line = Transmitter()
    line.put(b"a" * (RING - 3))
    line.put(b"bcdef")
    line.put(b"g")
    assert len(line) == RING - 1
    assert line.advance(10.0) == b"a" * (RING - 3) + b"bc"


def test_there_is_room_again_for_what_has_left() -> None:
    line = Transmitter()
    line.put(bytes(RING))
    line.advance(3 * BYTE)
    line.put(b"abcdef")
    assert line.advance(10.0)[-4:] == b"\0abc"


def test_reports_wait_while_half_of_the_ring_is_taken() -> None:
    line = Transmitter()
    line.put(bytes(RING // 2 - 1))
    before = line.at_least_half_full
    line.put(b"a")
    full = line.at_least_half_full
    line.advance(BYTE)
    assert (before, full, line.at_least_half_full) == (False, True, False)


def test_the_receiver_lets_the_host_write_as_much_as_it_likes() -> None:
    line = Receiver()
    line.put(bytes(100_000))
    assert len(line.advance(10.0)) == 100_000


@WIRES
def test_what_is_cleared_never_arrives(wire: type[Transmitter | Receiver]) -> None:
    line = wire()
    line.put(b"lost")
    line.advance(0.5 * BYTE)
    line.clear()
    line.put(b"a")
    assert line.advance(0.9 * BYTE) == b""
    assert line.advance(0.2 * BYTE) == b"a"
