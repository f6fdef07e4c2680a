"""Raspberry Pi's own library works on the emulated Build HAT as it is.

The long form, with 50 starts and another firmware, is ``brickpose bench official_library``.
"""

from __future__ import annotations

import time
from concurrent.futures import ThreadPoolExecutor

import pytest

from benchmarks.hat.emulated_hat import emulated_hat
from benchmarks.hat.official_library import VALID, checked, session, wrong
from benchmarks.hat.official_session import PARTS

pytestmark = pytest.mark.slow

BRAKING = "0.0000 0.0000 0.0000 0.0000"
HEARD_S = 10.0
"""How long the board may take for a line, however busy the machine is [s]."""

MOST_REPEATS = 3


def upload(folder):
    """A start on a board without firmware, and one after it."""
    with emulated_hat(folder, "--world", "free", "--bootloader") as hat:
        first = session(hat, "hat", "get")
        return first, session(hat, "hat", "get"), hat.ask("state")


@pytest.fixture(scope="module")
def uploading(tmp_path_factory):
    """Runs meanwhile: the library waits 11 s after an upload, come what may."""
    with ThreadPoolExecutor(1) as pool:
        yield pool.submit(upload, tmp_path_factory.mktemp("cold"))


@pytest.fixture(scope="module")
def hat(tmp_path_factory, uploading):
    with emulated_hat(tmp_path_factory.mktemp("warm"), "--world", "free") as running:
        yield running


@pytest.fixture(scope="module")
def found(hat):
    """What the library does in each part.

    It times its moves by the computer's clock, which a busy machine does not keep to: a part that
    went wrong is done again. What is wrong with the emulator is wrong each time.
    """
    told = session(hat, *PARTS)
    for _ in range(MOST_REPEATS):
        again = [part for part in PARTS if part in told and wrong({part: told[part]})]
        if again:
            told |= session(hat, *again)
    return told


def test_every_call_does_what_it_should(found) -> None:
    assert checked(found) == len(VALID)
    assert wrong(found) == []


def test_it_sees_what_is_plugged_in(found) -> None:
    assert {port: one["typeid"] for port, one in found["hat"]["devices"].items()} == {
        "A": 0x30,
        "B": 0x30,
        "C": -1,
        "D": -1,
    }
    assert found["hat"]["devices"]["A"]["name"] == "Motor"


def test_its_end_stops_the_motors(found, hat) -> None:
    # The last line is on the wire for 20 ms after the library has let go of it, and its first
    # word, "pwm", takes the position that a motor last went to for a drive until "coast" comes.
    deadline = time.monotonic() + HEARD_S
    while hat.ask("duty") != BRAKING and time.monotonic() < deadline:
        pass
    assert hat.ask("duty") == BRAKING


def test_a_board_that_was_used_before_is_ready_again(found, hat) -> None:
    again = session(hat, "get")
    assert wrong(again) == []
    assert again["get"]["position"] != 0


def test_it_uploads_the_firmware_and_finds_it_running_the_next_time(uploading) -> None:
    first, second, state = uploading.result()
    assert first["start"] > 11
    assert second["start"] < 5
    assert wrong(first) == wrong(second) == []
    assert "; firmware; A 30" in state
