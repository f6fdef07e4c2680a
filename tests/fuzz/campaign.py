"""A campaign fuzzes every target for a long time: ``make fuzz``, or ``MINUTES=60 make fuzz``.

Inputs that are refused in new words are kept in memory and changed further. What fails is made as
small as possible, and kept as a file of the corpus: the tests then fail until it is mended.
"""

from __future__ import annotations

import argparse
import hashlib
import random
import re
import sys
import tempfile
import time
import traceback
import warnings
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path

from examination import OverdueError, examine
from hypothesis import HealthCheck, Phase, given, seed, settings
from hypothesis.errors import HypothesisWarning
from parsers import program
from targets import CORPUS, TARGETS, Target, samples

OURS = tuple(str(CORPUS.parents[2] / name) for name in ("app", "robot", "sim", "tests"))
ROUND = 300
"""Examples of one target, before it is the next one's turn."""
MOST_KEPT = 200
"""Most inputs of a target that are changed further."""


@dataclass
class Tally:
    """What was seen of one target."""

    name: str
    valid_files: list[bytes]
    other_files: list[bytes]
    examples: int = 0
    valid: int = 0
    slowest: float = 0.0
    words: dict[str, bytes] = field(default_factory=dict)
    """An input of each kind of refusal."""
    failures: dict[str, bytes] = field(default_factory=dict)
    """The smallest input of each failure."""

    def examine(self, target: Target, data: bytes, folder: Path) -> None:
        """Examine one input; a failure that is known already raises nothing."""
        self.examples += 1
        begin = time.process_time()
        try:
            words = examine(target.parser, data, folder)
        except (Exception, OverdueError) as error:
            place = _place(error)
            known = self.failures.get(place)
            if known is None or len(data) < len(known):
                self.failures[place] = data
            raise AssertionError(place) from error
        self.slowest = max(self.slowest, time.process_time() - begin)
        if words is None:
            self.valid += 1
        elif len(self.words) < MOST_KEPT:
            self.words.setdefault(_kind(words), data)

    def row(self) -> str:
        """One line of the table."""
        share = self.valid / max(self.examples, 1)
        return (
            f"{self.name:16} {self.examples:9} {share:7.1%} {len(self.words):8} "
            f"{1000 * self.slowest:8.0f} {len(self.failures):8}"
        )


HEAD = f"{'target':16} {'examples':>9} {'valid':>7} {'refusals':>8} {'max ms':>8} {'failures':>8}"


def main(arguments: Sequence[str] | None = None) -> int:
    """Fuzz, and print what was seen; 1 if anything failed."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--minutes", type=float, default=60.0, help="how long [min]")
    parser.add_argument("--seed", type=int, default=random.SystemRandom().randrange(2**32))
    parser.add_argument("targets", nargs="*", default=list(TARGETS), metavar="TARGET")
    parsed = parser.parse_args(arguments)
    if unknown := set(parsed.targets) - TARGETS.keys():
        parser.error(f"unknown: {', '.join(sorted(unknown))}; valid are {', '.join(TARGETS)}")
    program()  # takes longer than any input may
    warnings.simplefilter("error")
    warnings.simplefilter("ignore", HypothesisWarning)  # a failing input may be long
    tallies = [Tally(name, *samples(name)) for name in parsed.targets]
    print(f"seed {parsed.seed}, {parsed.minutes:g} min", flush=True)
    begin = time.monotonic()
    try:
        with tempfile.TemporaryDirectory(prefix="brickpose-fuzz-") as made:
            _fuzz(tallies, Path(made), parsed.seed, begin + 60 * parsed.minutes)
    finally:
        print(f"after {(time.monotonic() - begin) / 60:.1f} min", HEAD, sep="\n")
        print(*(tally.row() for tally in tallies), sep="\n", flush=True)
    return 1 if any(tally.failures for tally in tallies) else 0


def _fuzz(tallies: Sequence[Tally], folder: Path, first_seed: int, end: float) -> None:
    number = first_seed
    while time.monotonic() < end:
        for tally in tallies:
            number += 1
            _round(tally, folder, number)
            if time.monotonic() > end:
                return


def _round(tally: Tally, folder: Path, number: int) -> None:
    """Examine some inputs; the first failure ends the round, made as small as possible."""
    target, before = TARGETS[tally.name], set(tally.failures)

    @seed(number)
    @settings(
        max_examples=ROUND,
        deadline=None,
        database=None,
        phases=(Phase.generate, Phase.shrink),
        suppress_health_check=list(HealthCheck),
        print_blob=False,
    )
    @given(target.inputs(tally.valid_files, [*tally.other_files, *tally.words.values()]))
    def ask(data: bytes) -> None:
        try:
            tally.examine(target, data, folder)
        except AssertionError as error:
            if str(error) not in before:
                raise

    with suppress(ExceptionGroup, AssertionError):  # the tally has it
        ask()
    for place in tally.failures.keys() - before:
        _keep(tally.name, place, tally.failures[place])


def _keep(name: str, place: str, data: bytes) -> None:
    path = CORPUS / name / f"found-{hashlib.sha256(data).hexdigest()[:8]}"
    path.write_bytes(data)
    print(f"{name}: {place}\n  kept as {path}", flush=True)


def _place(error: BaseException) -> str:
    """Return kind and place of an exception: what is the same for the same defect."""
    if isinstance(error, OverdueError):
        return "OverdueError"
    frames = traceback.extract_tb(error.__traceback__)
    last = [frame for frame in frames if frame.filename.startswith(OURS)][-1]
    words = _kind(str(error)).splitlines()[0][:120] if str(error) else ""
    return f"{type(error).__name__} at {Path(last.filename).name}:{last.lineno}: {words}"


def _kind(words: str) -> str:
    """Return words without what they quote and count: the same for the same fault."""
    return re.sub(r"'[^']*'|\"[^\"]*\"|[\d.]+", "_", words)[:120]


if __name__ == "__main__":
    sys.exit(main())
