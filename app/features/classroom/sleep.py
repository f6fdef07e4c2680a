"""Sleeper: while nobody looks, the process that drives the robot stands still, and time with it.

A robot without viewers still costs a tenth of a core: it is simulated, and takes a picture now and
then. Of thirty, most wait while their students read. A process that is stopped costs nothing, keeps
its memory, and goes on where it was. The wall alone is no viewer: else nobody would ever sleep.
"""

from __future__ import annotations

import asyncio
import multiprocessing
import os
import signal
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress

from app.engine.program import Program

CONTROL = "control"
"""The name of the process that drives (feature ``control``)."""
QUIET_S = 5.0
"""It sleeps when nobody has looked for this time [s]: a page that is loaded anew does not end it.
Half or twice of it changes what a robot costs only while students come and go."""


class Sleeper:
    """Counts who looks; the event loop's thread alone uses it."""

    def __init__(
        self,
        quiet: float = QUIET_S,
        processes: Callable[[], list[int]] | None = None,
    ) -> None:
        """Watch over a robot.

        Args:
            quiet: it sleeps after this time without anybody [s].
            processes: returns the processes that stop and go on; by default control.
        """
        self._quiet = quiet
        self._processes = processes or _control_processes
        self._program: Program | None = None
        self._looking = 0
        self._later: asyncio.TimerHandle | None = None
        self.asleep = False

    def watch(self, program: Program) -> None:
        """Look after a program; it is another one after the field was changed."""
        self._program = program

    @contextmanager
    def looked(self) -> Iterator[None]:
        """Be awake as long as this block, and for a while afterwards."""
        self._looking += 1
        self.wake()
        try:
            yield
        finally:
            self._looking -= 1
            self._look_again()

    def wake(self) -> None:
        """Let it go on, at once."""
        if self.asleep:
            self._send(signal.SIGCONT)
            self._hold(False)
        self.asleep = False

    def _look_again(self) -> None:
        if self._later is not None:
            self._later.cancel()
            self._later = None
        if not self._looking:
            self._later = asyncio.get_running_loop().call_later(self._quiet, self._sleep)

    def _sleep(self) -> None:
        self._later = None
        if self._looking or self.asleep:
            return
        if self._is_busy():
            self._look_again()
            return
        self.asleep = True
        self._send(signal.SIGSTOP)
        self._hold(True)

    def _is_busy(self) -> bool:
        """Whether something goes on without viewers: a recording, a way to a goal."""
        program = self._program
        if program is None or program.loop is not None or program.engine.every.subscribed:
            return True
        latest = program.engine.latest.get()
        return latest is None or latest.mode != "idle"

    def _hold(self, held: bool) -> None:
        """Tell the program's loop, if it is one of another process: it then looks seldom."""
        hold = getattr(self._program and self._program.engine, "hold", None)
        if hold is not None:
            hold(held)

    def _send(self, sign: signal.Signals) -> None:
        for pid in self._processes():
            with suppress(ProcessLookupError):
                os.kill(pid, sign)


def _control_processes() -> list[int]:
    children = multiprocessing.active_children()
    return [child.pid for child in children if child.name == CONTROL and child.pid is not None]
