"""What differs between Linux, macOS and Windows: limits, processes, addresses.

The rest of the program asks here, and needs no condition of its own. Four things are elsewhere: the
user's folders (``robot/user_folders.py``), how files are replaced (``app/files.py``), how a
student's file is fenced (``app/features/course/sandbox``), and how bytes pass a serial port
(``robot/hat/wire``).
"""

from __future__ import annotations

import ctypes
import os
import signal
import socket
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from typing import Any

MOST_DESCRIPTORS = 4096
"""The limit of descriptors is raised to this, if the system allows it."""
SELECTED = 512
"""Most sockets that Windows' ``select`` takes, on which the server's event loop is built there."""

MOST_ARENAS, OWN_PAGES_FROM, KEPT_FREE = -8, -3, -1
"""glibc's M_ARENA_MAX, M_MMAP_THRESHOLD and M_TRIM_THRESHOLD."""
LARGE = 4_000_000
"""What is larger gets pages of its own, which the system has back at once [bytes]. Nothing that the
control loop makes anew in each tick is as large."""

ABOVE_NORMAL = 0x8000
"""Windows' class of priority for work that comes before others."""
BELOW_NORMAL = 0x4000
"""Windows' class of priority for work that others come before."""


def windows_kernel() -> Any:
    """Return Windows' own library; other systems have no ``WinDLL``."""
    return vars(ctypes)["WinDLL"]("kernel32", use_last_error=True)


def share_freed_memory() -> None:
    """Let all threads take memory from one arena; call it before there are others.

    By default, glibc gives threads arenas of their own, and what one frees, another cannot have:
    with pictures and messages that one thread makes and another drops, a program took 23 MB more,
    and 5 MB more in half an hour of trouble (``brickpose bench soak``). And once something large
    was freed, it keeps what is as large for itself: 5 MB of what only a start needs. Other systems
    have none of this.
    """
    if sys.platform == "linux":
        set_option = getattr(ctypes.CDLL(None), "mallopt", None)  # musl has none
        if set_option is not None:
            set_option(MOST_ARENAS, 1)
            set_option(OWN_PAGES_FROM, LARGE)
            set_option(KEPT_FREE, LARGE)


def raise_descriptors() -> int:
    """Raise the limit of open descriptors as far as the system allows; return it."""
    if sys.platform == "win32":
        return SELECTED
    import resource  # noqa: PLC0415 - not on Windows

    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    most = MOST_DESCRIPTORS if hard == resource.RLIM_INFINITY else min(hard, MOST_DESCRIPTORS)
    if soft == resource.RLIM_INFINITY or soft >= most:
        return most if soft == resource.RLIM_INFINITY else soft
    resource.setrlimit(resource.RLIMIT_NOFILE, (most, hard))
    return most


def claim_address(listening: socket.socket) -> None:
    """Let a socket have an address that a program has just left, but none that one still has."""
    if sys.platform == "win32":
        # SO_REUSEADDR would let two programs listen at one address there.
        listening.setsockopt(socket.SOL_SOCKET, socket.SO_EXCLUSIVEADDRUSE, 1)
    else:
        listening.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)


@contextmanager
def children_deaf_to_ctrl_c() -> Iterator[None]:
    """Start processes in this block that Ctrl-C does not reach, also while they begin."""
    if sys.platform == "win32":
        kernel = windows_kernel()
        kernel.SetConsoleCtrlHandler(None, 1)
        try:
            yield
        finally:
            kernel.SetConsoleCtrlHandler(None, 0)
    else:
        signal.pthread_sigmask(signal.SIG_BLOCK, (signal.SIGINT,))
        try:
            yield
        finally:
            signal.pthread_sigmask(signal.SIG_UNBLOCK, (signal.SIGINT,))


def set_niceness(niceness: int) -> None:
    """Let this process work before others, if below zero, or only with what they leave it.

    Windows has one step of each. A system that does not allow the former changes nothing.
    """
    if sys.platform == "win32":
        kernel = windows_kernel()
        kernel.GetCurrentProcess.restype = ctypes.c_void_p
        kernel.SetPriorityClass.argtypes = (ctypes.c_void_p, ctypes.c_uint32)
        priority = ABOVE_NORMAL if niceness < 0 else BELOW_NORMAL
        kernel.SetPriorityClass(kernel.GetCurrentProcess(), priority)
    else:
        with suppress(PermissionError):
            os.setpriority(os.PRIO_PROCESS, 0, niceness)
