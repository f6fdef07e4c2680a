"""Reads files of other people in a process of its own, which a clock and a limit of memory end.

While the robot drives, a file that somebody sent must cost it neither Python's lock nor the memory.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from concurrent.futures import TimeoutError as TooLongError
from pathlib import Path
from typing import TypeVar

from app.operating_system import set_niceness
from app.worker_process import WorkerEndedError, WorkerProcess
from robot.errors import BrickPoseError

T = TypeVar("T")

PATIENCE_S = 60.0
"""Longest time for one file, of which a small computer needs 10 to begin [s]."""
MEMORY = 1 << 30
"""Most memory that reading may take, besides the program itself [bytes]."""
NICENESS = 10


class CostlyFileError(BrickPoseError, RuntimeError):
    """A file takes more time or memory to read than any usual one."""


def read_apart(read: Callable[[Path], T], path: Path, patience_s: float = PATIENCE_S) -> T:
    """Read a file in a process of its own.

    Args:
        read: a function of a module, whose result and errors can be sent.
        path: its argument.
        patience_s: longest time that it may take [s].

    Raises:
        CostlyFileError: it took too much time or memory.
        Exception: whatever ``read`` raises.
    """
    with WorkerProcess() as process:
        try:
            return process.submit(_read_within_limits, (read, path)).result(patience_s)
        except TooLongError:
            why = f"is not read after {patience_s:g} s"
        except MemoryError:
            why = f"takes more than {MEMORY >> 20} MB of memory to read"
        except WorkerEndedError:
            why = "ends the process that reads it"
    raise CostlyFileError(f"{path.name} {why}; valid are files that a robot's computer can handle")


def _read_within_limits(job: tuple[Callable[[Path], T], Path]) -> T:
    read, path = job
    set_niceness(NICENESS)
    _limit_memory()
    return read(path)


def _limit_memory() -> None:
    """Let this process take little more memory than it has; only Linux can be told that."""
    if sys.platform != "linux":
        return
    import resource  # noqa: PLC0415 - not on Windows

    pages = int(Path("/proc/self/statm").read_text().split()[0])
    limit = pages * resource.getpagesize() + MEMORY
    hard = resource.getrlimit(resource.RLIMIT_AS)[1]
    if hard == resource.RLIM_INFINITY or limit < hard:
        resource.setrlimit(resource.RLIMIT_AS, (limit, limit))
