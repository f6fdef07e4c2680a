"""The table of constants, ``docs/constants.md``: what half and twice of each one change.

``python -m benchmarks.constants --table`` measures each constant that stands under ``TO_MEASURE``
in ``unmeasured_constants.txt``, and each one whose value is another one than in the table. It keeps
what it has after each constant, so it may be stopped. ``--table route.SPEED`` measures that one.

A figure differs by more than chance if it does by more than ``SDS`` standard deviations of the
figures that are had with other random numbers. What seems better by that is tried once more with
other random numbers, and is called better if it is so there as well.
"""

from __future__ import annotations

import math
import re
import signal
import subprocess
import sys
import tempfile
import textwrap
from collections import defaultdict
from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from pathlib import Path

from benchmarks.changed_constant import ROOT, Constant
from benchmarks.constant_runs import (
    OTHER_NUMBERS,
    Outcome,
    Try,
    compiled_users,
    is_recorded_once,
    trials_of,
)

PAGE = ROOT / "docs" / "constants.md"
UNMEASURED = ROOT / "tests" / "project" / "unmeasured_constants.txt"
TO_MEASURE = "[Decide, have a trial, and are not measured yet]"
NOT_AT_WORK = (
    "[Decide, and no trial of benchmarks.constants has them at work: they are not measured]"
)
QUICK_FIRST = (
    "benchmarks.constant_routes",
    "benchmarks.constant_journeys",
    "benchmarks.constant_lasers",
    "benchmarks.constant_scans",
    "benchmarks.constant_calibrations",
    "benchmarks.constant_trials",
    "benchmarks.constant_filters",
    "benchmarks.constant_maps",
)
"""The order of trials; constants that are built into compiled code come last."""
OTHERS, SDS = 4, 4.0
"""Runs with other random numbers; four standard deviations of one run are 2.8 of a difference."""
HALF, TWICE = "*0.5", "*2"
ABSURD = ("*100", "*0.01")
"""Tried if half and twice change no result, to see that a trial has the constant at work."""
LONGEST_S = 180
"""A run that takes more time of the processor, fails."""
LARGER_IS_BETTER = ("right [%]", "certain [%]", "cause named [%]")
"""Of all other figures, a smaller one is better."""
BETTER, WORSE, MIXED = "better", "worse", "better and worse"
BY_CHANCE, SAME_RESULTS = "nothing beyond chance", "no result differs"
SAME_VALUE = "is the same"
COLUMNS = ("file", "constant", "value", "what it is", "measured", "verdict")
HEAD = """# What half and twice of a constant change

The numbers by which the program decides, and that are no setting: each was halved and doubled, and
the same drives, pictures or logs were followed again. `python -m benchmarks.constants --table`
makes this page; it measures what is missing, and what has another value by now. Other constants
have their measurement in the text below them.

A figure is shown with half, as it is, and with twice the value; `by chance` is what it differs by
if only random numbers, or the drives, are others: four standard deviations of five runs. What
differs by less is `nothing beyond chance`. What is `better` was so with other random numbers too;
of so many constants, some are by chance all the same. It is better in these trials, by the figures
that are shown, and no reason alone for another value: a route at twice the speed takes less time,
and nothing in its trial tells that pictures blur. Where no result differs, a hundred times or a
hundredth of the value was tried as well, and changed results. Whole numbers stay whole; `is the
same` stands for half of 1.

"""


@dataclass(frozen=True)
class Row:
    """A constant of the table, with what was measured, as text."""

    file: str
    constant: str
    value: str
    """As the source has it."""
    sentence: str
    measured: str
    verdict: str

    @property
    def line(self) -> str:
        """Return it as a line of the page."""
        cells = (self.file, self.constant, self.value, self.sentence, self.measured, self.verdict)
        return f"| {' | '.join(cell.replace('|', '&#124;') for cell in cells)} |"


def main(names: list[str]) -> int:
    """Measure named constants, or all that lack it; 2 if there is no such constant."""
    try:
        named = [Constant.of(name) for name in names]
    except ValueError as error:
        sys.stderr.write(f"{error}\n")
        return 2
    rows = read_rows(PAGE)
    rows = {key: row for key, row in rows.items() if (ROOT / key[0]).exists()}
    rows = {key: row for key, row in rows.items() if _constant(key).stands}
    changed = [
        _constant(key) for key, row in rows.items() if row.value != _constant(key).expression()
    ]
    files = listed_constants(UNMEASURED).get(TO_MEASURE, {})
    listed = [_constant((file, name)) for file, names in files.items() for name in names]
    todo = named or [*changed, *(each for each in listed if each not in changed)]
    _write(rows)
    groups: dict[tuple[bool, int, str], list[Constant]] = defaultdict(list)
    for constant in todo:
        trials = trials_of(constant)
        is_slow = bool(compiled_users((constant,)))
        groups[is_slow, QUICK_FIRST.index(trials), trials].append(constant)
    for (_, _, trials), constants in sorted(groups.items()):
        with tempfile.TemporaryDirectory() as folder:
            measuring = Measuring(Try(trials, str(Path(folder) / "recorded"), few=True))
            for constant in constants:
                row = measuring.row(constant)
                key = (constant.place, constant.name)
                if row is not None:
                    rows[key] = row
                    _write(rows)
                move_listed(UNMEASURED, key, NOT_AT_WORK if row is None else None)
                said = "not at work" if row is None else row.verdict
                print(f"{constant.place} {constant.name}: {said}", flush=True)
    return 0


def _constant(key: tuple[str, str]) -> Constant:
    place, name = key
    return Constant(place.removesuffix(".py").replace("/", "."), name)


# Measuring


class Measuring:
    """Measures constants by the trials of one kind."""

    def __init__(self, usual: Try, outcome: Callable[[Try], Outcome] = Try.outcome) -> None:
        self._usual, self._outcome = usual, outcome
        self._as_it_is = outcome(usual)
        others = [
            outcome(replace(usual, other_numbers=OTHER_NUMBERS * number))
            for number in range(1, OTHERS + 1)
        ]
        self._other = others[0]
        self._chance = {
            name: SDS * _sd([each[name] for each in (self._as_it_is, *others)])
            for name in self._as_it_is
            if name != "each"
        }

    def row(self, constant: Constant) -> Row | None:
        """Return what half and twice change; None if no value changes a result."""
        tries = {HALF: self._tried(constant, HALF), TWICE: self._tried(constant, TWICE)}
        verdicts = {factor: self._verdict(each) for factor, each in tries.items()}
        if set(verdicts.values()) <= {SAME_RESULTS, SAME_VALUE}:
            absurd = (self._verdict(self._tried(constant, factor)) for factor in ABSURD)
            if all(verdict in (SAME_RESULTS, SAME_VALUE) for verdict in absurd):
                return None
        for factor, verdict in verdicts.items():
            if verdict in (BETTER, MIXED):
                verdicts[factor] = self._confirmed(constant, factor, verdict)
        words = {HALF: "half", TWICE: "twice"}
        parts = [f"{words[factor]} {_with_verb(verdict)}" for factor, verdict in verdicts.items()]
        if len(set(verdicts.values())) == 1:
            parts = [f"half and twice: {verdicts[HALF]}"]
        return Row(
            constant.place,
            constant.name,
            constant.expression(),
            constant.sentence,
            self._figures(tries),
            "; ".join(parts),
        )

    def _tried(
        self, constant: Constant, factor: str, other_numbers: int = 0
    ) -> Outcome | str | None:
        """Return figures; why it failed, if it did; None if the value is the same."""
        if constant.expression(factor) == constant.expression():
            return None
        run = replace(
            self._usual,
            drives=self._usual.drives if is_recorded_once((constant,)) else "",
            constants=(f"{constant.module}.{constant.name}",),
            value=factor,
            compiled=compiled_users((constant,)),
            other_numbers=other_numbers,
            longest_s=LONGEST_S,
        )
        try:
            return self._outcome(run)
        except subprocess.CalledProcessError as error:
            if error.returncode == -signal.SIGXCPU:
                return f"does not end within {LONGEST_S} s of the processor"
            lines = (error.stderr or b"").decode(errors="replace").strip().splitlines()
            last = re.match(r"(?:\w+\.)*(\w+)", lines[-1] if lines else "")
            return f"fails ({last.group(1) if last else 'ended'})"

    def _verdict(self, outcome: Outcome | str | None, usual: Outcome | None = None) -> str:
        usual = usual or self._as_it_is
        if outcome is None or isinstance(outcome, str):
            return outcome or SAME_VALUE
        if outcome["each"] == usual["each"]:
            return SAME_RESULTS
        gains = [self._gain(name, outcome, usual) for name in self._chance]
        better, worse = max(gains) > 1, min(gains) < -1
        if better and worse:
            return MIXED
        return BETTER if better else WORSE if worse else BY_CHANCE

    def _gain(self, name: str, outcome: Outcome, usual: Outcome) -> float:
        """Return by how much a figure is better, in units of what it differs by chance."""
        figure, before = float(outcome[name]), float(usual[name])
        if figure == before:
            return 0.0
        if math.isnan(figure) or math.isnan(before):
            # All was refused: the number of the refused ones tells so.
            return 0.0
        gain = figure - before if name in LARGER_IS_BETTER else before - figure
        if math.isinf(gain) or self._chance[name] == 0:
            return math.copysign(math.inf, gain)
        return gain / self._chance[name]

    def _confirmed(self, constant: Constant, factor: str, verdict: str) -> str:
        """Return what stays of a verdict with other random numbers."""
        other = self._verdict(self._tried(constant, factor, OTHER_NUMBERS), self._other)
        if other in (BETTER, MIXED):
            return other if verdict == MIXED else verdict
        return WORSE if verdict == MIXED else f"{BY_CHANCE} (better only with these random numbers)"

    def _figures(self, tries: dict[str, Outcome | str | None]) -> str:
        """Return the figures that change most for the better and for the worse, as text."""
        outcomes = [each for each in tries.values() if isinstance(each, dict)]
        gains = {
            name: [self._gain(name, outcome, self._as_it_is) for outcome in outcomes] or [0.0]
            for name in self._chance
        }
        best = max(gains, key=lambda name: max(gains[name]))
        worst = min(gains, key=lambda name: min(gains[name]))
        most = max(gains, key=lambda name: max(map(abs, gains[name])))
        shown = [name for name in (best, worst) if max(map(abs, gains[name])) > 1] or [most]
        return "; ".join(
            f"{name}: {', '.join(self._figure(name, each) for each in row)}"
            f" (by chance {_number(self._chance[name])})"
            for name in dict.fromkeys(shown)
            for row in [(tries[HALF], self._as_it_is, tries[TWICE])]
        )

    @staticmethod
    def _figure(name: str, outcome: Outcome | str | None) -> str:
        return _number(outcome[name]) if isinstance(outcome, dict) else "-"


def _with_verb(verdict: str) -> str:
    states = (BETTER, WORSE, MIXED)
    if verdict in states:
        return f"is {verdict}"
    return (
        f"changes {verdict}"
        if verdict.startswith(BY_CHANCE)
        else verdict.replace(SAME_RESULTS, "changes no result")
    )


def _sd(values: list[float]) -> float:
    """Return the standard deviation of values; of infinite and unknown ones, inf."""
    if not all(map(math.isfinite, values)):
        return math.inf
    mean = sum(values) / len(values)
    return math.sqrt(sum((value - mean) ** 2 for value in values) / (len(values) - 1))


def _number(value: float) -> str:
    return f"{value:.3g}" if abs(value) < 100 or math.isinf(value) else f"{value:.0f}"


# Files


def read_rows(page: Path) -> dict[tuple[str, str], Row]:
    """Return the rows of a page by file and constant; none if there is no page."""
    rows: dict[tuple[str, str], Row] = {}
    for line in page.read_text("utf-8").splitlines() if page.exists() else ():
        cells = [cell.strip().replace("&#124;", "|") for cell in line.strip("| ").split(" | ")]
        if len(cells) == len(COLUMNS) and cells[0].endswith(".py"):
            rows[cells[0], cells[1]] = Row(*cells)
    return rows


def write_page(page: Path, rows: Iterable[Row]) -> None:
    """Write a page of rows, by file and constant."""
    head = [f"| {' | '.join(COLUMNS)} |", "|---" * len(COLUMNS) + "|"]
    lines = [row.line for row in sorted(rows, key=lambda row: (row.file, row.constant))]
    kept = page.with_suffix(".part")
    kept.write_text(HEAD + "\n".join([*head, *lines]) + "\n", "utf-8")
    kept.replace(page)


def _write(rows: dict[tuple[str, str], Row]) -> None:
    write_page(PAGE, (replace(row, sentence=_constant(key).sentence) for key, row in rows.items()))


def listed_constants(path: Path) -> dict[str, dict[str, list[str]]]:
    """Return the names of ``unmeasured_constants.txt`` by section and file."""
    sections: dict[str, dict[str, list[str]]] = {}
    section, place = "", ""
    for line in path.read_text("utf-8").splitlines():
        if line.startswith("["):
            section = line
            sections[section] = {}
        elif not line.startswith("#"):
            file, colon, names = line.rpartition(":")
            place = file if colon else place
            if names:
                sections[section].setdefault(place, []).extend(names.split())
    return sections


def move_listed(path: Path, key: tuple[str, str], section: str | None) -> None:
    """Take a constant off a list; write it into another section, if one is given."""
    place, name = key
    head = [line for line in path.read_text("utf-8").splitlines() if line.startswith("#")]
    sections = listed_constants(path)
    for files in sections.values():
        files[place] = [each for each in files.get(place, []) if each != name]
    if section is not None:
        sections.setdefault(section, {}).setdefault(place, []).append(name)
    lines = head
    for title, files in sections.items():
        known = sorted((file, names) for file, names in files.items() if names)
        lines += ["", title] if known else []
        for file, names in known:
            lines += textwrap.wrap(f"{file}: {' '.join(names)}", 100, subsequent_indent="    ")
    path.write_text("\n".join(lines) + "\n", "utf-8")
