"""OwnPlanner and OwnController: a function in a user's own file, read again when it is saved."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from itertools import pairwise
from queue import Empty, SimpleQueue
from typing import Any

import numpy as np

from app.features.own_models.error_messages import (
    OwnModelError,
    errors_named_after,
    line_of,
    place,
    running,
)
from app.features.own_models.model_file import ModelFile, load
from app.features.own_models.watch import FileWatch
from robot.geometry import Array, Pose2, Twist2
from robot.navigation.controllers import Tracking
from robot.navigation.free_space import FreeSpace
from robot.navigation.legs import WayLeg
from robot.navigation.planning import NoWayError, plan_by_corners

LOOKS_EVERY_S = 0.25
"""A file that is in use is looked at so often [s]; a save counts when two looks agree."""
SAME_M, POINTS_M = 0.003, 0.005
"""A corner so near to an end of the way is that end; a way is checked in points so near [m]."""
HANGS_S = 0.5
"""A controller that has not answered after so long [s] is given up: the robot drives on with its
last velocity meanwhile, and stops before a drive command would end by itself."""
LARGEST = 1e3
"""Larger numbers are a mistake."""


class _OwnFunction:
    """A function of a user's file, as it was last saved."""

    def __init__(self, name: str) -> None:
        """Read the file at the first call.

        Raises:
            SettingError: ``name`` is not FILE.py:NAME, or there is no such file.
        """
        self._file = ModelFile.find(name)
        self._watch = FileWatch(self._file.path)
        self._function: Any = None
        self._fault: OwnModelError | None = None
        self._looked = 0.0

    def call(self, *arguments: object) -> object:
        """Call it.

        Raises:
            OwnModelError: it failed, now or since the file was saved; with file and line.
        """
        self._refresh()
        if self._fault is None:
            try:
                if self._function is None:
                    self._function = load(self._file)
                with errors_named_after(self._file.path, self._line):
                    return self._function(*arguments)
            except OwnModelError as error:
                self._fault = error
        raise OwnModelError(str(self._fault))

    def give_up(self, words: str) -> OwnModelError:
        """Return the error of a call that does not end, and keep it until the file is saved."""
        self._fault = OwnModelError(words)
        return self._fault

    def refuse(self, words: str) -> OwnModelError:
        """Return the error of a result that is none, and keep it until the file is saved."""
        self._fault = OwnModelError(f"{place(self._file.path, self._line)}{words}")
        return self._fault

    @property
    def name(self) -> str:
        """Of the function."""
        return self._file.class_name

    @property
    def _line(self) -> int | None:
        return None if self._function is None else line_of(self._function, self._file.path)

    def _refresh(self) -> None:
        stamp = time.monotonic()
        if stamp - self._looked < LOOKS_EVERY_S:
            return
        self._looked = stamp
        if self._watch.saved():
            self._function = self._fault = None


class OwnPlanner:
    """Finds corners: ``def corners(space, start, goal)`` returns points (n, 2)."""

    PATIENCE_S = 1.0
    referenced = True
    """A replay that goes back has the file as it is now."""

    def __init__(self, name: str) -> None:
        """Take the function FILE.py:NAME.

        Raises:
            SettingError: there is no such file.
        """
        self._own = _OwnFunction(name)

    def plan(self, free: FreeSpace, start: Pose2, goal: Pose2) -> tuple[WayLeg, ...]:
        """Return legs along its corners.

        Raises:
            NoWayError: a wall is at the goal, or on the path; or it has found none.
            OwnModelError: the function has failed, with file and line.
        """
        return plan_by_corners(self._corners)(free, start, goal)

    def _corners(self, free: FreeSpace, begin: Pose2, end: Pose2) -> Array:
        given = self._own.call(free, begin, end)
        if given is None:
            raise NoWayError(f"{self._own.name} finds no way")
        try:
            corners = np.array(given, dtype=np.float64)
        except (TypeError, ValueError) as error:
            raise self._own.refuse(f"it gives no array: {error}") from error
        if corners.ndim != 2 or corners.shape[1] != 2 or len(corners) < 1:
            shape = corners.shape
            raise self._own.refuse(f"it gives the shape {shape}; valid is (n, 2): x, y [m]")
        if not (np.abs(corners) < LARGEST).all():
            raise self._own.refuse("it gives places that are no finite numbers of metres")
        ends = np.array([[begin.x, begin.y], [end.x, end.y]])
        # Whether it gives the ends as well or leaves them out, each is there once.
        inner = [each for each in corners if np.hypot(*(ends - each).T).min() > SAME_M]
        whole = np.array([ends[0], *inner, ends[1]])
        if not free.turns(_dense(whole)):
            wall = next(
                (x, y) for x, y in _dense(whole).tolist() if not free.turns(np.array([[x, y]]))
            )
            raise NoWayError(
                f"the way of {self._own.name} is too near to a wall at "
                f"({wall[0]:.3f}, {wall[1]:.3f}) m"
            )
        return whole


class OwnController:
    """Drives: ``def command(tracking)`` returns v [m/s] and omega [rad/s]."""

    by_time = True
    referenced = True
    """A replay that goes back has the file as it is now."""

    def __init__(self, name: str) -> None:
        """Take the function FILE.py:NAME.

        Raises:
            SettingError: there is no such file.
        """
        self._own = _OwnFunction(name)
        self._calls: _Calls | None = None

    def command(self, tracking: Tracking) -> Twist2:
        """Return the twist to command.

        Raises:
            OwnModelError: the function has failed, with file and line.
        """
        given = self._answer(tracking)
        if given is None:
            raise self._own.refuse("it gives None; is its `return` missing?")
        try:
            v, omega = (float(each) for each in _pair(given))
        except (TypeError, ValueError) as error:
            raise self._own.refuse(f"it gives {given!r}; valid are v and omega") from error
        if not (abs(v) < LARGEST and abs(omega) < LARGEST):
            raise self._own.refuse(f"it gives {v}, {omega}; valid are finite numbers")
        return Twist2(v, omega)

    def _answer(self, tracking: Tracking) -> object:
        """Return what the function gives, or give it up if it does not end."""
        calls = self._calls = self._calls or _Calls(self._own.call)
        try:
            return calls.call(tracking)
        except TimeoutError:
            # Python cannot end the thread; it is left to itself, and another one has the next call.
            self._calls = None
            where = running(calls.ident)
            raise self._own.give_up(
                where or f"{self._own.name} has not answered for {HANGS_S:g} s"
            ) from None


class _Calls:
    """Calls a function in a thread of its own, which does not keep the program from ending."""

    def __init__(self, function: Callable[[Tracking], object]) -> None:
        self._asked: SimpleQueue[Tracking] = SimpleQueue()
        self._answers: SimpleQueue[object] = SimpleQueue()
        self._function = function
        self._thread = threading.Thread(target=self._run, name="own controller", daemon=True)
        self._thread.start()

    @property
    def ident(self) -> int | None:
        """Of the thread."""
        return self._thread.ident

    def call(self, tracking: Tracking) -> object:
        """Return what the function returns, and raise what it raises.

        Raises:
            TimeoutError: it has not ended in time.
        """
        self._asked.put(tracking)
        try:
            answer = self._answers.get(timeout=HANGS_S)
        except Empty:
            raise TimeoutError from None
        if isinstance(answer, OwnModelError):
            raise answer
        return answer

    def _run(self) -> None:
        while True:
            tracking = self._asked.get()
            try:
                self._answers.put(self._function(tracking))
            except OwnModelError as error:
                self._answers.put(error)


def _pair(given: object) -> Any:
    return (given.v, given.omega) if isinstance(given, Twist2) else given


def _dense(corners: Array) -> Array:
    """Return points (n, 2) on straight lines between corners, a few millimetres apart."""
    parts = [corners[:1]]
    for begin, end in pairwise(corners):
        count = max(1, int(np.ceil(np.hypot(*(end - begin)) / POINTS_M)))
        parts.append(begin + np.linspace(0, 1, count + 1)[1:, None] * (end - begin))
    return np.concatenate(parts)
