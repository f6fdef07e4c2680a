"""Write requirements.lock and requirements-dev.lock: ``make lock``, after a change of versions.

Versions are those of constraints.txt. For each supported machine pip is asked which file it would
install, and what that needs; the locks hold the hashes of these files, so that pip refuses others.
"""

from __future__ import annotations

import itertools
import json
import subprocess
import sys
import tempfile
import tomllib
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path

from packaging.markers import default_environment
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

ROOT = Path(__file__).parent.parent
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
OWN = PROJECT["project"]["name"]
PYTHONS = ("3.11", "3.12", "3.13")
GLIBC = (39, 34, 31, 28, 27, 26, 24, 17, 12, 5)
OLD_NAMES = ("manylinux2014", "manylinux2010", "manylinux1")
PLATFORMS = {
    kind: [f"{tag}_{kind}" for tag in (*(f"manylinux_2_{minor}" for minor in GLIBC), *OLD_NAMES)]
    for kind in ("x86_64", "aarch64")
}
"""Machine, and the platforms of wheels for it: of glibc up to that of Raspberry Pi OS."""
LOCKS = {"requirements.lock": OWN, "requirements-dev.lock": f"{OWN}[dev]"}
"""What each lock is for."""
HEAD = "# By `make lock` of constraints.txt: the files that pip may install, by their hashes.\n"


@dataclass(frozen=True)
class File:
    """One package as pip would install it on one machine."""

    pin: str
    hash: str
    needs: tuple[Requirement, ...]


@dataclass(frozen=True)
class Machine:
    """A machine that is supported."""

    python: str
    kind: str

    def wants(self, requirement: Requirement, extras: Iterable[str]) -> bool:
        """Whether a requirement counts here, for a package with these extras."""
        known = default_environment() | {
            "python_version": self.python,
            "python_full_version": f"{self.python}.0",
            "platform_machine": self.kind,
        }
        marker = requirement.marker
        return marker is None or any(marker.evaluate({**known, "extra": e}) for e in ("", *extras))

    def files(self, pins: list[str]) -> dict[str, File]:
        """Ask pip for the files of some packages, by their names."""
        with tempfile.TemporaryDirectory() as made:
            report = Path(made) / "report.json"
            platforms = [f"--platform={name}" for name in (*PLATFORMS[self.kind], "any")]
            subprocess.run(
                [sys.executable, "-m", "pip", "install", "--quiet", "--dry-run", "--no-deps",
                 "--ignore-installed", f"--target={made}/no", f"--report={report}",
                 "--prefer-binary",
                 f"--python-version={self.python}", "--implementation=cp", *platforms, *pins],
                check=True,
            )  # fmt: skip
            told = json.loads(report.read_text(encoding="utf-8"))["install"]
        sources = [item for item in told if not item["download_info"]["url"].endswith(".whl")]
        for item in sources:
            print(f"no wheel: {item['metadata']['name']}, {self.kind}, Python {self.python}")
        return {canonicalize_name(item["metadata"]["name"]): _file(item) for item in told}


def main() -> int:
    """Write both locks."""
    machines = [Machine(*item) for item in itertools.product(PYTHONS, PLATFORMS)]
    for name, wanted in LOCKS.items():
        chosen = {machine: _closure(machine, wanted) for machine in machines}
        (ROOT / name).write_text(HEAD + "".join(_entries(chosen)), encoding="utf-8")
    return 0


def _file(item: dict) -> File:
    data = item["metadata"]
    return File(
        f"{data['name']}=={data['version']}",
        item["download_info"]["archive_info"]["hashes"]["sha256"],
        tuple(Requirement(text) for text in data.get("requires_dist", [])),
    )


def _closure(machine: Machine, wanted: str) -> dict[str, File]:
    """Return the files of a machine, by name, of all that something needs."""
    pins = _pins()
    files = {OWN: File("", "", tuple(_own_needs()))}
    build = [Requirement(text) for text in (*PROJECT["build-system"]["requires"], "editables")]
    waiting, seen = [Requirement(wanted), *build], set()
    while waiting:
        new = {canonicalize_name(item.name) for item in waiting} - files.keys()
        if unknown := new - pins.keys():
            raise ValueError(f"constraints.txt lacks {', '.join(sorted(unknown))}")
        if new:
            files |= machine.files([f"{name}=={pins[name]}" for name in sorted(new)])
        level, waiting = waiting, []
        for item in level:
            key = canonicalize_name(item.name), frozenset(item.extras)
            if key not in seen:
                seen.add(key)
                needs = files[key[0]].needs
                waiting += [need for need in needs if machine.wants(need, item.extras)]
    del files[OWN]
    return files


def _pins() -> dict[str, str]:
    lines = (ROOT / "constraints.txt").read_text(encoding="utf-8").split()
    return {canonicalize_name(name): pin for name, pin in (line.split("==") for line in lines)}


def _own_needs() -> Iterator[Requirement]:
    """Yield the project's requirements, marked by extras as packages mark theirs."""
    yield from map(Requirement, PROJECT["project"]["dependencies"])
    for extra, needs in PROJECT["project"]["optional-dependencies"].items():
        for text in needs:
            requirement, marker = Requirement(text), f"extra == '{extra}'"
            if requirement.marker:
                marker = f"({requirement.marker}) and {marker}"
            requirement.marker = None
            yield Requirement(f"{requirement}; {marker}")


CHOICES: dict[str, Callable[[Machine], bool]] = {
    "": lambda _: True,
    **{f"platform_machine == '{kind}'": lambda m, k=kind: m.kind == k for kind in PLATFORMS},
    **{f"python_version < '{text}'": lambda m, t=text: m.python < t for text in PYTHONS[1:]},
    **{f"python_version >= '{text}'": lambda m, t=text: m.python >= t for text in PYTHONS[1:]},
}


def _entries(chosen: dict[Machine, dict[str, File]]) -> Iterator[str]:
    for name in sorted({name for files in chosen.values() for name in files}):
        where = [machine for machine, files in chosen.items() if name in files]
        files = [chosen[machine][name] for machine in where]
        (pin,) = {file.pin for file in files}
        lines = [f"--hash=sha256:{item}" for item in sorted({file.hash for file in files})]
        marker = _marker(where, list(chosen))
        yield " \\\n    ".join([f"{pin}{f' ; {marker}' if marker else ''}", *lines]) + "\n"


def _marker(where: list[Machine], machines: list[Machine]) -> str:
    """Return the marker that is true on these machines alone."""
    for first, second in itertools.product(CHOICES, CHOICES):
        if [m for m in machines if CHOICES[first](m) and CHOICES[second](m)] == where:
            return " and ".join(text for text in dict.fromkeys([first, second]) if text)
    raise ValueError(f"no marker for {where}")


if __name__ == "__main__":
    sys.exit(main())
