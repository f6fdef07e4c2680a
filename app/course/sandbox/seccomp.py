"""Seccomp: the kernel refuses system calls by which a process could reach beyond itself.

It needs no root; see ``seccomp(2)`` of Linux. The numbers of the calls are those of the kernel's
tables for two machines; elsewhere nothing is refused here.
"""

from __future__ import annotations

import ctypes
import os
import platform
import struct
from collections.abc import Mapping
from dataclasses import dataclass

SET_NO_NEW_PRIVS, SET_SECCOMP, FILTER = 38, 22, 2
LOAD, EQUAL, ANY_BIT, AT_LEAST, RETURN = 0x20, 0x15, 0x45, 0x35, 0x06
"""Instructions: load a word, jump if equal, if any bit is set, if not below; return."""
ALLOW, REFUSE, UNKNOWN = 0x7FFF0000, 0x00050001, 0x00050026
"""Answers: go on; EPERM; ENOSYS, at which the C library takes an older call."""
NUMBER, MACHINE, ARGUMENT = 0, 4, 16
"""Where the call's number, the machine, and its first argument lie [bytes]."""
THREAD = 0x10000
WRITING = os.O_WRONLY | os.O_RDWR | os.O_CREAT | os.O_TRUNC | os.O_APPEND

REFUSED = """
fork vfork execve execveat socket socketpair connect bind listen accept sendto sendmsg
unlink unlinkat rename renameat renameat2 rmdir mkdir mkdirat link linkat symlink symlinkat
mknod mknodat creat truncate chmod fchmod fchmodat chown fchown lchown fchownat utimensat
setxattr lsetxattr fsetxattr removexattr lremovexattr fremovexattr
ptrace process_vm_readv process_vm_writev pidfd_open pidfd_send_signal pidfd_getfd tkill
mount umount2 pivot_root chroot unshare setns bpf perf_event_open
init_module finit_module delete_module kexec_load reboot swapon swapoff settimeofday
clock_settime sethostname keyctl add_key request_key io_uring_setup userfaultfd
shmget semget msgget mq_open setrlimit prlimit64 setuid setgid setpgid setsid
""".split()  # noqa: SIM905
UNKNOWN_CALLS = ("clone3", "openat2")


@dataclass(frozen=True)
class Machine:
    """A machine's name in seccomp, and its numbers of system calls."""

    name: int
    calls: Mapping[str, int]


X86_64 = Machine(
    0xC000003E,
    {
        "open": 2, "socket": 41, "connect": 42, "accept": 43, "sendto": 44, "sendmsg": 46,
        "bind": 49, "listen": 50, "socketpair": 53, "clone": 56, "fork": 57, "vfork": 58,
        "execve": 59, "kill": 62, "semget": 64, "msgget": 68, "truncate": 76, "rename": 82,
        "mkdir": 83, "rmdir": 84, "creat": 85, "link": 86, "unlink": 87, "symlink": 88, "chmod": 90,
        "fchmod": 91, "chown": 92, "fchown": 93, "lchown": 94, "ptrace": 101, "setuid": 105,
        "setgid": 106, "setpgid": 109, "setsid": 112, "mknod": 133, "pivot_root": 155,
        "setrlimit": 160, "chroot": 161, "settimeofday": 164, "mount": 165, "umount2": 166,
        "swapon": 167, "swapoff": 168, "reboot": 169, "sethostname": 170, "init_module": 175,
        "delete_module": 176, "setxattr": 188, "lsetxattr": 189, "fsetxattr": 190,
        "removexattr": 197, "lremovexattr": 198, "fremovexattr": 199, "tkill": 200,
        "clock_settime": 227, "tgkill": 234, "mq_open": 240, "kexec_load": 246, "add_key": 248,
        "request_key": 249, "keyctl": 250, "openat": 257, "mkdirat": 258, "mknodat": 259,
        "fchownat": 260, "unlinkat": 263, "renameat": 264, "linkat": 265, "symlinkat": 266,
        "fchmodat": 268, "unshare": 272, "utimensat": 280, "perf_event_open": 298,
        "prlimit64": 302, "setns": 308, "process_vm_readv": 310, "process_vm_writev": 311,
        "finit_module": 313, "renameat2": 316, "bpf": 321, "execveat": 322, "userfaultfd": 323,
        "shmget": 29, "pidfd_send_signal": 424, "io_uring_setup": 425, "pidfd_open": 434,
        "clone3": 435, "openat2": 437, "pidfd_getfd": 438,
    },
)  # fmt: skip
AARCH64 = Machine(
    0xC00000B7,
    {
        "setxattr": 5, "lsetxattr": 6, "fsetxattr": 7, "removexattr": 14, "lremovexattr": 15,
        "fremovexattr": 16, "mknodat": 33, "mkdirat": 34, "unlinkat": 35, "symlinkat": 36,
        "linkat": 37, "renameat": 38, "umount2": 39, "mount": 40, "pivot_root": 41, "truncate": 45,
        "chroot": 51, "fchmod": 52, "fchmodat": 53, "fchownat": 54, "fchown": 55, "openat": 56,
        "utimensat": 88, "unshare": 97, "kexec_load": 104, "init_module": 105,
        "delete_module": 106, "clock_settime": 112, "ptrace": 117, "kill": 129, "tkill": 130,
        "tgkill": 131, "reboot": 142, "setgid": 144, "setuid": 146, "setpgid": 154, "setsid": 157,
        "sethostname": 161, "setrlimit": 164, "settimeofday": 170, "mq_open": 180, "msgget": 186,
        "semget": 190, "shmget": 194, "socket": 198, "socketpair": 199, "bind": 200, "listen": 201,
        "accept": 202, "connect": 203, "sendto": 206, "sendmsg": 211, "add_key": 217,
        "request_key": 218, "keyctl": 219, "clone": 220, "execve": 221, "swapon": 224,
        "swapoff": 225, "perf_event_open": 241, "prlimit64": 261, "setns": 268,
        "process_vm_readv": 270, "process_vm_writev": 271, "finit_module": 273, "renameat2": 276,
        "bpf": 280, "execveat": 281, "userfaultfd": 282, "pidfd_send_signal": 424,
        "io_uring_setup": 425, "pidfd_open": 434, "clone3": 435, "openat2": 437,
        "pidfd_getfd": 438,
    },
)  # fmt: skip
MACHINES = {"x86_64": X86_64, "aarch64": AARCH64}


def refuse_calls() -> bool:
    """Refuse this process such calls, for good; False if the kernel cannot."""
    machine = MACHINES.get(platform.machine())
    if machine is None or platform.system() != "Linux":
        return False
    libc = ctypes.CDLL(None, use_errno=True)
    if libc.prctl(SET_NO_NEW_PRIVS, 1, 0, 0, 0) != 0:
        return False
    code = _program(machine, os.getpid())
    held = ctypes.create_string_buffer(code)
    program = struct.pack("@HP", len(code) // 8, ctypes.addressof(held))
    return bool(libc.prctl(SET_SECCOMP, FILTER, program, 0, 0) == 0)


def _program(machine: Machine, pid: int) -> bytes:
    """Return the filter: each call has a few lines, and the last line allows."""
    calls = machine.calls
    lines = [_line(LOAD, MACHINE), _line(EQUAL, machine.name, 1, 0), _line(RETURN, REFUSE)]
    lines += [_line(LOAD, NUMBER), _line(AT_LEAST, 0x40000000, 0, 1), _line(RETURN, REFUSE)]
    for name in REFUSED:
        lines += _whole(calls, name, REFUSE)
    for name in UNKNOWN_CALLS:
        lines += _whole(calls, name, UNKNOWN)
    lines += _by_argument(calls, "clone", 0, [_line(ANY_BIT, THREAD, 1, 0)])
    lines += _by_argument(calls, "kill", 0, [_line(EQUAL, pid, 1, 0)])
    lines += _by_argument(calls, "tgkill", 0, [_line(EQUAL, pid, 1, 0)])
    lines += _by_argument(calls, "open", 1, [_line(ANY_BIT, WRITING, 0, 1)])
    lines += _by_argument(calls, "openat", 2, [_line(ANY_BIT, WRITING, 0, 1)])
    return b"".join([*lines, _line(RETURN, ALLOW)])


def _whole(calls: Mapping[str, int], name: str, answer: int) -> list[bytes]:
    if name not in calls:
        return []  # this machine has no such call
    return [_line(EQUAL, calls[name], 0, 1), _line(RETURN, answer)]


def _by_argument(
    calls: Mapping[str, int], name: str, argument: int, test: list[bytes]
) -> list[bytes]:
    """Return lines that ask for an argument's low word; the test jumps over the refusal."""
    if name not in calls:
        return []
    body = [_line(LOAD, ARGUMENT + 8 * argument), *test, _line(RETURN, REFUSE)]
    return [_line(EQUAL, calls[name], 0, len(body) + 1), *body, _line(RETURN, ALLOW)]


def _line(code: int, value: int, met: int = 0, otherwise: int = 0) -> bytes:
    return struct.pack("<HBBI", code, met, otherwise, value)
