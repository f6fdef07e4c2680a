"""The bootloader's words to the byte: echo, prompt, upload, time-outs, mistakes and all."""

from __future__ import annotations

import hashlib
import importlib.util
from collections.abc import Iterable
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from sim.hat.bootloader import VERSION, Bootloader, checksum

IMAGE = bytes(range(256)) * 3 + b"\x02\x03\r"
SIGNATURE = bytes(range(100, 164))
LOAD = f"load {len(IMAGE)} {checksum(IMAGE)}\r"
STX, ETX = b"\x02", b"\x03"


class Terminal:
    """A bootloader and what has come out of it since it was last looked at."""

    def __init__(self) -> None:
        self.out = b""
        self.bootloader = Bootloader(self._put)
        self.greeting = self.take()
        self.wait(0.011)

    def _put(self, data: bytes) -> None:
        self.out += data

    def take(self) -> str:
        out, self.out = self.out, b""
        return out.decode("latin-1")

    def send(self, data: str | bytes) -> str:
        for byte in data.encode("latin-1") if isinstance(data, str) else data:
            self.bootloader.receive(byte)
        return self.take()

    def wait(self, seconds: float) -> str:
        for _ in range(round(seconds * 1000)):
            self.bootloader.tick(0.001)
        return self.take()


@pytest.fixture
def terminal() -> Terminal:
    return Terminal()


def loaded(terminal: Terminal, image: bytes = IMAGE) -> Terminal:
    terminal.send(f"load {len(image)} {checksum(image)}\r")
    terminal.send(STX + image + ETX)
    return terminal


def signed(terminal: Terminal) -> Terminal:
    terminal.send("signature 64\r")
    terminal.send(STX + SIGNATURE + ETX)
    return terminal


def hexadecimal(data: Iterable[int]) -> str:
    return " ".join(f"{byte:02X}" for byte in data)


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


def test_an_upload_in_the_order_that_every_driver_uses(terminal: Terminal) -> None:
    assert terminal.send("clear\r") == "clear\r\nBHBL> "
    assert terminal.send(LOAD) == LOAD + "\n"
    assert terminal.wait(0.1) == ""
    assert terminal.send(STX + IMAGE) == ""
    assert terminal.send(ETX) == "\r\nImage received\r\nChecksum OK\r\nBHBL> "
    assert terminal.send("\r") == "\r\nBHBL> "
    assert terminal.send("signature 64\r") == "signature 64\r\n"
    assert terminal.wait(0.1) == ""
    assert terminal.send(STX + SIGNATURE + ETX) == "\r\nSignature received\r\nBHBL> "
    assert terminal.send("\r") == "\r\nBHBL> "
    assert terminal.bootloader.image == IMAGE
    assert terminal.bootloader.signature == SIGNATURE
    assert terminal.send("reboot\r").endswith("Image verifed OK\r\nRebooting...\r\n")
    assert terminal.wait(0.099) == ""
    assert not terminal.bootloader.rebooted
    assert terminal.wait(0.002) == ""
    assert terminal.bootloader.rebooted


def test_verify_shows_what_it_looks_at(terminal: Terminal) -> None:
    answer = signed(loaded(terminal)).send("verify\r")
    lines = answer.split("\r\n")
    first, last = IMAGE[0], IMAGE[-2:]
    assert lines[1:5] == [
        "Verifying image...",
        f"Verifying image length={len(IMAGE)} {hexadecimal([first, first, *last])}",
        "SHA256:",
        " " + hexadecimal(hashlib.sha256(IMAGE).digest()),
    ]
    assert lines[5] == "Public key:"
    assert len(bytes.fromhex(lines[6])) == 64
    assert lines[7:] == ["Image verifed OK", "BHBL> "]


def test_an_image_without_a_signature_is_not_started(terminal: Terminal) -> None:
    answer = loaded(terminal).send("reboot\r")
    assert answer.endswith("\r\nImage verification failed\r\nError\r\nBHBL> ")
    terminal.wait(0.2)
    assert not terminal.bootloader.rebooted


def test_reboot_without_an_image_is_an_error(terminal: Terminal) -> None:
    answer = signed(terminal).send("reboot\r")
    assert answer == "reboot\r\nNo image loaded\r\nError\r\nBHBL> "


def test_what_is_typed_while_it_reboots_is_lost(terminal: Terminal) -> None:
    signed(loaded(terminal)).send("reboot\r")
    assert terminal.send("version\r") == ""


def test_a_wrong_checksum_is_told_and_the_image_forgotten(terminal: Terminal) -> None:
    loaded(terminal)
    terminal.send(f"load {len(IMAGE)} {checksum(IMAGE) ^ 1}\r")
    assert terminal.send(STX + IMAGE + ETX) == (
        "\r\nImage received\r\nChecksum failure\r\nError\r\nBHBL> "
    )
    assert terminal.bootloader.image == b""


def test_an_image_that_is_too_large_is_refused_at_once(terminal: Terminal) -> None:
    assert terminal.send("load 245761 1\r") == (
        "load 245761 1\r\n\r\nImage too large (maximum 245760 bytes)\r\nError\r\nBHBL> "
    )
    assert terminal.send("load 245760 1\r") == "load 245760 1\r\n"


@pytest.mark.parametrize("length", [0, 63, 65])
def test_a_signature_has_64_bytes(terminal: Terminal, length: int) -> None:
    assert terminal.send(f"signature {length}\r") == (
        f"signature {length}\r\n\r\n"
        "Incorrect signature length (should be64 bytes)\r\nError\r\nBHBL> "
    )


@pytest.mark.parametrize("line", ["load", "load 5", "load 5 x", "load -5 1", "signature"])
def test_a_missing_number_is_an_error(terminal: Terminal, line: str) -> None:
    assert terminal.send(line + "\r") == f"{line}\r\nError\r\nBHBL> "


def test_what_comes_before_stx_or_etx_is_skipped_without_an_echo(terminal: Terminal) -> None:
    terminal.send("load 3 " + str(checksum(b"abc")) + "\r")
    assert terminal.send("noise\r\x03") == ""
    assert terminal.send(STX + b"abc" + b"more") == ""
    assert terminal.send(ETX) == "\r\nImage received\r\nChecksum OK\r\nBHBL> "
    assert terminal.bootloader.image == b"abc"


@pytest.mark.parametrize("sent", [b"", STX, STX + IMAGE[:-1], STX + IMAGE])
def test_a_byte_that_stays_away_for_a_second_ends_the_upload(
    terminal: Terminal, sent: bytes
) -> None:
    terminal.send(LOAD)
    terminal.send(sent)
    assert terminal.wait(1.0) == ""
    assert terminal.wait(0.001) == "\r\nTimed out waiting for data\r\nError\r\nBHBL> "
    assert terminal.bootloader.image == b""
    assert terminal.send("clear\r") == "clear\r\nBHBL> "


def test_every_byte_of_the_image_starts_the_second_again(terminal: Terminal) -> None:
    terminal.send("load 3 " + str(checksum(b"abc")) + "\r")
    for byte in (STX, b"a", b"b", b"c"):
        assert terminal.wait(0.9) == ""
        assert terminal.send(byte) == ""
    assert terminal.wait(0.9) == ""
    assert terminal.send(ETX).startswith("\r\nImage received\r\n")


def test_noise_before_stx_does_not_start_the_second_again(terminal: Terminal) -> None:
    terminal.send(LOAD)
    terminal.wait(0.9)
    terminal.send("noise")
    assert terminal.wait(0.2) == "\r\nTimed out waiting for data\r\nError\r\nBHBL> "


def test_a_lost_byte_shows_as_a_time_out_and_the_next_load_succeeds(terminal: Terminal) -> None:
    terminal.send(LOAD)
    terminal.send(STX + IMAGE[:100] + IMAGE[101:] + ETX + b"\r")
    assert "Timed out" in terminal.wait(1.1)
    terminal.send(LOAD)
    assert "Checksum OK" in terminal.send(STX + IMAGE + ETX)


def test_the_rest_of_a_line_is_done_after_the_upload(terminal: Terminal) -> None:
    terminal.send("signature 64; version\r")
    answer = terminal.send(STX + SIGNATURE + ETX)
    assert answer == (f"\r\nSignature received\r\nBuildHAT bootloader version {VERSION}\r\nBHBL> ")


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
