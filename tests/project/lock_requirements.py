"""Write requirements.lock and requirements-dev.lock: ``make lock``, after a change of versions.

Versions are those of constraints.txt. uv resolves once for all systems, machines and Pythons, and
adds the hashes of each version's files, so that pip refuses others.
"""

from __future__ import annotations

import re
import subprocess
import sys
import tomllib
from pathlib import Path

from packaging.utils import canonicalize_name

ROOT = Path(__file__).parents[2]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
LOCKS: dict[str, list[str]] = {"requirements.lock": [], "requirements-dev.lock": ["--extra=dev"]}
HEAD = "# By `make lock` of constraints.txt: the files that pip may install, by their hashes.\n"
BUILD = (*PROJECT["build-system"]["requires"], "editables")
"""What installs the project itself."""
ALWAYS = "platform_python_implementation == 'CPython'"
"""A marker that is the same for all packages says nothing."""


def main() -> int:
    """Write both locks."""
    pins = _names((ROOT / "constraints.txt").read_text(encoding="utf-8"))
    for file, extras in LOCKS.items():
        lock = _resolved(extras)
        if unknown := _names(lock) - pins:
            print(f"constraints.txt lacks {', '.join(sorted(unknown))}", file=sys.stderr)
            return 1
        (ROOT / file).write_text(HEAD + lock, encoding="utf-8")
    return 0


def _resolved(extras: list[str]) -> str:
    """Return the lock of the project with some extras, for every machine and Python."""
    oldest = PROJECT["project"]["requires-python"].removeprefix(">=")
    done = subprocess.run(
        [sys.executable, "-m", "uv", "pip", "compile", "--quiet", "--universal",
         f"--python-version={oldest}", "--constraint=constraints.txt", "--generate-hashes",
         "--no-annotate", "--no-header", *extras, "pyproject.toml", "-"],
        input="\n".join(BUILD), cwd=ROOT, check=True, stdout=subprocess.PIPE, text=True,
    )  # fmt: skip
    return re.sub(rf" and {ALWAYS}|{ALWAYS} and | ; {ALWAYS}(?= \\)", "", done.stdout)


def _names(text: str) -> set[str]:
    return {canonicalize_name(name) for name in re.findall(r"^(\S+)==", text, re.MULTILINE)}


if __name__ == "__main__":
    sys.exit(main())
