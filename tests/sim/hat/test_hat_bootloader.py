"""The bootloader's words to the byte: greeting, echo, prompt, mistakes and all."""

from __future__ import annotations

import importlib.util
from pathlib import Path

import pytest
from bootloader_terminal import ETX, STX, Terminal, loaded
from hypothesis import given
from hypothesis import strategies as st

from sim.hat.bootloader import VERSION, Bootloader, checksum


@pytest.fixture
def terminal() -> Terminal:
    return Terminal()


@pytest.mark.parametrize(
    ("data", "value"),
    [(b"", 1), (b"\0", 2), (b"123456789", 8757), (bytes(range(256)), 3426738657)],
)
def test_checksum_has_the_reference_values(data: bytes, value: int) -> None:
    assert checksum(data) == value


def test_checksum_of_the_official_image() -> None:
    spec = importlib.util.find_spec("buildhat")
    assert spec is not None
    assert spec.origin is not None
    image = Path(spec.origin).parent.joinpath("data", "firmware.bin").read_bytes()
    assert (len(image), checksum(image)) == (51_456, 495305442)


@given(st.binary(max_size=50), st.integers(0, 7), st.data())
def test_checksum_tells_any_flipped_bit(data: bytes, bit: int, draw: st.DataObject) -> None:
    flipped = bytearray(data + b"\0")
    flipped[draw.draw(st.integers(0, len(data)))] ^= 1 << bit
    assert checksum(data + b"\0") != checksum(bytes(flipped))


def test_it_greets_with_a_prompt_that_ends_no_line() -> None:
    assert Terminal().greeting == "\r\nType help <RETURN> for help\r\nBHBL> "


def test_what_comes_within_10_ms_of_the_start_is_dropped() -> None:
    out: list[bytes] = []
    bootloader = Bootloader(out.append)
    bootloader.tick(0.005)
    bootloader.receive(ord("x"))
    bootloader.tick(0.005)
    bootloader.receive(ord("y"))
    for _ in range(3):
        bootloader.tick(0.01)
    bootloader.receive(ord("z"))
    assert b"".join(out).endswith(b"BHBL> z")


def test_it_is_deaf_after_its_start_for_no_more_than_its_input_ring_holds() -> None:
    out: list[bytes] = []
    bootloader = Bootloader(out.append)
    for _ in range(20_000):
        bootloader.receive(ord("x"))
    for _ in range(4095):
        bootloader.tick(0.01)
    bootloader.receive(ord("y"))
    for _ in range(2):
        bootloader.tick(0.01)
    bootloader.receive(ord("z"))
    assert b"".join(out).endswith(b"BHBL> z")


def test_version_is_echoed_answered_and_prompted(terminal: Terminal) -> None:
    assert terminal.send("version\r") == (
        f"version\r\nBuildHAT bootloader version {VERSION}\r\nBHBL> "
    )
    assert VERSION == "1631704133 2021-09-15T12:08:53+01:00"


def test_an_empty_line_is_a_new_prompt(terminal: Terminal) -> None:
    assert terminal.send("\r") == "\r\nBHBL> "


def test_clear_prints_only_a_new_prompt_and_forgets_the_image(terminal: Terminal) -> None:
    loaded(terminal)
    assert terminal.send("clear\r") == "clear\r\nBHBL> "
    assert terminal.send("verify\r").endswith("No image loaded\r\nError\r\nBHBL> ")


@pytest.mark.parametrize("word", ["list", "vin", "echo 0", "versions", "Version", "\n"])
def test_what_is_no_command_is_an_error(terminal: Terminal, word: str) -> None:
    assert terminal.send(word + "\r") == f"{word}\r\nError\r\nBHBL> "


def test_an_error_drops_the_rest_of_the_line(terminal: Terminal) -> None:
    answer = terminal.send("version;bogus;version\r")
    assert answer.count(VERSION) == 1
    assert answer.endswith("\r\nError\r\nBHBL> ")


def test_commands_may_share_a_line_and_be_shortened(terminal: Terminal) -> None:
    assert terminal.send("; vers ;vers\r").count(VERSION) == 2


@pytest.mark.parametrize("word", ["v", "ver"])
def test_a_short_word_means_the_first_command_it_fits(terminal: Terminal, word: str) -> None:
    assert terminal.send(word + "\r") == f"{word}\r\nNo image loaded\r\nError\r\nBHBL> "


@pytest.mark.parametrize("word", ["help", "?", "h"])
def test_help_names_every_command(terminal: Terminal, word: str) -> None:
    answer = terminal.send(word + "\r")
    assert answer.startswith(f"{word}\r\nBuildHAT bootloader version {VERSION}\r\n")
    for name in ("load", "signature", "clear", "verify", "reboot", "version", "help"):
        assert f"\r\n  {name}" in answer


@pytest.mark.parametrize("key", ["\x08", "\x7f"])
def test_a_deleted_byte_is_wiped_out_on_the_screen(terminal: Terminal, key: str) -> None:
    assert terminal.send(f"clex{key}ar\r") == "clex\b \bar\r\nBHBL> "
    assert terminal.send(key) == ""


def test_bytes_beyond_256_are_neither_kept_nor_echoed(terminal: Terminal) -> None:
    answer = terminal.send(" " * 249 + "version" + "bogus\r")
    assert answer == " " * 249 + f"version\r\nBuildHAT bootloader version {VERSION}\r\nBHBL> "


FRAGMENTS = st.sampled_from(
    [
        b"load 3 ",
        b"1\r",
        b"load 0 1\r",
        b"signature 64\r",
        STX,
        ETX,
        b"\r",
        b";",
        b"reboot\r",
        b"\x08",
    ]
)


@given(st.lists(FRAGMENTS | st.binary(max_size=70), max_size=12).map(b"".join))
def test_no_bytes_can_upset_it(data: bytes) -> None:
    terminal = Terminal()
    for end in (data, b"\r"):
        for byte in end:
            terminal.bootloader.receive(byte)
        terminal.wait(1.1)
    assert terminal.send("version\r").endswith(f"{VERSION}\r\nBHBL> ")
