"""Collects the students' files and grades them, as ``brickpose check FOLDER`` does."""

from __future__ import annotations

import os
import stat
import subprocess
import sys
from pathlib import Path

import anyio.to_thread
from anyio.abc import TaskGroup

from app.features.classroom.class_folder import ClassFolder

FILE = "my_filter.py"
LONGEST = 1 << 20
GRADING_S = 600.0


def collect(folder: ClassFolder, logins: list[str]) -> Path:
    """Copy the students' files, each below its name; return the folder of the copies.

    The files are the students' own: what is no plain file there, or is very long, is left out.
    """
    target = folder.path / "collected"
    target.mkdir(mode=0o700, exist_ok=True)
    for login in logins:
        content = _content(folder.home_of(login) / FILE)
        place = target / login
        place.mkdir(exist_ok=True)
        (place / FILE).unlink(missing_ok=True)
        if content is not None:
            (place / FILE).write_bytes(content)
    return target


def _content(path: Path) -> bytes | None:
    """Return the content of a plain file; None of a link, which may lead anywhere, or a pipe."""
    try:
        number = os.open(path, os.O_RDONLY | os.O_NOFOLLOW | os.O_NONBLOCK)
    except OSError:
        return None
    with os.fdopen(number, "rb") as file:
        if not stat.S_ISREG(os.fstat(number).st_mode):
            return None
        content = file.read(LONGEST + 1)
    return content if len(content) <= LONGEST else None


def grade(folder: ClassFolder, logins: list[str]) -> Path:
    """Collect and grade; return the CSV, a row for each file, beside which JUnit's XML is.

    Raises:
        RuntimeError: the grader said no more than words.
    """
    copies, result = collect(folder, logins), folder.path / "results.csv"
    junit = result.with_suffix(".xml")
    result.unlink(missing_ok=True)
    words = ["check", str(copies), "--csv", str(result), "--junit", str(junit)]
    done = subprocess.run(
        [sys.executable, "-m", "app", *words],
        capture_output=True, text=True, timeout=GRADING_S, check=False, stdin=subprocess.DEVNULL,
    )  # fmt: skip
    if not result.is_file():
        raise RuntimeError((done.stderr or done.stdout).strip()[-500:] or "nothing was graded")
    return result


class Results:
    """The newest results of a class; grading goes on while the wall answers."""

    def __init__(self) -> None:
        self.tasks: TaskGroup | None = None
        """Where grading goes on; the server has it as long as it runs."""
        self._grading = False
        self.file: Path | None = None
        """The results; None while they are made, and before."""
        self.failure = ""

    def begin(self, folder: ClassFolder, logins: list[str]) -> None:
        """Begin to collect and grade, unless that is being done."""
        self.file, self.failure = None, ""
        if not self._grading and self.tasks is not None:
            self._grading = True
            self.tasks.start_soon(self._grade, folder, logins)

    async def _grade(self, folder: ClassFolder, logins: list[str]) -> None:
        try:
            self.file = await anyio.to_thread.run_sync(grade, folder, logins)
        except (RuntimeError, OSError, subprocess.SubprocessError) as error:
            self.failure = f"grading failed: {error}"
        finally:
            self._grading = False
