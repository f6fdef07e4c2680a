"""The grader's side of the pipe: starts a student's process, asks it, and ends it in time."""

from __future__ import annotations

import math
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Mapping
from contextlib import ExitStack, suppress
from dataclasses import dataclass, field
from pathlib import Path
from types import TracebackType
from typing import Any

import numpy as np

from app.features.course.sandbox import wire
from app.features.course.sandbox.child import LONGEST_WORDS, OFFERED
from app.features.course.sandbox.custody import Usage
from app.features.course.sandbox.file_clock import FileClock, compiles
from app.features.course.sandbox.limits import MEMORY
from robot.errors import BrickPoseError

if sys.platform == "win32":
    from app.features.course.sandbox.windows_custody import WindowsCustody as SystemCustody
else:
    from app.features.course.sandbox.unix_custody import UnixCustody as SystemCustody

SOURCES = str(Path(__file__).parents[4])
START = (
    f"import sys; sys.path.insert(0, {SOURCES!r}); "
    "from app.features.course.sandbox.child import main; main()"
)
START_S = 20.0
"""Time for Python and NumPy to start on a busy machine [s]."""
QUICK_S, COMPILING_S = 3.0, 15.0
"""Processor time of one call [s]; where numba is used, the first call of a function compiles it."""
PATIENCE = 10.0
"""A call may take this many times as long by the clock: the machine can be busy, or the code
asleep."""
LOOK_S = 0.25
"""Interval of looking how much processor time and memory a call has used [s]."""
MOST_CALLS = 20_000
"""Most calls of offered functions in one call."""
MOST_LINES = 1_000_000
"""No file has a line of a higher number."""
LARGEST = 10_000_000
"""Most numbers that arguments of an offered function may make together, where each meets each."""

CANNOT_USE = (TypeError, ValueError, LookupError, AttributeError, ArithmeticError, MemoryError)
"""What an offered function may raise, as the student's code chooses what it is given."""


class StudentError(BrickPoseError, RuntimeError):
    """A student's code gives no result; the message says why.

    ``line`` is the line of the file, where it is known; ``fatal`` when the process is gone;
    ``misused`` when the code called a function of the lesson with what this cannot use.
    """

    def __init__(
        self, words: str, line: int | None = None, *, fatal: bool = False, misused: bool = False
    ) -> None:
        super().__init__(words)
        self.line = line
        self.fatal = fatal
        self.misused = misused


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
    """What one call may take: time by the processor, and more patiently by the clock; memory.

    It holds for all that is said during the call, however slowly or often it is said.
    """

    def __init__(self, usage: Callable[[], Usage], seconds: float) -> None:
        self._usage = usage
        self._seconds = seconds
        self._began = self._looked = time.monotonic()
        self._used: float | None = None

    @property
    def due(self) -> bool:
        """Whether it is time to look."""
        return time.monotonic() - self._looked >= LOOK_S

    def check(self) -> None:
        """Raise a StudentError when the time is over, or too much memory is in use."""
        self._looked = time.monotonic()
        passed, usage = self._looked - self._began, self._usage()
        if self._used is None:
            # The first look comes a moment after the call began.
            self._used = max(0.0, usage.seconds - passed)
        if usage.memory > MEMORY:
            raise StudentError(f"takes more than {MEMORY >> 30} GB of memory", fatal=True)
        if usage.seconds - self._used > self._seconds or passed > PATIENCE * self._seconds:
            raise StudentError(f"does not end within {self._seconds:g} s", fatal=True)


@dataclass
class StudentProcess:
    """Runs one file; a context that ends the process.

    Raises:
        StudentError: the file has no functions, or its time is over.
    """

    path: str
    source: str
    clock: FileClock | None = None
    """The time that is left for the file; None gives it all the time of a file."""
    names: tuple[str, ...] = field(default=(), init=False)
    """What the file defines and can be called."""
    fences: tuple[str, ...] = field(default=(), init=False)
    """What holds it, in words: by the process's own account, before it has run the file."""
    broken: bool = field(default=False, init=False)
    """Whether a call had no proper end: nothing more can be asked."""

    def __enter__(self) -> StudentProcess:
        self._clock = self.clock or FileClock(self.source)
        if self._clock.over:
            raise self._late()
        self._folder = tempfile.TemporaryDirectory(prefix="lesson-")
        self._waiting = bytearray()
        # Only what Python needs is handed on: no token of the program, no folder of the user.
        environment = {"OPENBLAS_NUM_THREADS": "1", "HOME": self._folder.name, "LANG": "C.UTF-8"}
        command = [sys.executable, "-I", "-B", "-c", START]
        try:
            self._custody = SystemCustody(command, Path(self._folder.name), environment)
        except OSError:
            self._folder.cleanup()
            raise
        self._process = self._custody.popen
        self._ending = ExitStack()
        # Killing it ends whatever waits for it here, also a question that it does not read.
        self._ending.enter_context(self._clock.ending(self._custody.kill))
        try:
            self._send({"path": self.path, "source": self.source})
            limit = Limit(self._custody.usage, START_S)
            self.fences = _words(self._message(limit), "fences")
            self.names = _words(self._message(limit), "names")
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
        self._ending.close()
        self._custody.kill()
        self._custody.close()
        if self._process.stdin is not None:
            with suppress(OSError):
                self._process.stdin.close()
        self._process.wait()
        self._folder.cleanup()

    def call(
        self,
        function: str,
        arguments: tuple[Any, ...],
        seed: int | None = None,
        offered: Mapping[str, Callable[..., Any]] | None = None,
        *,
        seconds: float | None = None,
    ) -> Answer:
        """Call a function of the file.

        Args:
            function: its name.
            arguments: numbers, arrays and namespaces; ``OFFERED + name`` stands for a function.
            seed: of the generator that is the last argument; None is no generator.
            offered: functions that the student's may call, by name; they run here.
            seconds: how long it may compute [s]; None is as long as a file of its kind may.

        Raises:
            StudentError: there is no result.
        """
        self.broken = True
        self._send({"function": function, "arguments": list(arguments), "seed": seed})
        usual = COMPILING_S if compiles(self.source) else QUICK_S
        limit = Limit(self._custody.usage, seconds or usual)
        for _ in range(MOST_CALLS):
            answer = self._message(limit)
            self.broken = "call" in answer
            attempt = answer.get("attempt")
            if isinstance(attempt, str) and attempt:
                raise StudentError(f"the code {_cut(attempt)}; no lesson needs that")
            if "call" not in answer:
                return _checked(answer)
            self._send({"result": _served(answer, offered or {})})
        raise StudentError(f"calls more than {MOST_CALLS} functions", fatal=True)

    def replace(self, source: str) -> None:
        """Run another file in the same process, in place of the one before.

        Raises:
            StudentError: it has no functions.
        """
        self.broken = True
        self._send({"source": source})
        self.names = _words(self._message(Limit(self._custody.usage, QUICK_S)), "names")
        self.broken = False

    def _send(self, message: Mapping[str, Any]) -> None:
        assert self._process.stdin is not None
        try:
            self._process.stdin.write(wire.pack(message))
            self._process.stdin.flush()
        except OSError as error:
            raise StudentError(self._ended(), fatal=True) from error

    def _message(self, limit: Limit) -> dict[str, Any]:
        (length,) = wire.LENGTH.unpack(self._exactly(wire.LENGTH.size, limit))
        if length > wire.LONGEST:
            raise StudentError("gives far too much", fatal=True)
        try:
            message = wire.unpack(self._exactly(length, limit))
        except wire.WireError as error:
            raise StudentError(f"gives what is no result: {_cut(error)}", fatal=True) from error
        if message.get("error") is not None:
            self.broken = False
            raise StudentError(*_error(message["error"]))
        return message

    def _exactly(self, size: int, limit: Limit) -> bytes:
        while len(self._waiting) < size:
            part = self._custody.receive(LOOK_S)
            if part == b"":
                raise StudentError(self._ended(), fatal=True)
            self._waiting += part or b""
            if limit.due:  # also when something came: a byte at a time is no answer
                limit.check()
        result = bytes(self._waiting[:size])
        del self._waiting[:size]
        return result

    def _late(self) -> StudentError:
        return StudentError(f"takes more than {self._clock.seconds:g} s in all", fatal=True)

    def _ended(self) -> str:
        if self._clock.over:
            return str(self._late())
        with suppress(subprocess.TimeoutExpired):
            words = self._custody.how_it_ended(self._process.wait(1.0))
            if words is not None:
                return words
        return "ended Python, instead of returning a result"


def _words(message: Mapping[str, Any], key: str) -> tuple[str, ...]:
    words = message.get(key)
    if not isinstance(words, tuple):
        raise StudentError("gives what is no result", fatal=True)
    return tuple(map(str, words))


def _error(error: Any) -> tuple[str, int | None]:
    if not isinstance(error, dict):
        return "gives what is no result", None
    words, line = error.get("words"), error.get("line")
    return _cut(words), line if type(line) is int and 0 < line < MOST_LINES else None


def _cut(words: object) -> str:
    """Return words that the process gives, or forges, no longer than it may make them."""
    return str(words)[: 2 * LONGEST_WORDS]


def _checked(answer: Mapping[str, Any]) -> Answer:
    if "result" not in answer:
        raise StudentError("gives what is no result", fatal=True)
    after = answer.get("after")
    return Answer(
        answer["result"],
        after if isinstance(after, tuple) else (),
        answer.get("linked") is True,
        answer.get("shared") is True,
    )


def _served(answer: Mapping[str, Any], offered: Mapping[str, Callable[..., Any]]) -> Any:
    function = offered.get(str(answer["call"]))
    if function is None:
        raise StudentError(f"calls {_cut(answer['call'])!r}, which is not offered", fatal=True)
    try:
        arguments = tuple(answer["arguments"])
        if math.prod(max(np.size(value), 1) for value in arguments) > LARGEST:
            raise ValueError(f"more than {LARGEST} numbers")
        return function(*arguments)
    except CANNOT_USE as error:
        raise StudentError(
            f"gives {answer['call']} what it cannot use: {_cut(error)}", fatal=True, misused=True
        ) from error


__all__ = ["CANNOT_USE", "OFFERED", "Answer", "StudentError", "StudentProcess"]
