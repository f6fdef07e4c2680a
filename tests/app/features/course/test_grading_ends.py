"""Grading a file ends, whatever the file does; and the others of its class feel nothing of it."""

from __future__ import annotations

import json
import os
import threading
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import psutil
import pytest
from course.correct import CORRECT
from course.mistakes import WRITINGS
from course.solutions import ARRAYS

from app.features.course.class_command import as_csv, grade_class, submissions
from app.features.course.grading import _findings, grade, grade_lessons
from app.features.course.lesson import lesson_of
from app.features.course.sandbox import file_clock, student_process, wire
from app.features.course.sandbox.file_clock import FileClock
from app.features.course.sandbox.student_process import (
    Answer,
    StudentError,
    StudentProcess,
    _checked,
    _served,
)

SHORT_S = 4.0
"""The clock of a file in these tests [s]; it includes Python's start."""
SAYING = """
import os, struct, time
def say(message):
    for fd in range(3, 20):
        try: os.write(fd, message)
        except OSError: pass
"""


def forged(message: dict[str, object]) -> bytes:
    body = json.dumps(message).encode()
    return wire.LENGTH.pack(len(body)) + body


DRIP = f"""{SAYING}
def odometry(*a):
    say(struct.pack("<I", 16_000_000))
    while True:
        say(b" ")
        time.sleep(0.01)
"""
DRAG = """
import time
def loop(poses, weights, moved, scan, parts):
    while True:
        time.sleep(0.2)
        parts.motion(poses, moved)
"""
DEAF = f"""{SAYING}
def loop(poses, weights, moved, scan, parts):
    while True:  # asks, and does not read what is answered
        say({forged({"call": "motion", "arguments": {"parts": [[[0.0] * 3] * 500, [0.0] * 3]}})!r})
"""
LATE = "import time\ntime.sleep(1000)\ndef odometry(*a): return a\n"
STOPPED = "import os, signal\ndef odometry(*a):\n    os.kill(os.getpid(), signal.SIGSTOP)\n"
MUTED = "import os\ndef odometry(*a):\n    os.closerange(0, 64)\n    while True: pass\n"
SLOW = "import time\ndef odometry(*a):\n    time.sleep(1000)\n"
SPINNING = "def odometry(*a):\n    while True: pass\n"
HUGE = "def odometry(*a):\n    return bytearray(10**10)\n"
DEEP = "def odometry(*a):\n    raise x" + ".a" * 2000 + "\n"
INFINITE = f"""{SAYING}
def odometry(*a):
    say({forged({"result": {"array": "", "shape": [float("inf")], "type": "<f8"}})!r})
    time.sleep(1000)
"""
HOSTILE = {
    "drip": (DRIP, 1), "drag": (DRAG, 6), "deaf": (DEAF, 6),
    "late": (LATE, 1), "stopped": (STOPPED, 1), "muted": (MUTED, 1), "slow": (SLOW, 1),
    "spinning": (SPINNING, 1), "huge": (HUGE, 1), "deep": (DEEP, 1), "infinite": (INFINITE, 1),
}  # fmt: skip
linux = pytest.mark.skipif(os.name != "posix", reason="signals of Unix")


@pytest.fixture
def short(monkeypatch: pytest.MonkeyPatch) -> None:
    """The clock of a file is short: what is asked is whether it ends."""
    monkeypatch.setattr(file_clock, "FILE_S", SHORT_S)


@pytest.mark.slow
@linux
@pytest.mark.usefixtures("short")
@pytest.mark.parametrize("name", HOSTILE)
def test_grading_ends_by_the_files_clock(name: str) -> None:
    source, number = HOSTILE[name]
    began = time.monotonic()
    result = grade(source, "mine.py", lesson_of(number))
    assert time.monotonic() - began < SHORT_S + 3.0
    assert not result.passed
    assert result.findings


@pytest.mark.slow
@pytest.mark.usefixtures("short")
def test_all_lessons_of_a_file_have_one_clock() -> None:
    source = "import time\n" + "".join(
        f"def {name}(*a):\n    time.sleep(1000)\n"
        for number in range(1, 9)
        for name in lesson_of(number).checks.functions
    )
    began = time.monotonic()
    results = grade_lessons(source, "mine.py", [lesson_of(n) for n in range(1, 9)])
    assert time.monotonic() - began < SHORT_S + 3.0
    assert {finding.cause for result in results for finding in result.findings} == {"stopped"}
    assert "takes more than 4 s in all" in results[-1].findings[0].case.say()


@linux
def test_the_clock_of_a_call_goes_on_while_it_asks_and_drips(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(student_process, "QUICK_S", 0.1)
    for name in ("drip", "drag"):
        source, number = HOSTILE[name]
        began = time.monotonic()
        (finding,) = grade(source, "mine.py", lesson_of(number)).findings
        assert "does not end within 0.1 s" in finding.case.say()
        assert time.monotonic() - began < 15.0  # far from the clock of the file


@pytest.mark.slow
@linux
@pytest.mark.usefixtures("short")
def test_no_thread_and_no_process_is_left() -> None:
    """Other tests of this process may have left some of theirs."""
    threads, children = set(threading.enumerate()), set(psutil.Process().children())
    grade(DRIP, "mine.py", lesson_of(1))
    assert set(threading.enumerate()) <= threads
    assert set(psutil.Process().children()) <= children


SHAPES = [
    [float("inf")], [float("nan")], [-1], [-2, 3], [10**400], [2**62, 2**62], "ab", None, [None],
    {"a": 1}, [[3]], 3, [0, 10**18], [1] * 100, [True], ["3"], [1e300],
]  # fmt: skip


@pytest.mark.parametrize("shape", SHAPES, ids=str)
def test_whatever_shape_is_forged_is_no_message(shape: object) -> None:
    for content in ("", "AAAAAAAAAAA=", "!", None, 3, []):
        body = json.dumps({"result": {"array": content, "shape": shape, "type": "<f8"}}).encode()
        try:
            made = wire.unpack(body)["result"]
        except wire.WireError:
            continue
        assert made.size <= 1


@pytest.mark.parametrize("body", [b"[" * 100_000, b'{"a":' * 10_000, b"\xff", b"3",
                                  b"[[1,2,3]]",
                                  b'{"r":{"parts":3}}', b'{"r":{"names":[1]}}',
                                  b'{"r":{"array":1}}',
                                  b'{"r":' + b"9" * 10_000 + b"}", b'[["\\ud800",1]]'])  # fmt: skip
def test_what_is_no_message_is_refused(body: bytes) -> None:
    try:
        wire.unpack(body)
    except wire.WireError:
        return
    assert body.startswith(b'[["')  # a name, if a strange one


def test_an_offered_function_is_not_asked_for_more_than_it_can_hold() -> None:
    wide, high = np.zeros((1, 40_000)), np.zeros((40_000, 1))
    with pytest.raises(StudentError, match="what it cannot use: more than"):
        _served({"call": "sum", "arguments": (wide, high)}, {"sum": lambda a, b: a + b})


FORGED = [10**400, float("nan"), float("inf"), 1e308, "x", True, {}, [], {"parts": []},
          wire.encode(np.full(3, np.inf)), wire.encode(np.full((6, 3), 1e308)),
          wire.encode(np.zeros((0, 10**9))), {"names": {"supply": 1}}]  # fmt: skip


class Liar:
    """Answers each question by one message, as the code of a student can send it."""

    broken, path, source = False, "mine.py", ""

    def __init__(self, names: tuple[str, ...], value: object) -> None:
        self.names = names
        body = json.dumps({"result": value, "after": {"parts": [value]}, "linked": value}).encode()
        self._message = wire.unpack(body)

    def call(self, *_question: object, **_rest: object) -> Answer:
        return _checked(self._message)


@pytest.mark.slow
@pytest.mark.parametrize("number", range(1, 11))
def test_a_forged_result_is_told_and_not_stumbled_over(number: int) -> None:
    """Each pair of values is tried in a fourth of the lessons: one takes 0.1 s."""
    lesson = lesson_of(number)
    pairs = [{"parts": [first, second]} for first in FORGED for second in FORGED]
    for value in [*FORGED, *pairs[number % 4 :: 4]]:
        liar: Any = Liar(lesson.checks.functions, value)
        with np.errstate(all="ignore"):
            assert list(_findings(liar, lesson, 3, lesson.checks, FileClock(ARRAYS))), value


def test_weights_that_are_missing_are_told_as_such() -> None:
    source = "def resample(poses, weights, rng):\n    return poses.copy(), None\n"
    (finding, *_) = grade(source, "mine.py", lesson_of(5)).findings
    assert finding.cause == "form"
    assert "gives None" in finding.case.say()


class Here:
    """The worker is this process, in which the clocks are short.

    Not threads: Python 3.11 counts in one place how deep the sources of all of them are.
    """

    count = 1

    def each(self, work: Any, jobs: Any) -> Iterator[tuple[int, Any]]:
        yield from enumerate(map(work, jobs))

    def close(self) -> None:
        pass


@pytest.mark.slow
@linux
def test_ten_hostile_files_in_a_class_change_no_byte_of_the_others(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(student_process, "QUICK_S", 0.8)
    monkeypatch.setattr(file_clock, "FILE_S", 16.0)  # one file sleeps as long as it may
    good = [*CORRECT.values(), *(writing.source for writing in WRITINGS if writing.lesson == 1)]
    bad = [source for source, _ in HOSTILE.values()][:10]
    for number in range(30):
        source = bad[number // 3] if number % 3 == 1 else (good * 3)[number]
        (tmp_path / f"{number:02}.py").write_text(source)
    hostile = {f"{number:02}.py" for number in range(1, 30, 3)}

    def rows(leave_out: set[str]) -> list[str]:
        given = [item for item in submissions([tmp_path]) if item.name not in leave_out]
        table = as_csv(grade_class(given, (1,), None, 3, Here()), (1,))
        return [row for row in table.splitlines() if row.partition(",")[0] not in hostile]

    assert rows(set()) == rows(hostile)


def test_a_clock_that_is_over_starts_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(file_clock, "FILE_S", 0.0)
    with pytest.raises(StudentError, match="takes more than 0 s in all"):
        StudentProcess("mine.py", ARRAYS, FileClock(ARRAYS)).__enter__()
