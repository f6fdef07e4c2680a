"""Transcripts: what a genuine board was seen to print, byte for byte."""

from __future__ import annotations

import pytest
from hat_boards import LISTED_BLOCK, Bench


def test_an_unknown_word_is_an_error() -> None:
    assert Bench().say("bogus") == b"\r\nError\r\n"


def test_a_line_feed_is_the_first_character_of_the_next_command() -> None:
    bench = Bench()
    bench.board.receive(b"vin\r\n")
    assert bench.board.advance(0.05) == b"\r\n8.00 V\r\n"
    assert bench.say("vin") == b"\r\nError\r\n"


def test_an_error_drops_the_rest_of_the_line() -> None:
    bench = Bench()
    bench.board.supply_v = 7.98
    assert bench.say("port 0; vin ;bogus; vin") == b"\r\n7.98 V\r\nError\r\n"


def test_echo_brings_a_prompt_and_repeats_what_is_typed() -> None:
    bench = Bench()
    assert bench.say("echo 1") == b"\r\nP0>"
    assert bench.say("p 1") == b"p 1\r\nP1>"
    assert bench.say("#note") == b"#note\r\n"


def test_a_backspace_takes_the_last_character_back() -> None:
    assert Bench().say("vix\x08n") == b"\r\n8.00 V\r\n"


def test_there_is_no_exponent() -> None:
    assert Bench().say("set 1e-5") == b"\r\nError\r\n"


def test_a_pulse_of_half_a_second_is_done_a_few_milliseconds_later() -> None:
    bench = Bench()
    bench.board.receive(b"port 0 ; pwm ; set pulse 0.5 0 0.5 0\r")
    after_cr = bench.until("\r\n", 0.1)
    took = bench.until("P0: pulse done\r\n", 1.0)
    assert after_cr == pytest.approx(0.004, abs=0.001)
    assert 0.498 <= took <= 0.513


def test_unplugging_freezes_the_data_for_half_a_second() -> None:
    bench = Bench()
    bench.say("port 0;combi 0 1 0 2 0 3 0;select 0;selrate 50;port_plimit 1;pwm;set 1", 0.4)
    bench.board.unplug(0)
    bench.until("\r\n", 0.06)
    lines = bench.lines(0.7)
    assert lines[-2:] == ["P0: timeout during data phase: disconnecting", "P0: disconnected"]
    frozen = set(lines[:-2])
    assert len(frozen) == 1
    assert len(lines[:-2]) in (9, 10)
    assert frozen.pop().startswith("P0C0: +")


def test_the_listing_has_the_whole_block_of_a_motor() -> None:
    empty = "".join(f"P{port}: no device detected\n" for port in (1, 2, 3))
    listed = "\n" + LISTED_BLOCK + empty
    assert Bench().say("list", 0.3).decode() == listed.replace("\n", "\r\n")
