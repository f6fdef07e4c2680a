"""Cache of compiled code, kept from one run to the next.

numba compiles a function again when its own file changes, but not when a file changes whose
functions or constants it uses. After an update, old mathematics would stay in use. So each state of
all these files has a folder of its own.
"""

from __future__ import annotations

import hashlib
import os
import re
import shutil
import sys
import time
from collections.abc import Iterator
from pathlib import Path

HERE = Path(__file__).parent
KEPT_S = 7 * 24 * 3600.0
"""Folders of earlier states are removed after this time [s]."""
IMPORTS = re.compile(rb"^from ([\w.]+) import", re.MULTILINE)


def set_compile_cache(packages: tuple[Path, ...] = (HERE, HERE.parent / "sim")) -> Path | None:
    """Set the folder where numba keeps compiled code, and return it.

    If the folder cannot be made, leave the choice to numba and return None.

    Args:
        packages: folders with compiled functions.
    """
    given = os.environ.get("NUMBA_CACHE_DIR")
    parent = Path(given) if given else HERE / "__pycache__"
    name = f"compiled-{_digest(packages)}"
    folder = parent if parent.name == name else parent / name
    if not folder.exists():
        try:
            folder.mkdir(parents=True)
        except OSError:
            return None
        for old in folder.parent.glob("compiled-*"):
            # A program that still runs may compile more into its folder.
            if time.time() - old.stat().st_mtime > KEPT_S:
                shutil.rmtree(old, ignore_errors=True)
    os.environ["NUMBA_CACHE_DIR"] = str(folder)
    if "numba" in sys.modules:
        sys.modules["numba"].config.CACHE_DIR = str(folder)
    return folder


def _digest(packages: tuple[Path, ...]) -> str:
    result = hashlib.sha256()
    for path in sorted(set(_sources(packages))):
        result.update(path.read_bytes())
    return result.hexdigest()[:12]


def _sources(packages: tuple[Path, ...]) -> Iterator[Path]:
    """Yield the files with compiled functions, and the files that they import from."""
    for path in (path for package in packages for path in package.rglob("*.py")):
        text = path.read_bytes()
        if b"@njit" in text:
            yield path
            for module in IMPORTS.findall(text):
                imported = HERE.parent.joinpath(*module.decode().split(".")).with_suffix(".py")
                if imported.is_file():
                    yield imported
