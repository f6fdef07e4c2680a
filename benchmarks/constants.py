"""What half and twice a constant change: errors, claims, false alarms, and time until found.

``python -m benchmarks.constants monitor.TORN`` follows the same drives with the constant as it is,
halved and doubled; ``estimate.ONLY_PLACE=0.9,0.975`` tries these values instead. Each is tried in a
process of its own, which compiles anew if compiled code may have the constant built in.
The line ``other random numbers`` tells by how much figures differ by chance.
"""

from __future__ import annotations

import importlib
import json
import os
import subprocess
import sys
import tempfile
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

from benchmarks.changed_constant import Constant

SHARED = "robot.localization."
"""No constant of these modules changes a drive: they are tried on drives that are recorded once."""
HALF_AND_TWICE = "*0.5,*2"
OTHER_NUMBERS = 1000
"""Added to the seeds of the filters, to see by how much figures differ by chance."""
ONE_BY_ONE = "--try"

Outcome = dict[str, Any]


@dataclass(frozen=True)
class Try:
    """What a process of its own tries."""

    drives: str
    """The file of the drives; empty: they are recorded by the process itself."""
    constant: str = ""
    """Dotted name; empty: all is as it is."""
    value: str = ""
    recompiles: bool = False
    """Whether all is compiled anew, and nothing of it kept."""
    other_numbers: int = 0

    def outcome(self) -> Outcome:
        """Start the process, and return its figures."""
        program = [sys.executable, "-m", "benchmarks.constants", ONE_BY_ONE]
        with tempfile.TemporaryDirectory() as folder:
            done = subprocess.run(
                [*program, json.dumps(asdict(self))],
                env=os.environ | ({"NUMBA_CACHE_DIR": folder} if self.recompiles else {}),
                stdout=subprocess.PIPE,
                check=True,
            )
        result: Outcome = json.loads(done.stdout)
        return result

    def carry_out(self) -> int:
        """Be that process."""
        if self.constant:
            Constant.of(self.constant).change(self.value)
        # Only now, as it imports what is changed.
        trials = importlib.import_module("benchmarks.constant_trials")
        drives = trials.recorded(Path(self.drives) if self.drives else None)
        json.dump(trials.tried(drives, self.other_numbers), sys.stdout)
        return 0


def main(arguments: list[str]) -> int:
    """Try constants, and print a line for each value; 2 if there is no such constant."""
    if arguments[:1] == [ONE_BY_ONE]:
        return Try(**json.loads(arguments[1])).carry_out()
    try:
        constants = [
            (Constant.of(name), values or HALF_AND_TWICE)
            for name, _, values in (text.partition("=") for text in arguments)
        ]
    except ValueError as error:
        sys.stderr.write(f"{error}\n")
        return 2
    with tempfile.TemporaryDirectory() as folder:
        usual = Try(str(Path(folder) / "drives"))
        outcomes = {False: usual.outcome()}
        print("", *(name for name in outcomes[False] if name != "claims"), sep=" | ")
        _print("as it is", outcomes[False], outcomes[False])
        other = replace(usual, other_numbers=OTHER_NUMBERS)
        _print("other random numbers", other.outcome(), outcomes[False])
        for constant, values in constants:
            recompiles = constant.is_compiled
            if recompiles not in outcomes:
                outcomes[recompiles] = replace(usual, recompiles=recompiles).outcome()
            drives = usual.drives if constant.module.startswith(SHARED) else ""
            for value in values.split(","):
                changed = Try(drives, f"{constant.module}.{constant.name}", value, recompiles)
                _print(f"{constant.name} {value}", changed.outcome(), outcomes[recompiles])
    return 0


def _print(name: str, outcome: Outcome, usual: Outcome) -> None:
    """Print a line: the figures, and how many of the claims are other than usual."""
    figures = [f"{value:.2f}" for key, value in outcome.items() if key != "claims"]
    pairs = list(zip(outcome["claims"], usual["claims"], strict=True))
    other = sum(claim != before for claim, before in pairs) / len(pairs)
    print(name, *figures, f"{100 * other:.1f} % of claims differ", sep=" | ", flush=True)


if __name__ == "__main__":
    raise SystemExit(main(sys.argv[1:]))
