"""A user of its own for a process that root has started: it owns nothing, and no other is its.

Without root, a process cannot change its user, and seccomp and Landlock alone hold it.
"""

from __future__ import annotations

import ctypes
import os
import struct
import sys
from collections.abc import Iterable
from contextlib import suppress
from pathlib import Path

FIRST_USER = 1_900_000_000
"""Numbers from here on belong to nobody, neither on systems nor in containers; a process adds its
own."""
NOBODY = 65534
"""Who it is in a container that has fewer numbers."""
KEEP_RIGHTS = 8
RIGHTS_VERSION = 0x20080522
READ_ANYTHING = 1 << 2
"""Root's right to read files whoever owns them (CAP_DAC_READ_SEARCH)."""


def leave_root(readable: Iterable[Path], *, fenced: bool) -> bool:
    """Become a user that nothing belongs to, for good; False if this process is not root's.

    Args:
        readable: what it reads later. Where Python itself lies in a folder of root's, the right to
            read is kept, of all that root has.
        fenced: whether Landlock holds it to these files; else nothing is kept.
    """
    if sys.platform != "linux" or os.geteuid() != 0:
        return False
    libc = ctypes.CDLL(None, use_errno=True)
    libc.prctl(KEEP_RIGHTS, 1, 0, 0, 0)
    for user in (FIRST_USER + os.getpid(), NOBODY):
        with suppress(OSError):  # the number is not of this container
            os.setgroups([])
            os.setresgid(user, user, user)
            os.setresuid(user, user, user)
            break
    else:
        return False
    hidden = any(not os.access(path, os.R_OK) for path in readable)
    rights = READ_ANYTHING if hidden and fenced else 0
    header = struct.pack("<Ii", RIGHTS_VERSION, 0)
    libc.capset(header, struct.pack("<6I", rights, rights, 0, 0, 0, 0))
    return True
