"""Cache of compiled code, kept from one run to the next.

numba compiles a function again when its own file changes, but not when a file changes whose
functions or constants it uses. After an update, old mathematics would stay in use. So each state of
all these files has a folder of its own.

What lies in the folder is executed. So a folder counts only if nobody else can have written to it.
"""

from __future__ import annotations

import contextlib
import hashlib
import os
import re
import shutil
import stat
import sys
import tempfile
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from robot.user_folders import cache_folder

HERE = Path(__file__).parent
KEPT_S = 7 * 24 * 3600.0
"""Folders of earlier states are removed after this time [s]."""
IMPORTS = re.compile(rb"^from ([\w.]+) import", re.MULTILINE)


@dataclass(frozen=True)
class CompileCache:
    """Where compiled code is kept."""

    folder: Path | None
    """None if no folder can be used: then each start compiles again."""
    complaint: str | None = None
    """Why no folder can be used."""


def set_compile_cache(packages: tuple[Path, ...] = (HERE, HERE.parent / "sim")) -> CompileCache:
    """Set the folder where numba keeps compiled code, and return it.

    The folder is beside the program where that can be written to, else in the user's own folder of
    caches.

    Args:
        packages: folders with compiled functions.
    """
    name = f"compiled-{_digest(packages)}"
    refused = []
    shared = None
    for parent in _parents():
        folder = parent if parent.name == name else parent / name
        reason = _prepare(folder, shared)
        if reason is None:
            _use(str(folder))
            return CompileCache(folder)
        refused.append(f"{parent} {reason}")
        if shared is None and folder.is_dir() and _is_safe(folder) and _is_safe(parent):
            shared = folder
    _use("")
    return CompileCache(None, "; ".join(refused))


def _parents() -> Iterator[Path]:
    """Yield where the folder may be, the best first."""
    given = os.environ.get("NUMBA_CACHE_DIR")
    if given:
        yield Path(given).absolute()
    yield HERE / "__pycache__"
    try:
        yield cache_folder()
    except RuntimeError:  # this user has no home
        return


def _prepare(folder: Path, shared: Path | None) -> str | None:
    """Make a folder if it is missing; return why it cannot be used, or None if it can.

    A new one begins as a copy of ``shared``, where an administrator has compiled for all users.
    """
    try:
        new = not folder.exists()
        if new and shared is not None:
            _copy(shared, folder)
        # Nobody else may write to folders that are made here, whatever the user's umask says.
        for missing in reversed([path for path in (folder, *folder.parents) if not path.exists()]):
            missing.mkdir(mode=0o755, exist_ok=True)
        tempfile.TemporaryFile(dir=folder).close()
    except OSError as error:
        return f"cannot be written to ({error.strerror})"
    for path in (folder, folder.parent):
        if not _is_safe(path):
            return f"could hold code of others: {path} belongs to, or can be written to by, others"
    if new:
        _remove_old(folder.parent)
    return None


def _copy(shared: Path, folder: Path) -> None:
    """Copy a folder; another program sees all of it or nothing."""
    folder.parent.mkdir(mode=0o755, parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(prefix=".unfinished-", dir=folder.parent) as beside:
        copy = Path(beside) / folder.name
        # Only the content: who may write to it does not come along.
        shutil.copytree(shared, copy, copy_function=shutil.copyfile)
        copy.chmod(0o755)
        with contextlib.suppress(OSError):  # another program was first
            copy.rename(folder)


def _is_safe(folder: Path) -> bool:
    """Return whether nobody but this user and the system can have written to a folder."""
    if sys.platform == "win32":
        return True  # who may write is inherited from the user's profile
    status = folder.stat()
    if status.st_uid not in (os.getuid(), 0):
        return False
    # Distributions that give each user a group of their own let that group write.
    others = stat.S_IWOTH if status.st_gid == status.st_uid else stat.S_IWOTH | stat.S_IWGRP
    # In a sticky folder, such as /tmp, others cannot replace what is not theirs.
    return not status.st_mode & others or bool(status.st_mode & stat.S_ISVTX)


def _remove_old(parent: Path) -> None:
    for old in parent.glob("compiled-*"):
        # A program that still runs may compile more into its folder.
        if time.time() - old.stat().st_mtime > KEPT_S:
            shutil.rmtree(old, ignore_errors=True)


def _use(folder: str) -> None:
    os.environ["NUMBA_CACHE_DIR"] = folder
    if "numba" in sys.modules:
        sys.modules["numba"].config.CACHE_DIR = folder


def _digest(packages: tuple[Path, ...]) -> str:
    result = hashlib.sha256()
    for path in sorted(set(_sources(packages))):
        result.update(path.read_bytes())
    return result.hexdigest()[:12]


def _sources(packages: tuple[Path, ...]) -> Iterator[Path]:
    """Yield the files with compiled functions, and the files that they import from."""
    for path in (path for package in packages for path in package.rglob("*.py")):
        text = path.read_bytes()
        if b"@compiled(" in text:
            yield path
            for module in IMPORTS.findall(text):
                imported = HERE.parent.joinpath(*module.decode().split(".")).with_suffix(".py")
                if imported.is_file():
                    yield imported
