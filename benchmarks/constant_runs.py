"""A run that tries a constant: a process of its own, in which modules have another value of it.

``TRIALS`` tells which module tries the constants of which room. It has ``recorded``, ``few`` and
``tried``: what is tried is recorded once, and each run returns figures.
"""

from __future__ import annotations

import importlib
import json
import os
import resource
import shutil
import subprocess
import sys
import tempfile
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from benchmarks.changed_constant import Constant, change

SHARED = (
    "robot.localization.",
    "robot.navigation.",
    "robot.scanning.",
    "robot.mapping.",
    "robot.calibration.",
)
"""No constant of these modules changes what their trials record: it is recorded once."""
RECORDING = ("robot.calibration.drive_log", "robot.calibration.programme")
"""But these decide which pictures are recorded, and how the robot drives."""
DRIVES = "benchmarks.constant_trials"
TRIALS = {
    "robot.calibration.": "benchmarks.constant_calibrations",
    "robot.driving.route": "benchmarks.constant_routes",
    "robot.localization.grid.": "benchmarks.constant_filters",
    "robot.localization.kalman_filter": "benchmarks.constant_filters",
    "robot.mapping.": "benchmarks.constant_maps",
    "robot.mapping.graph.": "benchmarks.constant_lasers",
    "robot.mapping.grid.": "benchmarks.constant_lasers",
    "robot.navigation.": "benchmarks.constant_journeys",
    "robot.scanning.": "benchmarks.constant_scans",
}
"""What tries the constants of a room, which the longest name that fits tells; ``DRIVES`` tries the
others.
"""
OTHER_NUMBERS = 1000
"""Added to the seeds of the filters, to see by how much figures differ by chance."""

Outcome = dict[str, Any]
Group = tuple[Constant, ...]


def trials_of(constant: Constant) -> str:
    """Return the module that tries a constant."""
    rooms = [room for room in TRIALS if constant.module.startswith(room)]
    return TRIALS[max(rooms, key=len)] if rooms else DRIVES


def is_recorded_once(group: Group) -> bool:
    """Return whether no constant of a group changes what its trials record."""
    return all(each.module.startswith(SHARED) and each.module not in RECORDING for each in group)


def compiled_users(group: Group) -> tuple[tuple[str, str], ...]:
    """Return the compiled functions that have a constant of a group built in."""
    return tuple(sorted({user for constant in group for user in constant.compiled_users}))


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
    longest_s: int = 0
    """How much time of the processor it may take [s]; 0: any."""

    def outcome(self) -> Outcome:
        """Start the process, and return its figures.

        Raises:
            subprocess.CalledProcessError: it fails, or by ``SIGXCPU``, it takes too long.
        """
        program = [sys.executable, "-m", "benchmarks.constant_runs"]
        with tempfile.TemporaryDirectory() as folder:
            environment = dict(os.environ)
            if self.compiled:
                _copy_compiled(Path(folder), self.compiled)
                environment["NUMBA_CACHE_DIR"] = folder
            done = subprocess.run(
                [*program, json.dumps(asdict(self))],
                env=environment,
                capture_output=True,
                check=True,
            )
        result: Outcome = json.loads(done.stdout.splitlines()[-1])
        return result

    def carry_out(self) -> None:
        """Be that process."""
        if self.longest_s:
            resource.setrlimit(resource.RLIMIT_CPU, (self.longest_s, self.longest_s + 1))
        change([Constant.of(name) for name in self.constants], self.value)
        # Only now, as it imports what is changed.
        trials = importlib.import_module(self.trials)
        drives = trials.recorded(Path(self.drives) if self.drives else None)
        if self.few:
            drives = trials.few(drives)
        json.dump(trials.tried(drives, self.other_numbers), sys.stdout)


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


if __name__ == "__main__":
    Try(**json.loads(sys.argv[1])).carry_out()
