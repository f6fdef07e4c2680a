"""What the locks install on each system with each Python, by a resolver: ``make platforms``.

uv is told of another system and another Python, and allowed wheels alone: where a package would
have to be built, its name stands in the table. That takes minutes and a package index: so the
answers are kept in a file beside, with the digest of the lock that they are of.
"""

from __future__ import annotations

import hashlib
import json
import re
import subprocess
import sys
from collections.abc import Callable, Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import asdict, dataclass
from itertools import product
from pathlib import Path

ROOT = Path(__file__).parents[2]
PYTHONS = ("3.11", "3.12", "3.13", "3.14")
SYSTEMS = {
    "Linux x86-64": "x86_64-manylinux_2_28",
    "Linux aarch64": "aarch64-manylinux_2_28",
    "macOS arm64": "aarch64-apple-darwin",
    "Windows x86-64": "x86_64-pc-windows-msvc",
}
"""Systems by the names that uv has for them: of glibc since 2.28, that of Debian 10."""
LOCKS = {"the program": "requirements.lock", "tests and checks": "requirements-dev.lock"}
ANSWERS = Path(__file__).with_suffix(".json")
ENGINES = {"pybullet": "pybullet", "mujoco-core": "MuJoCo"}
"""Physics by the package that has it; the first is the default where both are."""
NO_WHEEL = re.compile(r"[Bb]ecause ([\w.-]+)\S*==\S+ has no (?:usable )?wheels")
LIMIT_S = 120.0

Place = tuple[str, str]
"""A system and a Python."""


class NoIndexError(Exception):
    """No resolver, or no index that it could ask."""


@dataclass(frozen=True)
class Resolved:
    """What a lock installs on one system with one Python."""

    packages: Mapping[str, str]
    """Versions by names; empty if a package has no wheel."""
    missing: str = ""
    """The package that has no wheel."""

    @property
    def engine(self) -> str:
        """Which physics the robot has by default."""
        return next((name for package, name in ENGINES.items() if package in self.packages), "none")


def resolved(lock: Path, place: Place) -> Resolved:
    """Ask the resolver for one lock and place.

    Raises:
        NoIndexError: there is no answer from here.
    """
    system, python = place
    try:
        done = subprocess.run(
            [sys.executable, "-m", "uv", "pip", "compile", "--quiet", "--no-config",
             f"--python-platform={SYSTEMS[system]}", f"--python-version={python}",
             "--only-binary=:all:", "--no-annotate", "--no-header", str(lock)],
            capture_output=True, text=True, timeout=LIMIT_S, check=False,
        )  # fmt: skip
    except subprocess.TimeoutExpired as error:
        raise NoIndexError(f"no answer within {LIMIT_S:g} s") from error
    if done.returncode == 0:
        pairs = re.findall(r"^(\S+)==(\S+)", done.stdout, re.MULTILINE)
        return Resolved(dict(pairs))
    said = " ".join(done.stderr.split())
    if "No solution found" not in said:
        raise NoIndexError(said[:300])
    found = NO_WHEEL.search(said)
    return Resolved({}, found[1] if found else said)


def everywhere(lock: Path) -> dict[Place, Resolved]:
    """Ask for all systems and Pythons."""
    places = list(product(SYSTEMS, PYTHONS))
    with ThreadPoolExecutor(2) as pool:
        return dict(zip(places, pool.map(lambda place: resolved(lock, place), places), strict=True))


def kept(name: str) -> dict[Place, Resolved]:
    """Return the answers that were kept of one lock.

    Raises:
        ValueError: they are of a lock of before.
    """
    lock = json.loads(ANSWERS.read_text(encoding="utf-8"))[name]
    if lock["sha256"] != _digest(ROOT / LOCKS[name]):
        raise ValueError(f"{LOCKS[name]} has changed; make platforms asks the resolver again")
    return {
        (system, python): Resolved(**answer)
        for system, answers in lock["places"].items()
        for python, answer in answers.items()
    }


def _digest(lock: Path) -> str:
    return hashlib.sha256(lock.read_text(encoding="utf-8").encode()).hexdigest()


def _keep(answers: Mapping[str, Mapping[Place, Resolved]]) -> None:
    locks = {
        name: {
            "sha256": _digest(ROOT / LOCKS[name]),
            "places": {
                system: {python: asdict(places[system, python]) for python in PYTHONS}
                for system in SYSTEMS
            },
        }
        for name, places in answers.items()
    }
    ANSWERS.write_text(json.dumps(locks, indent=1) + "\n", encoding="utf-8")


def table(title: str, cell: Callable[[Place], str]) -> str:
    """Draw one figure of all places."""
    rows = [[title, *PYTHONS], ["---"] * (1 + len(PYTHONS))]
    rows += [[system, *(cell((system, python)) for python in PYTHONS)] for system in SYSTEMS]
    return "\n".join(f"| {' | '.join(row)} |" for row in rows)


def main() -> int:
    """Ask what is installed where, and which physics drives there; print it and keep it."""
    answers = {name: everywhere(ROOT / lock) for name, lock in LOCKS.items()}
    _keep(answers)
    for name, places in answers.items():
        print(f"Packages of {name}, all as wheels:\n")
        print(table("", lambda at, of=places: of[at].missing or str(len(of[at].packages))) + "\n")
    program = answers["the program"]
    print("Physics by default:\n\n" + table("", lambda place: program[place].engine))
    return int(any(one.missing for places in answers.values() for one in places.values()))


if __name__ == "__main__":
    sys.exit(main())
