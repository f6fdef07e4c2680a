"""A firmware's way into the emulated board: upload, time-outs, verification, start."""

from __future__ import annotations

import hashlib
from collections.abc import Iterable

import pytest
from bootloader_terminal import ETX, IMAGE, SIGNATURE, STX, Terminal, loaded

from sim.hat.bootloader import VERSION, checksum

LOAD = f"load {len(IMAGE)} {checksum(IMAGE)}\r"


@pytest.fixture
def terminal() -> Terminal:
    return Terminal()


def signed(terminal: Terminal) -> Terminal:
    terminal.send("signature 64\r")
    terminal.send(STX + SIGNATURE + ETX)
    return terminal


def hexadecimal(data: Iterable[int]) -> str:
    return " ".join(f"{byte:02X}" for byte in data)


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
