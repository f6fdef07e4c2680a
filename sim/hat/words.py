"""Words and numbers of a command line.

Only blanks and semicolons separate words. A number ends after its last digit, and the rest is the
next word: ``1e-5`` is the number 1 and then the word ``e-5``.
"""

from __future__ import annotations

import re

from robot.errors import CommandError
from sim.hat.firmware.variables import single

DIGITS = re.compile(r"[0-9]+")
DECIMAL = re.compile(r"([+-]?)([0-9]*)(\.?)([0-9]*)")
FORMATS = ("u1", "s1", "u2", "s2", "u4", "s4", "f4")
MANTISSA_LIMIT = 100_000_000
"""No more digits are collected when a number has reached this value."""


class CommandWords:
    """Reader of one command line, with its position."""

    __slots__ = ("_at", "_text")

    def __init__(self, line: bytes) -> None:
        """Begin at the start of a line without its CR; a NUL ends it, as in a C string."""
        self._text = line.partition(b"\0")[0].decode("latin-1")
        self._at = 0

    def next_command(self) -> bool:
        """Skip blanks and semicolons; return whether something is left."""
        self._skip(" ;")
        return self._at < len(self._text)

    def word(self) -> str:
        """Read a word, up to a blank, a semicolon or the end; consume that separator and blanks."""
        self._skip(" ")
        start = end = self._at
        while end < len(self._text) and self._text[end] not in " ;":
            end += 1
        self._at = min(end + 1, len(self._text))
        self._skip(" ")
        return self._text[start:end]

    def choice(self, names: tuple[str, ...]) -> str | None:
        """Read a word; return the first name that begins with it.

        Returns:
            The name; None if there is none, and then nothing is consumed.
        """
        start = self._at
        word = self.word()
        for name in names:
            if word and name.startswith(word):
                return name
        self._at = start
        return None

    def unsigned(self) -> int:
        """Read decimal digits, modulo 2^32.

        Raises:
            CommandError: there are none.
        """
        result = DIGITS.match(self._text, self._at)
        if result is None:
            raise CommandError(f"digits are expected, not {self._text[self._at :]!r}")
        self._at = result.end()
        self._skip(" ")
        return int(result.group()) % 2**32

    def integer(self) -> int:
        """Read decimal digits with an optional sign, as a 32-bit two's complement.

        Raises:
            CommandError: there are none; nothing is consumed then.
        """
        start = self._at
        sign = self._text[start : start + 1]
        if sign in ("+", "-"):
            self._at += 1
        try:
            value = self.unsigned()
        except CommandError:
            self._at = start
            raise
        value = -value if sign == "-" else value
        return (value + 2**31) % 2**32 - 2**31

    def integer_or_none(self) -> int | None:
        """Read an ``integer``; return None if there is none."""
        try:
            return self.integer()
        except CommandError:
            return None

    def decimal(self) -> float:
        """Read a single: optional sign, digits, optional point, digits; there is no exponent.

        Raises:
            CommandError: there is no digit; nothing is consumed then.
        """
        result = DECIMAL.match(self._text, self._at)
        assert result is not None
        sign, whole, _, fraction = result.groups()
        if not whole and not fraction:
            raise CommandError(f"a number is expected, not {self._text[self._at :]!r}")
        self._at = result.end()
        self._skip(" ")
        value = _decimal(whole, fraction)
        return -value if sign == "-" else value

    def format(self) -> str:
        """Read one of ``FORMATS``: type and size in bytes.

        Raises:
            CommandError: the text is not one of them.
        """
        name = self._text[self._at : self._at + 2]
        if name not in FORMATS:
            raise CommandError(f"a format is expected, one of {', '.join(FORMATS)}, not {name!r}")
        self._at += 2
        self._skip(" ")
        return name

    def _skip(self, characters: str) -> None:
        while self._at < len(self._text) and self._text[self._at] in characters:
            self._at += 1


def _decimal(whole: str, fraction: str) -> float:
    """Convert digits as the firmware does: nine at most count; others only keep the scale."""
    mantissa, grown, divisor = 0, 1.0, 1.0
    for digit in whole:
        if mantissa < MANTISSA_LIMIT:
            mantissa = mantissa * 10 + int(digit)
        else:
            grown = single(grown * 10)
    for digit in fraction:
        if mantissa < MANTISSA_LIMIT:
            mantissa = mantissa * 10 + int(digit)
            divisor = single(divisor * 10)
    return single(single(single(mantissa) * grown) / divisor)
