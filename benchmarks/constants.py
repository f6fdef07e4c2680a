"""What half and twice a constant change: errors, claims, false alarms, and time until found.

``python -m benchmarks.constants monitor.TORN`` follows the same drives with the constant as it is,
halved and doubled; ``estimate.ONLY_PLACE=0.9,0.975`` tries these values instead, and ``--few`` only
a robot's five drives instead of 20. ``track.SHARP+track.NARROW`` changes both together: of most
constants one learns in this way that they change nothing. Constants of other rooms are tried on
pictures, maps, calibrations, laps of a laser, routes or journeys (``constant_runs.TRIALS``).
``--table`` writes ``docs/constants.md`` (``constant_table``).

Each value is tried in a process of its own, which compiles anew what has the constant built in.
The line ``other random numbers`` tells by how much figures differ by chance.
"""

from __future__ import annotations

import subprocess
import sys
import tempfile
from collections import defaultdict
from dataclasses import replace
from pathlib import Path

from benchmarks import constant_table
from benchmarks.changed_constant import Constant
from benchmarks.constant_runs import (
    DRIVES,
    OTHER_NUMBERS,
    Group,
    Outcome,
    Try,
    compiled_users,
    is_recorded_once,
    trials_of,
)

HALF_AND_TWICE = "*0.5,*2"
FEW, TABLE = "--few", "--table"


def main(arguments: list[str]) -> int:
    """Try constants, and print a line for each value; 2 if there is no such constant."""
    if arguments[:1] == [TABLE]:
        return constant_table.main(arguments[1:])
    few = FEW in arguments
    try:
        groups = [
            (_group(names), values or HALF_AND_TWICE)
            for names, _, values in (text.partition("=") for text in arguments if text != FEW)
        ]
    except ValueError as error:
        sys.stderr.write(f"{error}\n")
        return 2
    by_trials: dict[str, list[tuple[Group, str]]] = defaultdict(list)
    for group, values in groups:
        by_trials[trials_of(group[0])].append((group, values))
    for trials, some in by_trials.items():
        with tempfile.TemporaryDirectory() as folder:
            usual = Try(trials, str(Path(folder) / "drives"), few and trials == DRIVES)
            try:
                _try_all(some, usual)
            except subprocess.CalledProcessError as error:
                sys.stderr.write(error.stderr.decode())
                return 1
    return 0


def _group(names: str) -> Group:
    """Return the constants that change together.

    Raises:
        ValueError: one is unknown, or they are tried in different ways.
    """
    group = tuple(Constant.of(name) for name in names.split("+"))
    if len({trials_of(constant) for constant in group}) > 1:
        raise ValueError(f"{names} are tried in different ways; valid are constants of one room")
    return group


def _try_all(groups: list[tuple[Group, str]], usual: Try) -> None:
    outcomes: dict[tuple[tuple[str, str], ...], Outcome] = {(): usual.outcome()}
    print("", *(name for name in outcomes[()] if name != "each"), sep=" | ")
    _print("as it is", outcomes[()], outcomes[()])
    other = replace(usual, other_numbers=OTHER_NUMBERS)
    _print("other random numbers", other.outcome(), outcomes[()])
    for group, values in groups:
        compiled = compiled_users(group)
        if compiled not in outcomes:
            outcomes[compiled] = replace(usual, compiled=compiled).outcome()
        drives = usual.drives if is_recorded_once(group) else ""
        names = tuple(f"{constant.module}.{constant.name}" for constant in group)
        shown = "+".join(constant.name for constant in group)
        for value in values.split(","):
            changed = replace(usual, drives=drives, constants=names, value=value, compiled=compiled)
            _print(f"{shown} {value}", changed.outcome(), outcomes[compiled])


def _print(name: str, outcome: Outcome, usual: Outcome) -> None:
    """Print a line: the figures, and how many of the results are other than usual."""
    figures = [f"{value:.2f}" for key, value in outcome.items() if key != "each"]
    pairs = list(zip(outcome["each"], usual["each"], strict=True))
    other = sum(result != before for result, before in pairs) / len(pairs)
    print(name, *figures, f"{100 * other:.1f} % of results differ", sep=" | ", flush=True)


if __name__ == "__main__":
    raise SystemExit(main(sys.argv[1:]))
