"""Landlock: the kernel lets this process read a few folders, and write nothing.

It needs no root; see ``landlock(7)`` of Linux, 5.13 and later.
"""

from __future__ import annotations

import ctypes
import os
import struct
import sys
from collections.abc import Sequence
from pathlib import Path

CREATE_RULESET, ADD_RULE, RESTRICT_SELF = 444, 445, 446
"""Numbers of the system calls, the same on all machines."""
SET_NO_NEW_PRIVS = 38
VERSION_FLAG = 1
PATH_BENEATH = 1
READ_FILE, READ_DIR, REFER, TRUNCATE, IOCTL = 1 << 2, 1 << 3, 1 << 13, 1 << 14, 1 << 15
FIRST_RIGHTS = (1 << 13) - 1
"""All rights on files of the first version."""
TCP = 0b11
"""Binding and connecting, from version 4 on."""
OTHERS = 0b11
"""Abstract sockets and signals of processes outside, from version 6 on."""


def restrict_files(readable: Sequence[Path]) -> bool:
    """Allow reading below some paths and nothing else, for good; False if the kernel cannot."""
    if sys.platform != "linux":
        return False
    libc = ctypes.CDLL(None, use_errno=True)
    version = libc.syscall(CREATE_RULESET, None, 0, VERSION_FLAG)
    if version < 1:
        return False
    handled = _rights(version)
    attributes = struct.pack("<QQQ", handled, TCP, OTHERS)
    size = 24 if version >= 6 else 16 if version >= 4 else 8
    ruleset = libc.syscall(CREATE_RULESET, attributes[:size], size, 0)
    if ruleset < 0 or libc.prctl(SET_NO_NEW_PRIVS, 1, 0, 0, 0) != 0:
        return False
    for path in readable:
        _allow(libc, ruleset, path)
    done = libc.syscall(RESTRICT_SELF, ruleset, 0) == 0
    os.close(ruleset)
    return bool(done)


def _rights(version: int) -> int:
    rights = FIRST_RIGHTS
    for since, right in ((2, REFER), (3, TRUNCATE), (5, IOCTL)):
        if version >= since:
            rights |= right
    return rights


def _allow(libc: ctypes.CDLL, ruleset: int, path: Path) -> None:
    try:
        place = os.open(path, os.O_PATH | os.O_CLOEXEC)
    except OSError:
        return  # what is not there needs no right
    rights = READ_FILE | READ_DIR if path.is_dir() else READ_FILE
    libc.syscall(ADD_RULE, ruleset, PATH_BENEATH, struct.pack("<Qi", rights, place), 0)
    os.close(place)
