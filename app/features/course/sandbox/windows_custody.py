"""A student's process on Windows: alone in a job, which limits it and ends with the grader.

Jobs need no rights. See "Job Objects" of Microsoft's documentation; the structures are those of
``winnt.h``. The job's handle is only here, so that the process cannot change its own limits.
"""

from __future__ import annotations

import ctypes
import os
import queue
import subprocess
import sys
import threading
from collections.abc import Mapping, Sequence
from contextlib import suppress
from ctypes import c_int32, c_int64, c_size_t, c_uint32, c_uint64, c_void_p
from pathlib import Path
from typing import IO, Any

from app.features.course.sandbox.custody import Usage
from app.features.course.sandbox.limits import CPU_S, MEMORY
from app.operating_system import windows_kernel
from robot.errors import BrickPoseError

DETACHED = 0x8
"""A new process without a terminal: no Ctrl-C reaches it."""
NEEDED = ("SYSTEMROOT",)
"""Variables without which Python does not start."""

TICK = 1e-7
"""Unit of the job's times [s]."""
ACCOUNTING, UI_LIMITS, LIMITS = 1, 4, 9
"""Classes of information about a job."""
PROCESS_TIME, ACTIVE_PROCESSES, DIE_ON_ERROR, PROCESS_MEMORY, KILL_ON_CLOSE = (
    0x2, 0x8, 0x400, 0x100, 0x2000,
)  # fmt: skip
NO_DESKTOP = 0xFF
"""No clipboard, no windows of others, no shutdown, no settings of the system."""
SET_QUOTA_AND_TERMINATE = 0x101
"""Rights on a process that is put into a job."""
CHUNK = 1 << 20
"""Most bytes in one part of what a process says."""
MOST_PARTS = 16
"""Most parts that wait to be read; then the process waits."""
CRASHES = 0xC0000000
"""Exit codes from here on are Windows' own, as 0xC0000005 for an access violation."""


class BasicLimits(ctypes.Structure):
    """``JOBOBJECT_BASIC_LIMIT_INFORMATION``."""

    _fields_ = (
        ("PerProcessUserTimeLimit", c_int64), ("PerJobUserTimeLimit", c_int64),
        ("LimitFlags", c_uint32), ("MinimumWorkingSetSize", c_size_t),
        ("MaximumWorkingSetSize", c_size_t), ("ActiveProcessLimit", c_uint32),
        ("Affinity", c_size_t), ("PriorityClass", c_uint32), ("SchedulingClass", c_uint32),
    )  # fmt: skip


class ExtendedLimits(ctypes.Structure):
    """``JOBOBJECT_EXTENDED_LIMIT_INFORMATION``; the six counters are of input and output."""

    _fields_ = (
        ("Basic", BasicLimits), ("IoInfo", c_uint64 * 6), ("ProcessMemoryLimit", c_size_t),
        ("JobMemoryLimit", c_size_t), ("PeakProcessMemoryUsed", c_size_t),
        ("PeakJobMemoryUsed", c_size_t),
    )  # fmt: skip


class Accounting(ctypes.Structure):
    """``JOBOBJECT_BASIC_ACCOUNTING_INFORMATION``."""

    _fields_ = (
        ("TotalUserTime", c_int64), ("TotalKernelTime", c_int64),
        ("ThisPeriodTotalUserTime", c_int64), ("ThisPeriodTotalKernelTime", c_int64),
        ("TotalPageFaultCount", c_uint32), ("TotalProcesses", c_uint32),
        ("ActiveProcesses", c_uint32), ("TotalTerminatedProcesses", c_uint32),
    )  # fmt: skip


class JobError(BrickPoseError, OSError):
    """Windows refuses a job or one of its limits: nothing is run without."""


class WindowsJob:
    """Processes that Windows limits together, and ends when the job is closed."""

    def __init__(self, memory: int, cpu_s: float) -> None:
        """Make a job for one process.

        Args:
            memory: most memory of the process [bytes].
            cpu_s: most processor time of the process [s].

        Raises:
            JobError: Windows refuses it.
        """
        self._kernel = _prepared(windows_kernel())
        self._handle: int | None = _checked(self._kernel.CreateJobObjectW(None, None))
        limits = ExtendedLimits()
        limits.Basic.LimitFlags = (
            PROCESS_TIME | ACTIVE_PROCESSES | DIE_ON_ERROR | PROCESS_MEMORY | KILL_ON_CLOSE
        )
        limits.Basic.PerProcessUserTimeLimit = int(cpu_s / TICK)
        limits.Basic.ActiveProcessLimit = 1
        limits.ProcessMemoryLimit = memory
        try:
            self._set(LIMITS, limits)
            self._set(UI_LIMITS, c_uint32(NO_DESKTOP))
        except JobError:
            self.close()
            raise

    def take(self, pid: int) -> None:
        """Put a process into the job, for good.

        Raises:
            JobError: Windows refuses it.
        """
        process = _checked(self._kernel.OpenProcess(SET_QUOTA_AND_TERMINATE, 0, pid))
        try:
            _checked(self._kernel.AssignProcessToJobObject(self._handle, process))
        finally:
            self._kernel.CloseHandle(process)

    def seconds(self) -> float:
        """Return how much processor time was used [s].

        Raises:
            JobError: Windows does not tell.
        """
        accounting = Accounting()
        _checked(
            self._kernel.QueryInformationJobObject(
                self._handle, ACCOUNTING, ctypes.byref(accounting), ctypes.sizeof(accounting), None
            )
        )
        return float((accounting.TotalUserTime + accounting.TotalKernelTime) * TICK)

    def close(self) -> None:
        """End all processes of the job; may be called twice."""
        handle, self._handle = self._handle, None
        if handle is not None:
            self._kernel.CloseHandle(handle)

    def _set(self, kind: int, value: Any) -> None:
        size = ctypes.sizeof(value)
        done = self._kernel.SetInformationJobObject(self._handle, kind, ctypes.byref(value), size)
        _checked(done)


class Incoming:
    """What comes from a pipe; a thread reads it, as Windows waits for a time at sockets only."""

    def __init__(self, pipe: IO[bytes]) -> None:
        """Begin to read."""
        self._pipe = pipe
        self._parts: queue.Queue[bytes] = queue.Queue(MOST_PARTS)
        self._thread = threading.Thread(target=self._read, name="student", daemon=True)
        self._thread.start()

    def next(self, seconds: float) -> bytes | None:
        """Return what came next; None if nothing came in time [s], empty at the end."""
        try:
            return self._parts.get(timeout=seconds)
        except queue.Empty:
            return None

    def close(self) -> None:
        """Close the pipe, whose other end is closed already; may be called twice."""
        while self._thread.is_alive():
            with suppress(queue.Empty):
                self._parts.get(timeout=0.01)
        with suppress(OSError):
            self._pipe.close()

    def _read(self) -> None:
        part = b" "
        while part:
            try:
                part = os.read(self._pipe.fileno(), CHUNK)
            except OSError:
                part = b""
            self._parts.put(part)


class WindowsCustody:
    """A process in a job of its own; what it runs comes by its pipe, after it is in there."""

    def __init__(
        self, command: Sequence[str], folder: Path, environment: Mapping[str, str]
    ) -> None:
        """Start it.

        Raises:
            JobError: Windows does not limit it.
        """
        self._job = WindowsJob(MEMORY, CPU_S)
        given = {name: os.environ[name] for name in NEEDED if name in os.environ}
        places = dict.fromkeys(("USERPROFILE", "TEMP", "TMP"), str(folder))
        launched, more = _without_launcher(command)
        try:
            self.popen = subprocess.Popen(
                launched,
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=subprocess.DEVNULL,
                cwd=folder,
                env={**given, **places, **environment, **more},
                creationflags=DETACHED,
            )
        except OSError:
            self._job.close()
            raise
        try:
            self._job.take(self.popen.pid)
        except JobError:
            self.kill()
            raise
        assert self.popen.stdout is not None
        self._said = Incoming(self.popen.stdout)

    def receive(self, seconds: float) -> bytes | None:
        """Return what it says next; None if nothing comes in time [s], empty when it has ended."""
        return self._said.next(seconds)

    def usage(self) -> Usage:
        """Return what it has used so far; the job limits its memory."""
        return Usage(self._job.seconds())

    def kill(self) -> None:
        """End it at once, and all that it started; it may have ended already."""
        self._job.close()
        self.popen.kill()

    def close(self) -> None:
        """Close the pipe of a process that has been killed."""
        self._said.close()

    def how_it_ended(self, code: int) -> str | None:
        """Return why a process ended with an exit code, if the system ended it."""
        return f"crashed: 0x{code:08X}" if code >= CRASHES else None


def _without_launcher(command: Sequence[str]) -> tuple[list[str], dict[str, str]]:
    """Return a command, and variables, that start Python itself.

    In a virtual environment ``python.exe`` only starts the real one, which would be a second
    process, and outside the job. So does ``multiprocessing``.
    """
    executable, *rest = command
    real = str(getattr(sys, "_base_executable", executable))
    if real == executable:
        return [executable, *rest], {}
    return [real, *rest], {"__PYVENV_LAUNCHER__": executable}


def _prepared(kernel: Any) -> Any:
    """Return the library with the types of what is called: handles are pointers."""
    kernel.CreateJobObjectW.restype = c_void_p
    kernel.CreateJobObjectW.argtypes = (c_void_p, c_void_p)
    kernel.OpenProcess.restype = c_void_p
    kernel.OpenProcess.argtypes = (c_uint32, c_int32, c_uint32)
    kernel.AssignProcessToJobObject.argtypes = (c_void_p, c_void_p)
    kernel.SetInformationJobObject.argtypes = (c_void_p, c_int32, c_void_p, c_uint32)
    kernel.QueryInformationJobObject.argtypes = (c_void_p, c_int32, c_void_p, c_uint32, c_void_p)
    kernel.CloseHandle.argtypes = (c_void_p,)
    return kernel


def _checked(result: int | None) -> int:
    """Return what Windows answered, unless it refused.

    Raises:
        JobError: it did.
    """
    if not result:
        code = vars(ctypes)["get_last_error"]()
        raise JobError(f"Windows does not limit a student's process (error {code})")
    return int(result)
