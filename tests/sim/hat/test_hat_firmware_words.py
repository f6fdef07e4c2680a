"""Words: what the command language takes for a number, and what it makes of it."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from robot.errors import CommandError
from sim.hat.firmware.variables import single
from sim.hat.words import CommandWords

DIGITS = st.text(st.sampled_from("0123456789"), max_size=12)


def left(words: CommandWords) -> str:
    return words.word()


@given(st.sampled_from(["", "+", "-"]), DIGITS, st.booleans(), DIGITS)
def test_a_decimal_is_a_sign_digits_a_point_and_digits(
    sign: str, whole: str, point: bool, fraction: str
) -> None:
    text = sign + whole + ("." + fraction if point else "")
    words = CommandWords(text.encode() + b" rest")
    if not whole and not (point and fraction):
        with pytest.raises(CommandError):
            words.decimal()
        return
    assert words.decimal() == pytest.approx(float(text), rel=1e-6)
    assert left(words) == "rest"


@given(st.integers(-(2**20), 2**20), st.integers(0, 6))
def test_short_decimals_are_the_nearest_single_but_for_one_rounding(
    mantissa: int, places: int
) -> None:
    text = f"{mantissa / 10**places:.{places}f}"
    expected = np.float32(mantissa) / np.float32(10**places)
    assert CommandWords(text.encode()).decimal() == float(expected)


@pytest.mark.parametrize(("text", "value"), [(".5", 0.5), ("5.", 5.0), ("-.25", -0.25), ("007", 7)])
def test_digits_may_be_missing_on_one_side_of_the_point(text: str, value: float) -> None:
    assert CommandWords(text.encode()).decimal() == value


@pytest.mark.parametrize("text", ["", ".", "-", "+.", "e5", "inf", "nan", "--1", "- 1"])
def test_without_a_digit_there_is_no_decimal(text: str) -> None:
    words = CommandWords(text.encode())
    with pytest.raises(CommandError):
        words.decimal()


def test_a_decimal_ends_before_an_exponent() -> None:
    words = CommandWords(b"1e-05")
    assert words.decimal() == 1.0
    assert left(words) == "e-05"


@given(st.integers(0, 2**40))
def test_integers_wrap_as_32_bits_do(value: int) -> None:
    text = str(value).encode()
    assert CommandWords(text).unsigned() == value % 2**32
    assert CommandWords(b"-" + text).integer() == int(np.int64(-value).astype(np.int32))


def test_a_missing_integer_consumes_nothing() -> None:
    words = CommandWords(b"-x")
    assert words.integer_or_none() is None
    assert left(words) == "-x"


@pytest.mark.parametrize("text", ["s3", "x4", "f2", "s", "", "S4", "f1"])
def test_only_seven_formats_exist(text: str) -> None:
    with pytest.raises(CommandError, match="u1, s1, u2, s2, u4, s4, f4"):
        CommandWords(text.encode()).format()


@given(st.floats(allow_nan=False))
def test_singles_are_those_of_the_machine(value: float) -> None:
    with np.errstate(over="ignore"):
        assert single(value) == float(np.float32(value))
