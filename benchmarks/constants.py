"""What half and twice a constant change: errors, claims, false alarms, and time until found.

``python -m benchmarks.constants monitor.TORN`` follows the same drives with the constant as it is,
halved and doubled; ``estimate.ONLY_PLACE=0.9,0.975`` tries these values instead, and ``--few`` only
a robot's five drives instead of 20. ``track.SHARP+track.NARROW`` changes both together: of most
constants one learns in this way that they change nothing. Those of ``robot.scanning`` are tried on
pictures, and those of ``robot.mapping`` and ``robot.calibration`` on maps that are drawn and robots
that are calibrated.

Each value is tried in a process of its own, which compiles anew what has the constant built in.
The line ``other random numbers`` tells by how much figures differ by chance.
"""

from __future__ import annotations

import importlib
import json
import os
import shutil
import subprocess
import sys
import tempfile
from collections import defaultdict
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

from benchmarks.changed_constant import Constant, change

SHARED = ("robot.localization.", "robot.scanning.", "robot.mapping.", "robot.calibration.")
"""No constant of these modules changes what their trials record: it is recorded once."""
RECORDING = ("robot.calibration.drive_log", "robot.calibration.programme")
"""But these decide which pictures are recorded, and how the robot drives."""
DRIVES = "benchmarks.constant_trials"
TRIALS = {
    "robot.scanning.": "benchmarks.constant_scans",
    "robot.mapping.": "benchmarks.constant_maps",
    "robot.calibration.": "benchmarks.constant_maps",
}
"""What tries the constants of a room; ``DRIVES`` tries the others."""
HALF_AND_TWICE = "*0.5,*2"
OTHER_NUMBERS = 1000
"""Added to the seeds of the filters, to see by how much figures differ by chance."""
ONE_BY_ONE, FEW = "--try", "--few"

Outcome = dict[str, Any]
Group = tuple[Constant, ...]


@dataclass(frozen=True)
class Try:
    """What a process of its own tries."""

    trials: str
    """The module that has them."""
    drives: str
    """The file of the drives; empty: they are recorded by the process itself."""
    few: bool = False
    constants: tuple[str, ...] = ()
    """Dotted names of what changes; empty: all is as it is."""
    value: str = ""
    compiled: tuple[tuple[str, str], ...] = ()
    """Functions that are compiled anew, by module and name."""
    other_numbers: int = 0

    def outcome(self) -> Outcome:
        """Start the process, and return its figures."""
        program = [sys.executable, "-m", "benchmarks.constants", ONE_BY_ONE]
        with tempfile.TemporaryDirectory() as folder:
            environment = dict(os.environ)
            if self.compiled:
                _copy_compiled(Path(folder), self.compiled)
                environment["NUMBA_CACHE_DIR"] = folder
            done = subprocess.run(
                [*program, json.dumps(asdict(self))],
                env=environment,
                stdout=subprocess.PIPE,
                check=True,
            )
        result: Outcome = json.loads(done.stdout)
        return result

    def carry_out(self) -> int:
        """Be that process."""
        change([Constant.of(name) for name in self.constants], self.value)
        # Only now, as it imports what is changed.
        trials = importlib.import_module(self.trials)
        drives = trials.recorded(Path(self.drives) if self.drives else None)
        if self.few:
            drives = trials.few(drives)
        json.dump(trials.tried(drives, self.other_numbers), sys.stdout)
        return 0


def _copy_compiled(folder: Path, without: tuple[tuple[str, str], ...]) -> None:
    """Copy all compiled code that is kept, but for some functions, by module and name."""
    kept = importlib.import_module("robot.compiling").CACHE.folder
    if kept is None:
        return
    copy = folder / kept.name
    shutil.copytree(kept, copy)
    for module, name in without:
        *_, parent, own = module.split(".")
        for path in copy.glob(f"{parent}_*/{own}.{name}-*"):
            path.unlink()


def main(arguments: list[str]) -> int:
    """Try constants, and print a line for each value; 2 if there is no such constant."""
    if arguments[:1] == [ONE_BY_ONE]:
        return Try(**json.loads(arguments[1])).carry_out()
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
        by_trials[_trials(group[0])].append((group, values))
    for trials, some in by_trials.items():
        with tempfile.TemporaryDirectory() as folder:
            usual = Try(trials, str(Path(folder) / "drives"), few and trials == DRIVES)
            _try_all(some, usual)
    return 0


def _group(names: str) -> Group:
    """Return the constants that change together.

    Raises:
        ValueError: one is unknown, or they are tried in different ways.
    """
    group = tuple(Constant.of(name) for name in names.split("+"))
    if len({_trials(constant) for constant in group}) > 1:
        raise ValueError(f"{names} are tried in different ways; valid are constants of one room")
    return group


def _trials(constant: Constant) -> str:
    return next((name for room, name in TRIALS.items() if constant.module.startswith(room)), DRIVES)


def _try_all(groups: list[tuple[Group, str]], usual: Try) -> None:
    outcomes: dict[tuple[tuple[str, str], ...], Outcome] = {(): usual.outcome()}
    print("", *(name for name in outcomes[()] if name != "each"), sep=" | ")
    _print("as it is", outcomes[()], outcomes[()])
    other = replace(usual, other_numbers=OTHER_NUMBERS)
    _print("other random numbers", other.outcome(), outcomes[()])
    for group, values in groups:
        compiled = tuple(sorted({user for constant in group for user in constant.compiled_users}))
        if compiled not in outcomes:
            outcomes[compiled] = replace(usual, compiled=compiled).outcome()
        is_shared = all(
            constant.module.startswith(SHARED) and constant.module not in RECORDING
            for constant in group
        )
        drives = usual.drives if is_shared else ""
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
