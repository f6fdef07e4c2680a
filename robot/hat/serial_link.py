"""The one thread that talks to a Build HAT's serial port."""

from __future__ import annotations

import logging
import threading
import time
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Protocol

from robot.hat.serial_port import PortError, SerialPort

LOG = logging.getLogger("brickpose")

REOPEN_S = 0.5
THREAD = "build hat"
"""What the thread is called, in Python and in the system."""

EARLY, LATE = 0.3, 1.2
"""Ticks come with the motors' reports, as these have the same period: 0.9 to 1.2 periods apart."""

FAREWELL_S = 0.5
JOIN_S = 2.0


class Talker(Protocol):
    """What stands behind the port; called by the link's thread alone. Times are its clock's [s]."""

    @property
    def wants_reset(self) -> bool:
        """Whether the board must be reset by its pin; cleared by the answer to it."""
        ...

    def opened(self, current: float) -> bytes:
        """The port is open; returns what to send."""
        ...

    def receive(self, data: bytes, current: float) -> bytes:
        """Bytes that just arrived; returns what to send."""
        ...

    def tick(self, current: float) -> bytes:
        """About a period is over; returns what to send."""
        ...

    def lost(self, reason: str, current: float) -> None:
        """The port cannot be opened or is gone, with the cure; it is tried again for ever."""
        ...

    def was_reset(self, current: float) -> None:
        """The board has just been reset by its pin."""
        ...

    def cannot_reset(self, reason: str, current: float) -> None:
        """The board could not be reset by its pin."""
        ...

    def farewell(self) -> bytes:
        """What to send before the port is closed: the motors' stop."""
        ...


class SerialLink:
    """Opens the port, carries bytes both ways, and opens it again when it went away."""

    def __init__(
        self,
        device: str,
        talker: Talker,
        reset: Callable[[], None] | None = None,
        period: float = 0.01,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        """``reset`` pulls the board's pin and raises if it cannot; ``period`` of the ticks [s]."""
        self.failure: Exception | None = None
        """What ended the thread, if the talker failed."""
        self._device = device
        self._talker = talker
        self._reset = reset
        self._period = period
        self._clock = clock
        self._reason: str | None = None
        self._stopping = threading.Event()
        self._thread = threading.Thread(target=self._run, name=THREAD, daemon=True)

    @property
    def alive(self) -> bool:
        """Whether the thread runs."""
        return self._thread.is_alive()

    def start(self) -> None:
        """Begin; a port that cannot be opened is told to the talker, not raised."""
        self._thread.start()

    def close(self) -> None:
        """Say farewell and let go of the port; may be called twice."""
        self._stopping.set()
        if self._thread.ident is None:
            return
        self._thread.join(JOIN_S)
        if self._thread.is_alive():
            LOG.error("the Build HAT's thread did not end within %g s", JOIN_S)

    def _run(self) -> None:
        with suppress(OSError):  # Linux only: what `top -H` shows
            Path(f"/proc/self/task/{threading.get_native_id()}/comm").write_text(THREAD)
        try:
            while not self._stopping.is_set():
                self._open_and_serve()
                self._stopping.wait(REOPEN_S)
        except Exception as error:
            self.failure = error
            LOG.exception("the Build HAT's driver failed; its motors were told to stop")

    def _open_and_serve(self) -> None:
        """Serve the port until it is gone or the end is asked for."""
        try:
            port = SerialPort(self._device, self._clock)
        except PortError as error:
            self._lost(str(error))
            return
        try:
            self._reason = None
            self._serve(port)
        except PortError as error:
            self._lost(str(error))
        finally:
            port.close()

    def _serve(self, port: SerialPort) -> None:
        try:
            due = self._clock()
            port.put(self._talker.opened(due))
            while not self._stopping.is_set():
                due = self._step(port, due)
        except PortError:
            raise
        except Exception as error:
            try:
                self._take_leave(port)
            except PortError as gone:
                error.add_note(f"and the motors could not be told to stop: {gone}")
            raise
        self._take_leave(port)

    def _step(self, port: SerialPort, due: float) -> float:
        """Move bytes, and tick if it is time; returns when the next tick is due."""
        data = port.exchange(due - self._clock())
        current = self._clock()
        if data:
            port.put(self._talker.receive(data, current))
        # With what just came at hand a tick may come early: to wake up for it again costs as much
        # of the processor as all that is done then.
        if current >= due - (EARLY * self._period if data else 0):
            port.put(self._talker.tick(current))
            due = current + LATE * self._period
        if self._talker.wants_reset:
            self._reset_board()
        return due

    def _reset_board(self) -> None:
        try:
            if self._reset is None:
                raise RuntimeError("this program has no reset pin")
            self._reset()
        except (OSError, RuntimeError, ValueError) as error:
            self._talker.cannot_reset(str(error), self._clock())
        else:
            self._talker.was_reset(self._clock())

    def _take_leave(self, port: SerialPort) -> None:
        if not port.finish(self._talker.farewell(), FAREWELL_S):
            LOG.error("%s took no farewell; the motors stop when their pulse ends", self._device)

    def _lost(self, reason: str) -> None:
        """Tell the talker, once for each reason."""
        if reason != self._reason:
            self._reason = reason
            self._talker.lost(reason, self._clock())
