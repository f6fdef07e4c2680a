"""What the emulated board does to the wire, and says out of turn, when it is told to."""

from __future__ import annotations

import re
from collections.abc import Iterator
from contextlib import closing

import pytest
from emulator_bench import Bench

from robot.hat.protocol.decoder import Decoder
from robot.hat.protocol.events import Event, Notice, SupplyVoltage


@pytest.fixture
def bench() -> Iterator[Bench]:
    with closing(Bench()) as made:
        yield made


def test_a_silent_board_neither_hears_nor_speaks(bench: Bench) -> None:
    assert bench.ask("silent on") == "ok"
    assert bench.say("port 0;pwm;set .1\rvin\r") == ""
    assert bench.ask("silent off") == "ok"
    assert bench.run(0.1) == ""
    assert bench.ask("duty").startswith("0.0000")


def test_noise_on_the_wire_changes_what_is_heard(bench: Bench) -> None:
    clean = bench.say("list\r", 0.5)
    assert bench.ask("garble 0.05") == "ok"
    assert bench.say("list\r", 0.5) != clean
    assert bench.ask("garble 2").startswith("error")


def test_noise_on_the_way_in_changes_what_the_board_does(bench: Bench) -> None:
    assert bench.ask("garble-in 1") == "ok"
    assert "V" not in bench.say("vin\r")
    assert bench.ask("garble-in 0") == "ok"
    bench.say("\r")
    assert bench.say("vin\r") == "\r\n8.00 V\r\n"
    assert bench.ask("garble-in 2").startswith("error")


def test_bytes_are_lost_on_the_way_in(bench: Bench) -> None:
    assert bench.ask("lose 1") == "ok"
    assert bench.say("vin\r") == ""
    assert bench.ask("lose 0") == "ok"
    assert bench.say("vin\r") == "\r\n8.00 V\r\n"


@pytest.mark.parametrize(
    ("text", "event"),
    [
        ("MQ overrun!", Notice("MQ overrun!")),
        ("<I²C bus timeout>", Notice("<I²C bus timeout>")),
        ("Attempting reset of I²C bus", Notice("Attempting reset of I²C bus")),
    ],
)
def test_the_board_says_out_of_turn_what_it_is_told_to(
    bench: Bench, text: str, event: Event
) -> None:
    assert bench.ask(f"say {text}") == "ok"
    heard = Decoder().feed(bench.say("vin\r").encode())
    assert event in heard
    assert SupplyVoltage(8.0) in heard
    assert bench.ask("say") == "error: valid is: say TEXT"


def test_an_error_of_the_inner_bus_ends_no_line(bench: Bench) -> None:
    bench.ask("say <generic I²C bus error>")
    bench.ask("say MQ overrun!")
    assert bench.run(0.1) == "<generic I²C bus error>MQ overrun!\r\n"


def test_a_late_pass_is_told(bench: Bench) -> None:
    assert bench.ask("late 30") == "ok"
    assert re.search(r"deltat=[0-9A-F]{8}", bench.run(0.2))
