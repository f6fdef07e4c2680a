"""The only thread that talks to a Build HAT's serial port."""

from __future__ import annotations

import logging
import threading
import time
from collections.abc import Callable

from robot.errors import BrickPoseError, PortError
from robot.hat.board import BoardDriver
from robot.hat.serial_port import SerialPort
from robot.worker_thread import WorkerThread

LOG = logging.getLogger("brickpose")

REOPEN_S = 0.5
THREAD = "build hat"
"""Name of the thread, in Python and in the system."""

EARLY, LATE = 0.3, 1.2
"""Fractions of a period. A tick comes 1.2 periods after the last one, or up to 0.3 earlier if a
motor's report arrives. As reports have the same period, ticks come with them."""

FAREWELL_S = 0.5
JOIN_S = 2.0


class SerialLink(WorkerThread):
    """Opens the port, carries bytes both ways, and opens the port again after it was lost.

    A port that cannot be opened is reported to the driver, not raised. Only this thread calls the
    driver; times are by its clock [s].
    """

    def __init__(
        self,
        device: str,
        board: BoardDriver,
        reset: Callable[[], None] | None = None,
        period: float = 0.01,
    ) -> None:
        """``reset`` pulses the board's reset pin or raises; ``period`` is that of the ticks [s]."""
        super().__init__(
            THREAD, self._carry, owner="the Build HAT", patience=JOIN_S, report=self._complain
        )
        self._device = device
        self._board = board
        self._reset = reset
        self._period = period
        self._reason: str | None = None

    def close(self) -> None:
        """Send the farewell and close the port; may be called twice."""
        self.stop()

    def _carry(self, stopping: threading.Event) -> None:
        while not stopping.is_set():
            self._open_and_serve(stopping)
            stopping.wait(REOPEN_S)

    def _open_and_serve(self, stopping: threading.Event) -> None:
        """Serve the port until it is gone or the link is closed."""
        try:
            port = SerialPort(self._device)
        except PortError as error:
            self._lost(str(error))
            return
        try:
            self._reason = None
            self._serve(port, stopping)
        except PortError as error:
            self._lost(str(error))
        finally:
            port.close()

    def _serve(self, port: SerialPort, stopping: threading.Event) -> None:
        try:
            due = time.monotonic()
            port.put(self._board.opened(due))
            while not stopping.is_set():
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
        """Move bytes, and tick if it is time; return when the next tick is due."""
        data = port.exchange(due - time.monotonic())
        current = time.monotonic()
        if data:
            port.put(self._board.receive(data, current))
        # After data, a tick may come early: to wake up again for the tick would take as much
        # processor time as the tick itself.
        if current >= due - (EARLY * self._period if data else 0):
            port.put(self._board.tick(current))
            due = current + LATE * self._period
        if self._board.wants_reset:
            self._reset_board()
        return due

    def _reset_board(self) -> None:
        try:
            if self._reset is None:
                raise BrickPoseError("this program has no reset pin")
            self._reset()
        except (BrickPoseError, OSError) as error:
            self._board.cannot_reset(str(error), time.monotonic())
        else:
            self._board.was_reset(time.monotonic())

    def _take_leave(self, port: SerialPort) -> None:
        if not port.finish(self._board.farewell(), FAREWELL_S):
            LOG.error("%s took no farewell; the motors stop when their pulse ends", self._device)

    def _complain(self, error: Exception) -> None:
        LOG.error("the Build HAT's driver failed; its motors were told to stop", exc_info=error)

    def _lost(self, reason: str) -> None:
        """Tell the driver, but not the same reason twice in a row."""
        if reason != self._reason:
            self._reason = reason
            self._board.lost(reason, time.monotonic())
