"""How much a student's process may take; and what it gives up by itself, where systems let it."""

from __future__ import annotations

import sys

MEMORY = 2 * 1024**3
"""Address space of the process [bytes]; NumPy and numba take half of it."""
CPU_S = 30
"""Processor time of the whole process [s]; each call has a shorter limit, by the clock."""
FILES = 64
"""Most files that may be open."""


def limit_this_process() -> None:
    """Lower this process's limits for good; on Windows the program that started it has done so.

    Apple's processors refuse a limit of memory: there the grader looks how much is in use.

    Raises:
        ValueError, OSError: Linux refuses a limit.
    """
    if sys.platform == "win32":
        return
    import resource  # noqa: PLC0415 - not on Windows

    limits = {
        resource.RLIMIT_AS: MEMORY,
        resource.RLIMIT_CPU: CPU_S,
        resource.RLIMIT_FSIZE: 0,
        resource.RLIMIT_CORE: 0,
        resource.RLIMIT_NOFILE: FILES,
    }
    if sys.platform == "darwin":
        limits[resource.RLIMIT_NPROC] = 0  # Linux counts threads, and seccomp refuses processes
    for limit, most in limits.items():
        _, hard = resource.getrlimit(limit)
        allowed = most if hard == resource.RLIM_INFINITY else min(most, hard)
        try:
            resource.setrlimit(limit, (allowed, allowed))
        except (ValueError, OSError):
            if sys.platform == "linux" or limit != resource.RLIMIT_AS:
                raise
