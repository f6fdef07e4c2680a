"""The filter of system calls, run here as the kernel runs it, for both machines; and by it."""

from __future__ import annotations

import errno
import json
import os
import platform
import re
import struct
import subprocess
import sys
from pathlib import Path

import pytest

from app.features.course.sandbox.seccomp import ALLOW, UNKNOWN, _conditions, program
from app.features.course.sandbox.system_calls import AARCH64, MACHINES, X86_64, Architecture
from app.settings.config import ROOT

PID, OTHER = 4711, 4712
POINTER = 0x7F00_0000_0000
"""An address whose low word is nothing."""
MOST = 501
HEADERS = {
    X86_64.name: ("/usr/include/asm/unistd_64.h", "/usr/include/x86_64-linux-gnu/asm/unistd_64.h"),
    AARCH64.name: ("/usr/include/asm-generic/unistd.h",),
}


def answer(
    machine: Architecture, number: int, arguments: tuple[int, ...] = (), name: int = 0
) -> int:
    """What the filter of a process says to a call."""
    words = [*arguments, 0, 0, 0, 0, 0, 0][:6]
    call = struct.pack("<IIQ6Q", number, name or machine.name, 0, *words)
    code = program(machine, PID)
    place, held = 0, 0
    while True:
        instruction, met, otherwise, value = struct.unpack_from("<HBBI", code, 8 * place)
        place += 1
        if instruction == 0x20:
            (held,) = struct.unpack_from("<I", call, value)
        elif instruction == 0x15:
            place += met if held == value else otherwise
        elif instruction == 0x45:
            place += met if held & value else otherwise
        else:
            assert instruction == 0x06
            return value


def allows(machine: Architecture, call: str, *arguments: int) -> bool:
    return answer(machine, machine.calls[call], arguments) == ALLOW


THREAD = 0x3D0F00
"""Flags of ``clone`` by which glibc starts a thread."""
CONDITIONS = {
    "open": ((0, os.O_RDONLY | os.O_CLOEXEC), [(0, os.O_WRONLY), (0, os.O_RDWR), (0, os.O_TRUNC)]),
    "openat": ((0, 0, os.O_CLOEXEC), [(0, 0, os.O_WRONLY), (0, 0, os.O_CREAT), (0, 0, os.O_APPEND),
                                      (0, 0, 0o20200002)]),
    "kill": ((PID, 6), [(OTHER, 9), (0, 9), (2**32 - 1, 9), (2**64 - 1, 9), (2**32 - PID, 9)]),
    "tgkill": ((PID, OTHER, 6), [(OTHER, OTHER, 6), (0, PID, 6)]),
    "sched_getaffinity": ((0,), [(OTHER,), (1,)]),
    "prlimit64": ((0, 7, 0, POINTER),
                  [(OTHER, 7, 0, POINTER), (0, 7, POINTER, 0), (PID, 7, 1, 0)]),
    "clone": ((THREAD,), [(17,), (0x4111,), (THREAD & ~0x10000,), (THREAD | 0x10000000,),
                          (THREAD | 0x40000000,), (THREAD | 0x1000,), (0,)]),
    "clock_gettime": ((3,), [((~OTHER << 3 | 2) & 0xFFFFFFFF,)]),
    "clock_getres": ((1,), [((~OTHER << 3 | 2) & 0xFFFFFFFFFFFFFFFF,)]),
    "clock_nanosleep": ((1,), [((~OTHER << 3 | 2) & 0xFFFFFFFF,)]),
    "futex": ((0, 128), [(0, 6), (0, 6 | 128), (0, 13), (0, 2), (0, 12 | 128)]),
    "fcntl": ((0, 1030), [(1, 8, OTHER), (1, 15, 0), (1, 10, 9), (1, 1024, 1), (1, 6), (1, 1026)]),
    "ioctl": ((0, 0x5401), [(0, 0x5412), (0, 0x8901), (0, 0x5410), (0, 0x5452)]),
    "prctl": ((15,), [(1, 0), (0x59616D61, OTHER), (62, 0, OTHER), (35,), (47,), (22,)]),
}  # fmt: skip
"""Of each call that is asked for its arguments: one call that is allowed, and some that are not."""


@pytest.mark.parametrize("machine", [X86_64, AARCH64], ids=["x86_64", "aarch64"])
def test_every_number_is_allowed_by_name_or_not_there(machine: Architecture) -> None:
    by_number = {number: name for name, number in machine.calls.items()}
    assert len(by_number) == len(machine.calls)
    for number in range(MOST):
        name = by_number.get(number)
        allowed, refused = CONDITIONS.get(name, ((), []))
        assert answer(machine, number, allowed) == (UNKNOWN if name is None else ALLOW), name
        for arguments in refused:
            assert answer(machine, number, arguments) == UNKNOWN, (name, arguments)
    for number in (2**30, 2**31, 2**32 - 1, 2**30 + machine.calls["read"]):  # x32 and nonsense
        assert answer(machine, number) == UNKNOWN


@pytest.mark.parametrize("machine", [X86_64, AARCH64], ids=["x86_64", "aarch64"])
def test_a_call_by_another_machines_table_is_not_there(machine: Architecture) -> None:
    for name in (0x40000003, 0x40000028, (X86_64 if machine is AARCH64 else AARCH64).name):
        assert answer(machine, machine.calls["read"], name=name) == UNKNOWN


def test_each_condition_is_tried() -> None:
    assert CONDITIONS.keys() == _conditions(PID).keys()


def test_both_machines_allow_the_same_but_for_older_calls() -> None:
    older = {"dup2", "open", "stat", "lstat", "access", "readlink", "time", "poll", "select"}
    assert X86_64.calls.keys() - AARCH64.calls.keys() == older
    assert AARCH64.calls.keys() <= X86_64.calls.keys()


@pytest.mark.parametrize("machine", [X86_64, AARCH64], ids=["x86_64", "aarch64"])
def test_no_call_that_reaches_beyond_the_process_is_in_the_table(machine: Architecture) -> None:
    reaching = re.compile(
        r"sig(queue|timed)|sigqueue|pidfd|tkill$|ptrace|process_|kcmp|io_|key|setpriority|setrlimit"
        r"|ch(mod|own|root|dir)|utime|link(at)?$|rename|mk(dir|nod)|trunc|creat|xattr|exec|fork|wait"
        r"|sock|connect|bind|listen|accept|send|recv|shm|sem|msg|mq_|mount|set.*id$|setns|unshare"
        r"|memfd|bpf|perf|userfault|landlock|seccomp|module|kexec|reboot|swap|write64|pwrite|splice"
    )
    left = {name for name in machine.calls if reaching.search(name)}
    assert left <= {"readlink", "readlinkat", "tgkill"}


@pytest.mark.parametrize("machine", [X86_64, AARCH64], ids=["x86_64", "aarch64"])
def test_the_numbers_are_those_of_the_kernels_headers(machine: Architecture) -> None:
    found = [Path(name) for name in HEADERS[machine.name] if Path(name).is_file()]
    if not found:
        pytest.skip("the kernel's headers are not installed")
    text = found[0].read_text(encoding="utf-8")
    lines = re.findall(r"#define __NR(?:3264)?_(\w+)\s+(\d+)", text)
    numbers = {name: int(number) for name, number in lines}
    renamed = {"newfstatat": "fstatat"} if machine is AARCH64 else {}
    for name, number in machine.calls.items():
        assert numbers[renamed.get(name, name)] == number, name


PROBES = (335, 336)
"""``uretprobe`` and ``uprobe``: the kernel asks no filter, and ends who calls them by hand."""
PROBE = """
import ctypes, json, os, sys
from app.features.course.sandbox.seccomp import refuse_calls
from app.features.course.sandbox.system_calls import MACHINES
calls = MACHINES[os.uname().machine].calls
libc = ctypes.CDLL(None, use_errno=True)
libc.prctl(1, 9, 0, 0, 0)
assert refuse_calls()
assert libc.getsid(0) == -1  # the filter holds: now all others can be tried
said = dict()
for number in range(501):
    if number not in (*calls.values(), *{probes}):
        ctypes.set_errno(0)
        said[number] = (libc.syscall(number, 0, 0, 0, 0, 0, 0), ctypes.get_errno())
print(json.dumps(said))
"""


@pytest.mark.skipif(platform.machine() not in MACHINES, reason="there is no table")
@pytest.mark.skipif(sys.platform != "linux", reason="Linux's kernel")
def test_the_kernel_answers_every_other_number_as_one_that_it_does_not_have() -> None:
    command = [sys.executable, "-c", PROBE.format(probes=PROBES)]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, timeout=60, check=True)
    said = json.loads(done.stdout)
    assert len(said) == MOST - len(MACHINES[platform.machine()].calls) - len(PROBES)
    assert set(map(tuple, said.values())) == {(-1, errno.ENOSYS)}
