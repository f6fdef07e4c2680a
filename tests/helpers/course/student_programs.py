"""Programs as students write them, wrong ones and right ones, with the causes that are named.

A file of ``programs/`` has one after the other, each below a line
``### LESSON KIND NAME [CAUSE]: what is wrong``. With ``@NAME`` before the colon it is the right
program of that name with a change: lines that begin with ``-`` give way to those with ``+``.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from pathlib import Path

FOLDER = Path(__file__).parent / "programs"
SETS = (
    *("first", "second", "third", "fourth", "fifth", "sixth", "seventh", "eighth"),
    *("ninth", "tenth", "eleventh", "twelfth", "thirteenth"),
)
"""Sets of wrong programs; each was written before the grader knew its mistakes."""
HEAD = re.compile(r"(\d+) (wrong|right) ([\w.-]+)(?: \[([\w-]+)\])?(?: @([\w-]+))?(?:: (.*))?")


@dataclass(frozen=True)
class Program:
    """A student's program."""

    lesson: int
    name: str
    cause: str
    """The one that is named first; empty for a right program."""
    about: str
    """What is wrong with it."""
    source: str


def programs(name: str) -> Iterator[Program]:
    """Read a file's programs: of one of ``SETS``, or ``right``."""
    for part in re.split(r"(?m)^### ", (FOLDER / f"{name}.txt").read_text())[1:]:
        head, _, source = part.partition("\n")
        found = HEAD.fullmatch(head)
        assert found, head
        lesson, _, own, cause, base, about = found.groups()
        text = _changed(base, source) if base else source
        yield Program(int(lesson), own, cause or "", about or "", text)


@cache
def _right() -> dict[str, str]:
    return {program.name: program.source for program in programs("right")}


def _changed(base: str, change: str) -> str:
    source = _right()[base]
    for block in re.findall(r"(?:^-.*\n)+(?:^\+.*\n?)+", change, re.M):
        lines = block.splitlines()
        old = "\n".join(line[1:] for line in lines if line.startswith("-"))
        new = "\n".join(line[1:] for line in lines if line.startswith("+"))
        assert old in source, (base, old)
        source = source.replace(old, new)
    return source
