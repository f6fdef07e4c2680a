"""Interruption by SIGINT (Ctrl-C), SIGTERM or SIGBREAK (Windows), by what there is to clean up.

Python raises KeyboardInterrupt wherever the program happens to be. Within an import or a callback
from C, other code may print it with a traceback, or drop it, and the program goes on. So a signal

* ends the process at once, as long as nothing has to be cleaned up: ``end_at_once``;
* raises ``Interrupted`` until it is noticed, where ``finally`` clauses clean up: ``interruptible``;
* raises nothing, in a loop that ends when it is asked to: ``deferred``.

The exit code is that of a shell, 128 and the signal's number: 130 after Ctrl-C, 143 after SIGTERM.
Windows sends SIGBREAK at Ctrl-Break, and when the terminal's window is closed: 149.
This module imports little, as signals are not handled before it is there.
"""

from __future__ import annotations

import atexit
import os
import signal
import sys
import threading
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from types import FrameType

SIGNALS = tuple(
    getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGBREAK") if hasattr(signal, name)
)
"""Those that ask the program to end, as far as this system has them."""

AGAIN_S = 0.1
"""Interval of raising ``Interrupted`` until it is noticed [s]."""

Handler = Callable[[int, FrameType | None], object]


class Interrupted(KeyboardInterrupt):
    """A signal asks the program to end."""

    def __init__(self, number: int) -> None:
        super().__init__(f"ended by {signal.Signals(number).name}")
        self.number = number

    @property
    def code(self) -> int:
        """The exit code."""
        return exit_code(self.number)


def exit_code(number: int) -> int:
    """Return the exit code of a program that a signal ended."""
    return 128 + number


def end_at_once() -> None:
    """End the process at a signal, from now on and until Python has shut down."""
    for number in SIGNALS:
        signal.signal(number, lambda number, frame: os._exit(exit_code(number)))
    # Python restores the default handlers before it removes the modules, which takes a while: a
    # signal would change the exit code of what has ended. Of all exit functions this is the last.
    atexit.register(_ignore)


@contextmanager
def interruptible() -> Iterator[None]:
    """Raise ``Interrupted`` in the block at a signal; a signal while it cleans up changes nothing.

    Raises:
        Interrupted: also at the end of the block, if other code dropped it failed because
            of it.
    """
    taken: list[int] = []

    def interrupt(number: int, frame: FrameType | None) -> None:
        taken.append(number)
        if not _is_noticed(sys.exception()):
            alarm.start()
            raise Interrupted(taken[0])

    alarm = _TimerAlarm() if hasattr(signal, "setitimer") else _ThreadAlarm()

    hook = sys.unraisablehook
    sys.unraisablehook = lambda given: (
        None if isinstance(given.exc_value, Interrupted) else hook(given)
    )
    try:
        # The alarm's handler is there before the others, and after them.
        with _handlers(interrupt, alarm.signals):
            try:
                with _handlers(interrupt, SIGNALS):
                    try:
                        yield
                    finally:
                        alarm.end()
            except Exception as error:
                # C code makes a SystemError of an exception that it did not expect, or drops it and
                # fails at what it left undone. A failure while cleaning up is another matter.
                if taken and (_is_cause(error) or not _is_noticed(error)):
                    raise Interrupted(taken[0]) from None
                raise
            finally:
                alarm.end()
    finally:
        sys.unraisablehook = hook
    if taken:
        raise Interrupted(taken[0])


@contextmanager
def deferred(stop: Callable[[], object] = lambda: None) -> Iterator[Callable[[], bool]]:
    """Yield a function that says whether there was a signal; if so, the block has to end soon.

    Args:
        stop: called at each signal. It must take no lock: the next signal would wait for it.

    Raises:
        Interrupted: at the end of the block, if there was a signal.
    """
    taken: list[int] = []

    def ask(number: int, frame: FrameType | None) -> None:
        taken.append(number)
        stop()

    with _handlers(ask, SIGNALS):
        yield lambda: bool(taken)
    if taken:
        raise Interrupted(taken[0])


@contextmanager
def uninterrupted() -> Iterator[None]:
    """Let a signal wait for the end of the block, and do then what it would have done.

    A block for what must not be left half done, and is short. In other threads than the main one
    no signal raises anything.
    """
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    taken: list[int] = []
    try:
        with _handlers(lambda number, frame: taken.append(number), SIGNALS):
            yield
    finally:
        if taken:
            signal.raise_signal(taken[0])


class _TimerAlarm:
    """Sends a signal again and again."""

    def __init__(self) -> None:
        self.signals: tuple[signal.Signals, ...] = (signal.SIGALRM,)
        """What it sends, beside ``SIGNALS``."""

    def start(self) -> None:
        """Begin; may be called while it runs."""
        signal.setitimer(signal.ITIMER_REAL, AGAIN_S, AGAIN_S)

    def end(self) -> None:
        """End; may be called twice, and before the start."""
        signal.setitimer(signal.ITIMER_REAL, 0)


class _ThreadAlarm:
    """The same on Windows, which has no timers: a thread sends what Ctrl-C sends.

    It is ended for good while ``SIGNALS`` still have their handler: after that, its signal would
    end the program.
    """

    def __init__(self) -> None:
        self.signals: tuple[signal.Signals, ...] = ()
        self._ended = threading.Event()
        self._thread = threading.Thread(target=self._send, name="interruption", daemon=True)

    def start(self) -> None:
        """Begin; may be called while it runs."""
        if self._thread.ident is None and not self._ended.is_set():
            self._thread.start()

    def end(self) -> None:
        """End; may be called twice, and before the start."""
        self._ended.set()
        if self._thread.ident is not None:
            self._thread.join()

    def _send(self) -> None:
        while not self._ended.wait(AGAIN_S):
            signal.raise_signal(signal.SIGINT)


@contextmanager
def _handlers(handler: Handler, numbers: Sequence[signal.Signals]) -> Iterator[None]:
    before = [signal.signal(number, handler) for number in numbers]
    try:
        yield
    finally:
        for number, earlier in zip(numbers, before, strict=True):
            signal.signal(number, earlier)


def _is_noticed(error: BaseException | None) -> bool:
    """Whether an exception that is being handled is, or came from, ``Interrupted``."""
    while error is not None and not isinstance(error, Interrupted):
        error = error.__context__
    return error is not None


def _is_cause(error: BaseException | None) -> bool:
    """Whether an exception was raised from ``Interrupted``, and not merely while cleaning up."""
    while error is not None and not isinstance(error, Interrupted):
        error = error.__cause__
    return error is not None


def _ignore() -> None:
    for number in SIGNALS:
        signal.signal(number, signal.SIG_IGN)
