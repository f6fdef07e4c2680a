"""Bytes that almost fit: kept files with a few changes, as strategies of hypothesis."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass

from hypothesis import strategies as st
from hypothesis.strategies import SearchStrategy

NUMBERS = (
    *(b"nan", b"inf", b"-inf", b"NaN", b"Infinity", b".nan", b"1e999", b"-1e999", b"1e308"),
    *(b"-1e308", b"1e-320", b"0", b"-0.0", b"-1", b"1", b"1e9", b"2147483648", b"0x10", b"1_0"),
    *(b"18446744073709551616", b"-9223372036854775809", b"9" * 400, b"9" * 5000),
    "٣".encode(),
)
"""What a number may be replaced by."""

PIECES = (
    *NUMBERS,
    *(b"", b" ", b"\n", b"\r\n", b"\r", b"\t", b"\0", b"\x1b[2J", b"\\", b'"', b"'", b"#", b","),
    *(
        b"\xff\xfe",
        b"\xef\xbb\xbf",
        b"\xed\xa0\x80",
        b"\xff" * 8,
        bytes(8),
        "é\u2028\u202e".encode(),
    ),
    *(b"null", b"true", b"false", b"{}", b"[]", b'""', b'"a\\nb"', b'"\\ud800"', b"1979-05-27"),
    *(b"[" * 3000, b"{" * 3000, b'{"a":' * 3000, b"[a." * 3000, b"(" * 3000, b"<g>" * 3000),
    *(b"x" * 5000, b"&a [*a]", b"!!python/object/apply:os.abort []", b"<!ENTITY a 'b'>", b"&#10;"),
)
"""What may be put anywhere."""

KINDS = ("flip", "byte", "cut", "drop", "double", "insert", "over", "number", "word")

_PATTERNS = {
    "number": re.compile(rb"[+-]?\d+(?:\.\d*)?(?:[eE][+-]?\d+)?"),
    "word": re.compile(rb"[\w.#-]+"),
}


@dataclass(frozen=True, slots=True)
class Change:
    """One change of bytes; a place beyond the end counts from the beginning again."""

    kind: str
    place: int
    size: int
    piece: bytes

    def of(self, data: bytes) -> bytes:
        """Return the changed bytes."""
        at = self.place % (len(data) + 1)
        if self.kind in _PATTERNS:
            return self._replaced(data, _PATTERNS[self.kind])
        middle, start = {
            "flip": (bytes(byte ^ 1 << self.size % 8 for byte in data[at : at + 1]), at + 1),
            "byte": (bytes([self.size % 256]), at + 1),
            "cut": (b"", len(data)),
            "drop": (b"", at + self.size),
            "double": (data[at : at + self.size], at),
            "over": (self.piece, at + len(self.piece)),
            "insert": (self.piece, at),
        }[self.kind]
        return data[:at] + middle + data[start:]

    def _replaced(self, data: bytes, pattern: re.Pattern[bytes]) -> bytes:
        found = [match.span() for match in pattern.finditer(data)]
        if not found:
            return data + self.piece
        start, end = found[self.place % len(found)]
        return data[:start] + self.piece + data[end:]


def pick(items: Sequence[bytes]) -> SearchStrategy[bytes]:
    """One of the items; unlike ``st.sampled_from``, it does not show all of them when it fails."""
    return st.integers(0, len(items) - 1).map(items.__getitem__)


def changes(words: Sequence[bytes] = ()) -> SearchStrategy[list[Change]]:
    """A few changes; ``words`` are those that mean something to the reader."""
    pieces = st.one_of(pick(PIECES), pick(words)) if words else pick(PIECES)
    places, sizes = st.integers(0, 1 << 16), st.integers(0, 300)
    anywhere = st.builds(Change, st.sampled_from(KINDS), places, sizes, pieces)
    numbers = st.builds(Change, st.just("number"), places, sizes, pick(NUMBERS))
    return st.lists(anywhere | numbers, min_size=1, max_size=3)


def changed(data: bytes, several: Sequence[Change]) -> bytes:
    """Return bytes after all changes."""
    for change in several:
        data = change.of(data)
    return data


def mutated(kept: Sequence[bytes], words: Sequence[bytes] = ()) -> SearchStrategy[bytes]:
    """Kept files with a few changes, or the beginning of one with the end of another."""
    files, places = pick(kept), st.integers(0, 1 << 16)
    return st.one_of(
        st.builds(changed, files, changes(words)),
        st.builds(_spliced, files, files, places, places),
    )


def _spliced(first: bytes, second: bytes, end: int, start: int) -> bytes:
    return first[: end % (len(first) + 1)] + second[start % (len(second) + 1) :]
