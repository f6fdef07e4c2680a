"""Rules of the command line: what ends it, what it keeps, what a word and a port mean."""

from __future__ import annotations

import pytest
from hat_boards import Bench
from hypothesis import given
from hypothesis import strategies as st

from sim.hat.commands import NAMES

ORDER = [
    "help",
    "?",
    "clear_faults",
    "port",
    "list",
    "ledmode",
    "pwm",
    "coast",
    "pid",
    "pid_diff",
    "set",
    "off",
    "on",
    "vin",
    "pwmparams",
    "plimit",
    "port_plimit",
    "select",
    "selrate",
    "combi",
    "echo",
    "debug",
    "version",
    "signature",
]
ARGUMENTS = {
    "port": "0",
    "ledmode": "1",
    "pid": "0 0 0 s1 1 0 0 0 0 0 0",
    "pid_diff": "0 0 0 s1 1 0 0 0 0 0 0",
    "set": "0",
    "pwmparams": "0 0",
    "plimit": "1",
    "port_plimit": "1",
    "selrate": "10",
    "combi": "0",
    "echo": "0",
    "debug": "0",
}
SPEAKING = {"help", "?", "list", "vin", "version", "signature"}


@pytest.fixture(scope="module")
def bench() -> Bench:
    """One board for many lines; each test names its port."""
    return Bench(motors=0)


def test_an_empty_line_is_answered_by_a_line_end(bench: Bench) -> None:
    assert bench.say("") == b"\r\n"


@pytest.mark.parametrize("name", sorted(set(ORDER) - SPEAKING))
def test_a_command_without_output_prints_the_line_end_only(bench: Bench, name: str) -> None:
    assert bench.say(f"port 0;{name} {ARGUMENTS.get(name, '')}") == b"\r\n"


@pytest.mark.parametrize("name", sorted(set(ARGUMENTS) - {"set", "combi"}))
def test_a_missing_argument_is_an_error(bench: Bench, name: str) -> None:
    assert bench.say(name) == b"\r\nError\r\n"


@pytest.mark.parametrize(
    "name", ["bias", "portplimit", "float", "preset", "brake", "reset", "bootloader", "VIN", "vinn"]
)
def test_what_is_no_command_is_an_error(bench: Bench, name: str) -> None:
    assert bench.say(name) == b"\r\nError\r\n"


def test_words_are_looked_up_in_the_firmwares_order() -> None:
    assert list(NAMES) == ORDER


@pytest.mark.parametrize(
    ("short", "long"), [("v", "vin"), ("ve", "version"), ("l", "list"), ("si", "signature")]
)
def test_a_shortened_word_is_the_first_command_that_it_begins(
    bench: Bench, short: str, long: str
) -> None:
    assert bench.say(short) == bench.say(long) != b"\r\nError\r\n"


def test_c_clears_faults_and_s_sets_and_o_is_off() -> None:
    bench = Bench()
    assert bench.say("port 0;port_plimit 1;c;s 1") == b"\r\n"
    assert bench.steps(1) == [255]
    bench.say("o")
    assert bench.steps(1) == [0]


@given(st.text(st.sampled_from(" ;"), max_size=5), st.text(st.sampled_from(" ;"), min_size=1))
def test_blanks_and_semicolons_separate_and_may_be_many(before: str, between: str) -> None:
    bench = Bench(motors=0)
    assert bench.say(f"{before}vin{between}vin{before}", 0.1) == b"\r\n8.00 V\r\n8.00 V\r\n"


def test_a_tabulator_does_not_separate(bench: Bench) -> None:
    assert bench.say("port\t0") == b"\r\nError\r\n"
    assert bench.say("vin\tvin") == b"\r\nError\r\n"


def test_arguments_left_over_are_the_next_command(bench: Bench) -> None:
    assert bench.say("pwm 5") == b"\r\nError\r\n"
    assert bench.say("vin vin") == b"\r\n8.00 V\r\n8.00 V\r\n"
    assert bench.say("port 1vin") == b"\r\n8.00 V\r\n"


def test_an_error_keeps_what_came_before_it() -> None:
    bench = Bench()
    assert bench.say("port 0;port_plimit 1;set 1;bogus;set 0") == b"\r\nError\r\n"
    assert bench.steps(1) == [255]


def test_a_number_with_an_exponent_has_set_what_stands_before_it() -> None:
    bench = Bench()
    assert bench.say("port 0;port_plimit 1;set 1e-5") == b"\r\nError\r\n"
    assert bench.steps(1) == [255]


def test_the_port_stays_until_another_is_named(bench: Bench) -> None:
    bench.say("echo 1;port 2")
    assert bench.say("")[-3:] == b"P2>"
    assert bench.say("port 0;echo 0") == b"port 0;echo 0\r\n"


@pytest.mark.parametrize(("asked", "got"), [("9", 3), ("4", 3), ("4294967297", 1)])
def test_a_port_beyond_the_last_is_the_last(asked: str, got: int) -> None:
    bench = Bench(motors=0)
    assert bench.say(f"port {asked};echo 1") == f"\r\nP{got}>".encode()


def test_a_port_has_no_sign(bench: Bench) -> None:
    assert bench.say("port -1") == b"\r\nError\r\n"
    assert bench.say("port +1") == b"\r\nError\r\n"


def test_a_line_is_cut_at_256_characters(bench: Bench) -> None:
    blanks = " " * 253
    assert bench.say(f"{blanks}vin", 0.1) == b"\r\n8.00 V\r\n"
    assert bench.say(f" {blanks}vin", 0.1) == b"\r\n8.00 V\r\n", "still vi, which is vin"
    assert bench.say(f"   {blanks}vin", 0.1) == b"\r\n"
    assert bench.say("vin") == b"\r\n8.00 V\r\n", "and the next line is whole"


def test_only_the_first_character_makes_a_comment(bench: Bench) -> None:
    assert bench.say("#vin") == b"\r\n"
    assert bench.say(" #vin") == b"\r\nError\r\n"
    assert bench.say("vin;#") == b"\r\n8.00 V\r\nError\r\n"


def test_a_nul_ends_the_line_early(bench: Bench) -> None:
    assert bench.say(b"vin\0bogus") == b"\r\n8.00 V\r\n"
    assert bench.say(b"\0bogus") == b"\r\n"


def test_delete_works_like_backspace_and_stops_at_the_start(bench: Bench) -> None:
    assert bench.say(b"\x7f\x08vix\x7fn") == b"\r\n8.00 V\r\n"
    bench.say("echo 1")
    assert bench.say(b"\x7fx\x7fecho 0") == b"x\b \becho 0\r\n"


@given(st.binary(max_size=300).filter(lambda data: b"\r" not in data))
def test_no_line_disturbs_the_next_one(data: bytes) -> None:
    bench = Bench(motors=0)
    bench.say(data, 0.3)
    bench.say("echo 0;select;debug 0", 0.3)
    assert bench.say("port 0;vin").endswith(b"\r\n8.00 V\r\n")


def test_bytes_that_are_no_characters_are_echoed_as_they_came(bench: Bench) -> None:
    bench.say("port 0;echo 1")
    assert bench.say(b"\xb5\xff\x01") == b"\xb5\xff\x01\r\nError\r\nP0>"
    bench.say("echo 0")


def test_help_names_the_commands_in_one_line(bench: Bench) -> None:
    assert bench.say("help") == bench.say("?") == f"\r\nCommands: {' '.join(NAMES)}\r\n".encode()


def test_version_and_signature_are_one_line_each(bench: Bench) -> None:
    version = b"\r\nFirmware version: 1737564117 2025-01-22T16:41:57+00:00\r\n"
    assert bench.say("version") == version
    start, _, digits = bench.say("signature").rstrip().partition(b": ")
    assert start == b"\r\nFirmware signature"
    assert len(bytes.fromhex(digits.decode())) == 64
    assert digits.upper() == digits
