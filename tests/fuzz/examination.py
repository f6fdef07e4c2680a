"""The examination of a parser: bytes are taken or refused in a line, soon, in little memory."""

from __future__ import annotations

import resource
import signal
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from parsers import Parser

PROCESSOR_S = 5.0
"""Longest time for one input [s]; all inputs are small."""

MEMORY = 2 << 30
"""Most memory that one input may ask for [bytes]."""

LONGEST = 2000
"""Longest refusal [characters]."""


class OverdueError(BaseException):
    """A parser takes too long; no handler of ordinary exceptions stops it."""


def examine(parser: Parser, data: bytes, folder: Path) -> str | None:
    """Return the words of the refusal, None if the bytes are valid; all else is an exception."""
    with _limited_memory(), _limited_time():
        words = parser(data, folder)
    if words is not None:
        assert 0 < len(words) <= LONGEST, f"a refusal of {len(words)} characters: {words[:200]}"
        assert words.isprintable(), f"a refusal that is no line of text: {words[:200]!r}"
    return words


@contextmanager
def _limited_memory() -> Iterator[None]:
    before = resource.getrlimit(resource.RLIMIT_AS)
    pages = int(Path("/proc/self/statm").read_text(encoding="ascii").split()[0])
    allowed = pages * resource.getpagesize() + MEMORY
    resource.setrlimit(resource.RLIMIT_AS, (allowed, before[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_AS, before)


@contextmanager
def _limited_time() -> Iterator[None]:
    def end(*_: object) -> None:
        raise OverdueError(f"more than {PROCESSOR_S:g} s of the processor")

    before = signal.signal(signal.SIGPROF, end)
    signal.setitimer(signal.ITIMER_PROF, PROCESSOR_S)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0)
        signal.signal(signal.SIGPROF, before)
