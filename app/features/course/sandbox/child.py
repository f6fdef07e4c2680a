"""The student's side of the pipe: runs the file, then one function after another, as asked.

What fences the process is told first. The parent asks ``{"function", "arguments", "seed"}``; the
answer is ``{"result", "after", "linked", "shared"}`` or ``{"error"}``. ``{"source"}`` is another
file, which takes the place of the first. A function that is offered
to the student's is asked of the parent by ``{"call", "arguments"}``, before the answer.
"""

from __future__ import annotations

import contextlib
import linecache
import os
import sys
from collections.abc import Callable, Mapping
from types import ModuleType, SimpleNamespace
from typing import Any

import numpy as np

from app.features.course.sandbox import wire
from app.features.course.sandbox.confinement import STUDENT, confine

LONGEST_WORDS = 300
"""Longer error messages are cut [characters]."""
KEPT = (np.ndarray, SimpleNamespace)
"""Arguments that a function could change."""
SUPPLY = "supply"
"""The name by which a namespace holds rows that a function shall give, one after the other: it is
asked here, and not of the parent, as a loop may ask it thousands of times."""
OFFERED = "function "
"""How the parent marks a function among the arguments."""


class Pipe:
    """Messages to and from the grader."""

    def __init__(self) -> None:
        """Take over the standard streams: what the student prints goes nowhere."""
        self._read, self._write = os.dup(0), os.dup(1)
        nothing = os.open(os.devnull, os.O_RDWR)
        for stream in (0, 1, 2):
            os.dup2(nothing, stream)

    def receive(self) -> dict[str, Any]:
        """Wait for a message."""
        (length,) = wire.LENGTH.unpack(self._exactly(wire.LENGTH.size))
        return wire.unpack(self._exactly(length))

    def send(self, **message: Any) -> None:
        """Send a message."""
        data = wire.pack(message)
        while data:
            data = data[os.write(self._write, data) :]

    def _exactly(self, size: int) -> bytes:
        parts = b""
        while len(parts) < size:
            part = os.read(self._read, size - len(parts))
            if not part:
                os._exit(0)  # the grader has ended
            parts += part
        return parts


def main() -> None:
    """Run the file that comes first, then answer until the grader ends."""
    pipe = Pipe()
    first = pipe.receive()
    watch, fences = confine()
    pipe.send(fences=fences)
    module = ModuleType(STUDENT)
    sys.modules[STUDENT] = module
    pipe.send(**_guarded(lambda: _run_file(first["path"], first["source"], module), first["path"]))
    while True:
        request = pipe.receive()
        if "source" in request:
            following = ModuleType(STUDENT)
            sys.modules[STUDENT] = module = following
            work = lambda: _run_file(first["path"], request["source"], following)  # noqa: B023,E731
            pipe.send(**_guarded(work, first["path"]))
            continue
        answer = _guarded(lambda: _call(module, request, pipe), first["path"])  # noqa: B023
        pipe.send(attempt=watch.attempt, **answer)


def _run_file(path: str, source: str, module: ModuleType) -> dict[str, Any]:
    linecache.cache[path] = (len(source), None, source.splitlines(keepends=True), path)
    exec(compile(source, path, "exec"), module.__dict__)
    return {"names": [name for name, value in vars(module).items() if callable(value)]}


def _guarded(work: Callable[[], dict[str, Any]], path: str) -> dict[str, Any]:
    """Return what work answers, or its error in words; the student's exceptions may be hostile."""
    try:
        return work()
    except BaseException as error:
        return {"error": {"words": _words(error), "line": _line(error, path)}}


def _words(error: BaseException) -> str:
    with contextlib.suppress(BaseException):
        name = str(type.__getattribute__(type(error), "__name__"))[:LONGEST_WORDS]
        with contextlib.suppress(BaseException):
            text = " ".join(str.__str__(str(error)).split())
            return f"{name}: {text[:LONGEST_WORDS]}" if text else name
        return name
    return "an exception that cannot be shown"


def _line(error: BaseException, path: str) -> int | None:
    with contextlib.suppress(BaseException):
        if isinstance(error, SyntaxError):
            return error.lineno
        trace, line = error.__traceback__, None
        while trace is not None:
            if trace.tb_frame.f_code.co_filename == path:
                line = trace.tb_lineno
            trace = trace.tb_next
        return line
    return None


def _call(module: ModuleType, request: Mapping[str, Any], pipe: Pipe) -> dict[str, Any]:
    arguments = [_offered(value, pipe) for value in request["arguments"]]
    if request["seed"] is not None:
        arguments.append(np.random.default_rng(request["seed"]))
    given = getattr(module, request["function"])(*arguments)
    arrays = [value for value in arguments if isinstance(value, np.ndarray)]
    return {
        "result": _plain(given),
        "after": [_state(value) for value in arguments if isinstance(value, KEPT)],
        "linked": _linked(given),
        "shared": any(_shares(part, value) for part in _parts(given) for value in arrays),
    }


def _state(value: Any) -> Any:
    if isinstance(value, np.ndarray):
        return value
    numbers = (int, float, np.number, np.ndarray)
    return SimpleNamespace(**{k: v for k, v in vars(value).items() if isinstance(v, numbers)})


def _supply(rows: np.ndarray[Any, Any]) -> Callable[[int], np.ndarray[Any, Any]]:
    """Return a function that gives the next rows of an array, and begins again at its end."""
    given = 0

    def take(count: int) -> np.ndarray[Any, Any]:
        nonlocal given
        places = np.arange(given, given + int(count)) % len(rows)
        given += len(places)
        return rows[places]

    return take


def _offered(value: Any, pipe: Pipe) -> Any:
    if isinstance(value, SimpleNamespace) and isinstance(getattr(value, SUPPLY, None), np.ndarray):
        return _supply(getattr(value, SUPPLY))
    if isinstance(value, SimpleNamespace):
        return SimpleNamespace(**{key: _offered(item, pipe) for key, item in vars(value).items()})
    if not (isinstance(value, str) and value.startswith(OFFERED)):
        return value
    name = value.removeprefix(OFFERED)

    def ask(*arguments: Any) -> Any:
        pipe.send(call=name, arguments=[_plain(item) for item in arguments])
        return pipe.receive()["result"]

    return ask


def _plain(value: Any) -> Any:
    """Return numbers as arrays and floats; a tuple stays one, what is no number becomes words."""
    if isinstance(value, tuple):
        return tuple(_plain(item) for item in value)
    if value is None or isinstance(value, SimpleNamespace):
        return value
    try:
        array = np.array(value, dtype=np.float64)
    except (TypeError, ValueError):
        return f"{type(value).__name__}, which is no array of numbers"
    return float(array) if array.ndim == 0 else array


def _parts(given: Any) -> list[Any]:
    return list(given) if isinstance(given, tuple) else [given]


def _linked(given: Any) -> bool:
    """Return whether two rows of the result are the same memory: a change of one moves both."""
    return any(_linked_rows(part) for part in _parts(given))


def _linked_rows(part: Any) -> bool:
    if isinstance(part, np.ndarray):
        return part.ndim == 2 and len(part) > 1 and part.strides[0] == 0
    if not isinstance(part, list):
        return False
    rows = [row for row in part if isinstance(row, np.ndarray | list)]
    places = [row.__array_interface__["data"][0] if isinstance(row, np.ndarray) else id(row)
              for row in rows]  # fmt: skip
    return len(set(places)) < len(places)


def _shares(part: Any, argument: np.ndarray[Any, Any]) -> bool:
    return isinstance(part, np.ndarray) and np.may_share_memory(part, argument)


if __name__ == "__main__":
    main()
