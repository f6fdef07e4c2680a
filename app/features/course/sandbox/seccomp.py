"""Seccomp: the kernel knows only such system calls as computing needs; no other is there.

It needs no root; see ``seccomp(2)`` of Linux. What is not allowed is answered as if the kernel did
not have it (ENOSYS), at which libraries take an older call or do without. Where an argument could
name another process or change a file, it is looked at. On machines without a table nothing is
refused here. Bubblewrap would start the process elsewhere, but it takes this same filter from who
calls it, needs user namespaces, which many systems deny, and knows no Landlock.
"""

from __future__ import annotations

import ctypes
import os
import platform
import struct
import sys
from collections.abc import Iterable, Sequence

from app.features.course.sandbox.system_calls import MACHINES, Architecture

SET_NO_NEW_PRIVS, SET_SECCOMP, FILTER = 38, 22, 2
LOAD, EQUAL, ANY_BIT, RETURN = 0x20, 0x15, 0x45, 0x06
"""Instructions: load a word, jump if equal, jump if any bit is set, return."""
ALLOW, UNKNOWN = 0x7FFF0000, 0x00050026
"""Answers: go on; ENOSYS."""
NUMBER, MACHINE, ARGUMENTS = 0, 4, 16
"""Where the call's number, the machine, and the first of six arguments lie [bytes]."""

WRITING = os.O_WRONLY | os.O_RDWR | os.O_CREAT | os.O_TRUNC | os.O_APPEND
THREAD = 0x10000
THREADS_FLAGS = 0x017D0F00
"""What C libraries ask for with a thread: it shares memory, files and signals; no namespaces."""
ANOTHERS_CLOCK = 0x80000000
"""A clock's number with this bit is made of a process's."""
DESCRIPTOR_COMMANDS = (0, 1, 2, 3, 4, 1030)
"""Of ``fcntl``: duplicating and flags; others would send signals to an owner, or lock files."""
TERMINAL_COMMANDS = (0x5401, 0x5413, 0x5450, 0x5451)
"""Of ``ioctl``: is it a terminal, its size, and keeping a descriptor from other programs."""
THREADS_NAME = (15, 16)
"""Of ``prctl``: the name of the thread, set and read."""
FUTEX_COMMANDS = tuple(
    command | flags for command in (0, 1, 3, 4, 5, 9, 10) for flags in (0, 128, 256, 384)
)
"""Waiting and waking; those that lend priority to an owner would name it."""


def refuse_calls() -> bool:
    """Refuse this process all other calls, for good; False if the kernel cannot."""
    machine = MACHINES.get(platform.machine())
    if machine is None or sys.platform != "linux":
        return False
    libc = ctypes.CDLL(None, use_errno=True)
    if libc.prctl(SET_NO_NEW_PRIVS, 1, 0, 0, 0) != 0:
        return False
    code = program(machine, os.getpid())
    held = ctypes.create_string_buffer(code)
    packed = struct.pack("@HP", len(code) // 8, ctypes.addressof(held))
    return bool(libc.prctl(SET_SECCOMP, FILTER, packed, 0, 0) == 0)


def program(machine: Architecture, pid: int) -> bytes:
    """Return the filter for a process: each call has a few lines, and the last line refuses."""
    conditions = _conditions(pid)
    lines = [_line(LOAD, MACHINE), _line(EQUAL, machine.name, 1, 0), _line(RETURN, UNKNOWN)]
    for name, number in machine.calls.items():
        body = [*conditions.get(name, ()), _line(RETURN, ALLOW)]
        lines += [_line(LOAD, NUMBER), _line(EQUAL, number, 0, len(body)), *body]
    return b"".join([*lines, _line(RETURN, UNKNOWN)])


def _conditions(pid: int) -> dict[str, list[bytes]]:
    """Return what is asked of the arguments of some calls: lines that refuse, or go on."""
    itself = (0, pid)
    no_new_limit = [*_one_of(2, (0,)), *_one_of(2, (0,), high=True)]
    return {
        "open": _no_bit_of(1, WRITING),
        "openat": _no_bit_of(2, WRITING),
        "kill": _one_of(0, (pid,)),
        "tgkill": _one_of(0, (pid,)),
        "sched_getaffinity": _one_of(0, itself),
        "prlimit64": [*_one_of(0, itself), *no_new_limit],
        "clone": [*_some_bit_of(0, THREAD), *_no_bit_of(0, ~THREADS_FLAGS & 0xFFFFFFFF)],
        "clock_gettime": _no_bit_of(0, ANOTHERS_CLOCK),
        "clock_getres": _no_bit_of(0, ANOTHERS_CLOCK),
        "clock_nanosleep": _no_bit_of(0, ANOTHERS_CLOCK),
        "futex": _one_of(1, FUTEX_COMMANDS),
        "fcntl": _one_of(1, DESCRIPTOR_COMMANDS),
        "ioctl": _one_of(1, TERMINAL_COMMANDS),
        "prctl": _one_of(0, THREADS_NAME),
    }


def _one_of(argument: int, values: Sequence[int], *, high: bool = False) -> list[bytes]:
    """Refuse unless an argument's low word, or its high one, is one of some values."""
    left = range(len(values), 0, -1)
    tests = (_line(EQUAL, value, skip, 0) for value, skip in zip(values, left, strict=True))
    return _test(argument, tests, high=high)


def _no_bit_of(argument: int, bits: int) -> list[bytes]:
    return _test(argument, [_line(ANY_BIT, bits, 0, 1)])


def _some_bit_of(argument: int, bits: int) -> list[bytes]:
    return _test(argument, [_line(ANY_BIT, bits, 1, 0)])


def _test(argument: int, tests: Iterable[bytes], *, high: bool = False) -> list[bytes]:
    """Return lines that load a word, jump over the refusal, or fall into it."""
    word = ARGUMENTS + 8 * argument + 4 * high  # both machines have the low word first
    return [_line(LOAD, word), *tests, _line(RETURN, UNKNOWN)]


def _line(code: int, value: int, met: int = 0, otherwise: int = 0) -> bytes:
    return struct.pack("<HBBI", code, met, otherwise, value)
