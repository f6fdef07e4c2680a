"""The grader's side of the pipe: starts a student's process, asks it, and ends it in time."""

from __future__ import annotations

import os
import selectors
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from types import TracebackType
from typing import Any

from app.course.sandbox import wire
from app.course.sandbox.child import OFFERED
from robot.errors import BrickPoseError

SOURCES = str(Path(__file__).parents[3])
START = (
    f"import sys; sys.path.insert(0, {SOURCES!r}); "
    "from app.course.sandbox.child import main; main()"
)
START_S = 20.0
"""Time for Python and NumPy to start on a busy machine [s]."""
QUICK_S, COMPILING_S = 3.0, 15.0
"""Processor time of one call [s]; where numba is used, the first call of a function compiles it."""
PATIENCE = 10.0
"""A call may take this many times as long by the clock: the machine can be busy, or the code
asleep."""
LOOK_S = 0.25
"""Interval of looking how much processor time a call has used [s]."""
MOST_CALLS = 20_000
"""Most calls of offered functions in one call."""

CANNOT_USE = (TypeError, ValueError, LookupError, AttributeError, ArithmeticError, MemoryError)
"""What an offered function may raise, as the student's code chooses what it is given."""


class StudentError(BrickPoseError, RuntimeError):
    """A student's code gives no result; the message says why.

    ``line`` is the line of the file, where it is known; ``fatal`` when the process is gone.
    """

    def __init__(self, words: str, line: int | None = None, *, fatal: bool = False) -> None:
        super().__init__(words)
        self.line = line
        self.fatal = fatal


@dataclass(frozen=True, eq=False)
class Answer:
    """What a function returned, and what it did to what it was given."""

    result: Any
    after: tuple[Any, ...] = ()
    """The arrays and namespaces among the arguments, after the call."""
    linked: bool = False
    """Whether two rows of the result are the same memory."""
    shared: bool = False
    """Whether the result shares memory with an argument."""


class Limit:
    """The time of one call: by the processor, and more patiently by the clock."""

    def __init__(self, pid: int, seconds: float) -> None:
        self._pid = pid
        self._seconds = seconds
        self._began = time.monotonic()
        self._used: float | None = None

    def check(self) -> None:
        """Raise a StudentError when the time is over."""
        passed, used = time.monotonic() - self._began, processor_seconds(self._pid)
        if self._used is None:
            # The first look comes a moment after the call began.
            self._used = max(0.0, used - passed)
        if used - self._used > self._seconds or passed > PATIENCE * self._seconds:
            raise StudentError(f"does not end within {self._seconds:g} s", fatal=True)


def processor_seconds(pid: int) -> float:
    """Return how much processor time a process has used [s]; by the clock where it is not told."""
    try:
        fields = Path(f"/proc/{pid}/stat").read_text(encoding="utf-8").rpartition(")")[2].split()
    except OSError:
        return time.monotonic()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


@dataclass
class StudentProcess:
    """Runs one file; a context that ends the process."""

    path: str
    source: str
    names: tuple[str, ...] = field(default=(), init=False)
    """What the file defines and can be called."""
    broken: bool = field(default=False, init=False)
    """Whether a call had no proper end: nothing more can be asked."""

    def __enter__(self) -> StudentProcess:
        self._folder = tempfile.TemporaryDirectory(prefix="lesson-")
        self._waiting = bytearray()
        # Only what Python needs is handed on: no token of the program, no folder of the user.
        environment = {"OPENBLAS_NUM_THREADS": "1", "HOME": self._folder.name, "LANG": "C.UTF-8"}
        self._process = subprocess.Popen(
            [sys.executable, "-I", "-B", "-c", START],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            cwd=self._folder.name,
            env=environment,
            start_new_session=True,
        )
        self._selector = selectors.DefaultSelector()
        assert self._process.stdout is not None
        self._selector.register(self._process.stdout, selectors.EVENT_READ)
        try:
            self._send({"path": self.path, "source": self.source})
            self.names = _names(self._message(START_S))
        except BaseException:
            self.__exit__(None, None, None)
            raise
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        with suppress(OSError):
            os.killpg(self._process.pid, signal.SIGKILL)
        self._process.kill()
        self._selector.close()
        for stream in (self._process.stdin, self._process.stdout):
            if stream is not None:
                with suppress(OSError):
                    stream.close()
        self._process.wait()
        self._folder.cleanup()

    def call(
        self,
        function: str,
        arguments: tuple[Any, ...],
        seed: int | None = None,
        offered: Mapping[str, Callable[..., Any]] | None = None,
    ) -> Answer:
        """Call a function of the file.

        Args:
            function: its name.
            arguments: numbers, arrays and namespaces; ``OFFERED + name`` stands for a function.
            seed: of the generator that is the last argument; None is no generator.
            offered: functions that the student's may call, by name; they run here.

        Raises:
            StudentError: there is no result.
        """
        self.broken = True
        self._send({"function": function, "arguments": list(arguments), "seed": seed})
        for _ in range(MOST_CALLS):
            answer = self._message(COMPILING_S if "numba" in self.source else QUICK_S)
            self.broken = "call" in answer
            if answer.get("attempt"):
                raise StudentError(f"the code {answer['attempt']}; no lesson needs that")
            if "call" not in answer:
                return _checked(answer)
            self._send({"result": _served(answer, offered or {})})
        raise StudentError(f"calls more than {MOST_CALLS} functions", fatal=True)

    def _send(self, message: Mapping[str, Any]) -> None:
        assert self._process.stdin is not None
        try:
            self._process.stdin.write(wire.pack(message))
            self._process.stdin.flush()
        except OSError as error:
            raise StudentError(self._ended(), fatal=True) from error

    def _message(self, seconds: float) -> dict[str, Any]:
        limit = Limit(self._process.pid, seconds)
        (length,) = wire.LENGTH.unpack(self._exactly(wire.LENGTH.size, limit))
        if length > wire.LONGEST:
            raise StudentError("gives far too much", fatal=True)
        try:
            message = wire.unpack(self._exactly(length, limit))
        except wire.WireError as error:
            raise StudentError(f"gives what is no result: {error}", fatal=True) from error
        if message.get("error") is not None:
            self.broken = False
            raise StudentError(*_error(message["error"]))
        return message

    def _exactly(self, size: int, limit: Limit) -> bytes:
        assert self._process.stdout is not None
        while len(self._waiting) < size:
            if not self._selector.select(LOOK_S):
                limit.check()
                continue
            part = os.read(self._process.stdout.fileno(), 1 << 20)
            if not part:
                raise StudentError(self._ended(), fatal=True)
            self._waiting += part
        result = bytes(self._waiting[:size])
        del self._waiting[:size]
        return result

    def _ended(self) -> str:
        with suppress(subprocess.TimeoutExpired, ValueError):  # some signals have no name
            code = self._process.wait(1.0)
            if code < 0:
                return f"crashed: {signal.Signals(-code).name}"
        return "ended Python, instead of returning a result"


def _names(message: Mapping[str, Any]) -> tuple[str, ...]:
    names = message.get("names")
    if not isinstance(names, tuple):
        raise StudentError("gives what is no result", fatal=True)
    return tuple(map(str, names))


def _error(error: Any) -> tuple[str, int | None]:
    if not isinstance(error, dict):
        return "gives what is no result", None
    words, line = error.get("words"), error.get("line")
    return str(words), line if isinstance(line, int) else None


def _checked(answer: Mapping[str, Any]) -> Answer:
    if "result" not in answer:
        raise StudentError("gives what is no result", fatal=True)
    after = answer.get("after")
    return Answer(
        answer["result"],
        after if isinstance(after, tuple) else (),
        bool(answer.get("linked")),
        bool(answer.get("shared")),
    )


def _served(answer: Mapping[str, Any], offered: Mapping[str, Callable[..., Any]]) -> Any:
    function = offered.get(str(answer["call"]))
    if function is None:
        raise StudentError(f"calls {answer['call']!r}, which is not offered", fatal=True)
    try:
        return function(*answer["arguments"])
    except CANNOT_USE as error:
        raise StudentError(
            f"gives {answer['call']} what it cannot use: {error}", fatal=True
        ) from error


__all__ = ["OFFERED", "Answer", "StudentError", "StudentProcess"]
