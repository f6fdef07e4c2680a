"""What ``brickpose doctor`` checks for the course: what holds a student's file that is graded."""

from __future__ import annotations

from collections.abc import Iterator

from app.features.course.sandbox.confinement import KERNEL
from app.features.course.sandbox.student_process import StudentError, StudentProcess
from app.settings.config import Config
from app.tools.doctor.finding import Finding, ok, problem, warning


def check_student_files(_config: Config) -> Iterator[Finding]:
    """Check what holds a student's file that is graded here."""
    try:
        with StudentProcess("nothing.py", "") as process:
            fences = process.fences
    except (StudentError, OSError) as error:
        yield problem(f"A student's file cannot be run: {error}")
        return
    words = f"A student's file is held by {', '.join(fences)}"
    if set(fences) >= KERNEL:
        yield ok(words)
    else:
        yield warning(f"{words}; not by the kernel", "grade strangers' files on Linux, also in WSL")
