"""``confine`` holds a student's server before it serves: files, ports, processes and limits.

Its children (control, workers, whatever a student's model starts) are held with it. Code that the
grader runs is in the course's own, narrower sandbox besides.
"""

from __future__ import annotations

import ctypes
import os
import resource
import stat
import struct
import sys
from collections.abc import Iterator
from pathlib import Path

import numba

from app.features.classroom.warm.request import Confinement
from app.features.classroom.warm.watch import FIRST_USER

MOST_PROCESSES = 120
"""Of a student's own user: the program has some thirty with its threads, and as many again for a
grader's. A fork bomb ends there."""
MOST_FILE = 1 << 30
"""Longest file [bytes]."""
NICER = 2
CREATE_RULESET, ADD_RULE, RESTRICT_SELF = 444, 445, 446
SET_NO_NEW_PRIVS, KEEP_RIGHTS, AMBIENT, AMBIENT_RAISE, CHILD_SUBREAPER = 38, 8, 47, 2, 36
RIGHTS_VERSION = 0x20080522
READ_ANYTHING = 1 << 2
"""Root's right to read files whoever owns them, for a Python that lies in a folder of root's; then
Landlock alone says what is read."""
SYSTEM = (
    "/usr", "/lib", "/lib64", "/bin", "/sbin", "/opt", "/proc", "/sys/devices/system/cpu",
    "/etc/ld.so.cache", "/etc/ssl", "/etc/hosts", "/etc/resolv.conf", "/etc/nsswitch.conf",
    "/etc/passwd", "/etc/group", "/etc/localtime", "/etc/fonts", "/etc/mime.types",
)  # fmt: skip
ROOT = Path(__file__).resolve().parents[4]
READING = (1 << 0) | (1 << 2) | (1 << 3)
"""Running, reading files, and listing folders."""
FIRST_RIGHTS = (1 << 13) - 1
OF_PATH, OF_PORT = 1, 2
BIND, CONNECT = 1, 2
OTHERS = 0b11
"""Abstract sockets and signals of processes outside."""


def confine(held: Confinement, longest_file: int = MOST_FILE) -> list[str]:
    """Hold this process for good; return the fences, in words.

    Args:
        held: to what.
        longest_file: no file gets longer [bytes].
    """
    home = Path(held.home)
    fences = ["limits of the system"]
    is_root = os.geteuid() == 0
    user = FIRST_USER + held.number
    if is_root:
        _give_away(home, user)
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    resource.setrlimit(resource.RLIMIT_FSIZE, (longest_file, longest_file))
    if held.memory:
        # Of each process: what it can write beside what a warm process has, and shares.
        most = held.memory + _data_now()
        resource.setrlimit(resource.RLIMIT_DATA, (most, most))
    os.nice(NICER)
    if sys.platform == "linux":  # who loses its parent stays below the server, where it is watched
        ctypes.CDLL(None).prctl(CHILD_SUBREAPER, 1, 0, 0, 0)
    hidden = False
    if is_root:
        hidden = not all(_anybody_reads(path) for path in (ROOT, Path(sys.base_prefix)))
        resource.setrlimit(resource.RLIMIT_NPROC, (MOST_PROCESSES, MOST_PROCESSES))
    fenced = _fence(held)
    if fenced:
        fences.append("Landlock")
    if is_root:
        _become(user, reads_anything=hidden and fenced)
        fences.append("a user of its own")
    return fences


def _data_now() -> int:
    """Return what this process can write now [bytes]."""
    try:
        return int(Path("/proc/self/statm").read_text().split()[5]) * resource.getpagesize()
    except OSError:
        return 0


def _anybody_reads(path: Path) -> bool:
    return all(each.stat().st_mode & stat.S_IXOTH for each in (path, *path.parents))


def _give_away(home: Path, user: int) -> None:
    for folder, _, files in os.walk(home, followlinks=False):
        os.chown(folder, user, user, follow_symlinks=False)
        for name in files:
            os.chown(Path(folder, name), user, user, follow_symlinks=False)
    home.chmod(0o700)


def _become(user: int, *, reads_anything: bool) -> None:
    """Become a user of the system's that nothing else belongs to, for good."""
    libc = ctypes.CDLL(None)
    libc.prctl(KEEP_RIGHTS, 1, 0, 0, 0)
    os.setgroups([])
    os.setresgid(user, user, user)
    os.setresuid(user, user, user)
    rights = READ_ANYTHING if reads_anything else 0
    header = struct.pack("<Ii", RIGHTS_VERSION, 0)
    libc.capset(header, struct.pack("<6I", rights, rights, rights, 0, 0, 0))
    if rights:  # programs that it starts, as workers, have to read Python, too
        libc.prctl(AMBIENT, AMBIENT_RAISE, 2, 0, 0)
    libc.prctl(SET_NO_NEW_PRIVS, 1, 0, 0, 0)


def _fence(held: Confinement) -> bool:
    """Let this process write in its home, and read what programs are made of; False if it cannot.

    From Linux 6.7 on it also reaches no TCP port but its own and the hub's, and from 6.12 on no
    process outside by signals.

    Landlock allows what is named. Where the class's folder lies in a folder that is allowed, that
    is allowed entry by entry, without the way to the other students.
    """
    if sys.platform != "linux":
        return False
    libc = ctypes.CDLL(None, use_errno=True)
    version = libc.syscall(CREATE_RULESET, None, 0, 1)
    if version < 1:
        return False
    rights = FIRST_RIGHTS | ((1 << 13) if version >= 2 else 0) | ((1 << 14) if version >= 3 else 0)
    size = 24 if version >= 6 else 16 if version >= 4 else 8
    attributes = struct.pack("<QQQ", rights, BIND | CONNECT, OTHERS)[:size]
    ruleset = libc.syscall(CREATE_RULESET, attributes, size, 0)
    if ruleset < 0:
        return False
    libc.prctl(SET_NO_NEW_PRIVS, 1, 0, 0, 0)
    for path in _readable():
        for allowed in _around(path.resolve(), Path(held.class_folder).resolve()):
            _allow(libc, ruleset, allowed, READING)
    for path in (Path(held.home), Path("/dev")):
        _allow(libc, ruleset, path, rights)
    if version >= 4:
        for port, right in ((held.own_port, BIND | CONNECT), (held.hub_port, CONNECT)):
            libc.syscall(ADD_RULE, ruleset, OF_PORT, struct.pack("<QQ", right, port), 0)
    done = libc.syscall(RESTRICT_SELF, ruleset, 0) == 0
    os.close(ruleset)
    return bool(done)


def _readable() -> set[Path]:
    cache = getattr(numba.config, "CACHE_DIR", "")
    paths = {*sys.path, sys.prefix, sys.base_prefix, str(ROOT), cache, *SYSTEM}
    return {Path(path) for path in paths if path and os.path.exists(path)}  # noqa: PTH110 - False where it may not look


def _around(path: Path, hidden: Path) -> Iterator[Path]:
    """Yield what is below a path, without what is hidden there."""
    if path == hidden or path.is_relative_to(hidden):
        return
    if not hidden.is_relative_to(path):
        yield path
        return
    for entry in path.iterdir():
        if not entry.is_symlink():
            yield from _around(entry, hidden)


def _allow(libc: ctypes.CDLL, ruleset: int, path: Path, rights: int) -> None:
    try:
        place = os.open(path, os.O_PATH | os.O_CLOEXEC)
    except OSError:
        return
    try:
        if not path.is_dir():
            rights &= (1 << 0) | (1 << 1) | (1 << 2) | (1 << 14)  # those that a file can have
        libc.syscall(ADD_RULE, ruleset, OF_PATH, struct.pack("<Qi", rights, place), 0)
    finally:
        os.close(place)
