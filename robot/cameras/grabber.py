"""A thread that takes pictures from a device and keeps the newest one until it is fetched.

A device that fails or falls silent is closed and opened again, without limit. Meanwhile there is no
picture, and ``problem`` says why.
"""

from __future__ import annotations

import logging
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Protocol

from robot.camera import Lens
from robot.cameras.camera import PictureError, check_size
from robot.interface import Frame
from robot.worker_thread import WorkerThread

LOG = logging.getLogger("brickpose")

GRAB_S = 0.1
"""How long the thread waits for a picture before it checks whether it must end [s]."""

JOIN_S = 3.0
"""How long ``close`` waits for the thread [s]; opening a camera can take a second or two."""

FIRST_PICTURE_S = 3.0
"""Longest time from a device's start to its first picture [s]."""

HUNG_S = 8.0
"""A driver that has not returned from a call after this time [s] is taken to hang."""

FIRST_RETRY_S, LAST_RETRY_S = 0.5, 8.0
"""Time between attempts to open the device [s]: it doubles from the first value to the last."""


class Device(Protocol):
    """A camera's driver; only one thread uses it."""

    @property
    def name(self) -> str:
        """Name of the camera in messages."""
        ...

    def open(self) -> None:
        """Start it.

        Raises:
            PictureError: it is absent, busy or cannot do what is required; the message says the
                cure.
        """
        ...

    def grab(self, timeout: float) -> Frame | None:
        """Wait for the next picture, about ``timeout`` [s] at most; None if none came.

        Raises:
            PictureError: it cannot go on and must be opened again.
        """
        ...

    def close(self) -> None:
        """Stop it, whether it is open or not."""
        ...


class Grabber:
    """A camera with a thread of its own that takes the pictures."""

    def __init__(
        self,
        device: Device,
        lens: Lens,
        frame_rate: float,
        clock: Callable[[], float] = time.monotonic,
        first_retry: float = FIRST_RETRY_S,
    ) -> None:
        """``clock`` [s] is the clock of the stamps; ``first_retry`` is a time in seconds."""
        self._device = device
        self._lens = lens
        self._clock = clock
        self._first_retry = first_retry
        self._stall = max(0.5, 3 / frame_rate)
        self._lock = threading.Lock()
        self._slot: Frame | None = None
        self._last_stamp = -float("inf")
        self._last_arrival = clock()
        self._trouble: str | None = f"{device.name} is being started"
        self._called: float | None = None
        """Since when the thread is in a call of the driver; None if it is in none."""
        self._thread = WorkerThread("camera", self._run, owner=device.name, patience=JOIN_S)

    @property
    def name(self) -> str:
        """Name of the camera in messages."""
        return self._device.name

    def start(self) -> None:
        """Begin to take pictures."""
        self._thread.start()

    def newest(self) -> Frame | None:
        """Return the newest picture, or None if it was handed out before; do not wait."""
        with self._lock:
            frame, self._slot = self._slot, None
        return None if self._thread.stopping.is_set() else frame

    @property
    def problem(self) -> str | None:
        """Why no pictures come, with the cure; None while they come."""
        with self._lock:
            trouble, silent = self._trouble, self._clock() - self._last_arrival
            called = self._called
        if called is not None and self._clock() - called > HUNG_S:
            return self._hung()
        return trouble or (self._silence() if silent > self._stall else None)

    def close(self) -> None:
        """End the thread and release the device; may be called twice."""
        self._thread.stop()
        with self._lock:
            self._slot = None
            self._trouble = f"{self.name} is closed"

    def _run(self, stopping: threading.Event) -> None:
        retry = self._first_retry
        while not stopping.is_set():
            before = self._last_stamp
            self._attempt(stopping)
            if self._last_stamp > before:
                retry = self._first_retry
            stopping.wait(retry)
            retry = min(2 * retry, LAST_RETRY_S)

    def _attempt(self, stopping: threading.Event) -> None:
        """Open the device and take pictures until it fails or the camera is closed."""
        try:
            with self._in_driver():
                self._device.open()
            self._take_pictures(stopping)
        except PictureError as error:
            self._tell(str(error))
        except Exception as error:  # whatever a driver raises, the next attempt may succeed
            LOG.exception("%s failed", self.name)
            self._tell(f"{self.name} failed: {error}")
        finally:
            self._let_go()

    def _take_pictures(self, stopping: threading.Event) -> None:
        patient_until = self._clock() + FIRST_PICTURE_S
        while not stopping.is_set():
            with self._in_driver():
                frame = self._device.grab(GRAB_S)
            # A driver that hands out the same buffer again has no new picture.
            if frame is not None and frame.stamp > self._last_stamp:
                self._put(frame)
                patient_until = self._last_arrival + self._stall
            elif self._clock() > patient_until:
                raise PictureError(self._silence())

    def _put(self, frame: Frame) -> None:
        check_size(frame.image.shape, self._lens, self.name)
        with self._lock:
            self._slot = frame
            self._last_stamp = frame.stamp
            self._last_arrival = self._clock()
            self._trouble = None

    def _let_go(self) -> None:
        try:
            with self._in_driver():
                self._device.close()
        except Exception as error:
            LOG.exception("%s could not be closed", self.name)
            self._tell(f"{self.name} could not be closed: {error}")

    def _tell(self, trouble: str) -> None:
        with self._lock:
            self._trouble = trouble

    @contextmanager
    def _in_driver(self) -> Iterator[None]:
        with self._lock:
            self._called = self._clock()
        try:
            yield
        finally:
            with self._lock:
                self._called = None

    def _hung(self) -> str:
        return (
            f"{self.name}'s driver hangs, so no other attempt can be made; check the cable, then "
            "start the program again, or the computer if that does not help"
        )

    def _silence(self) -> str:
        return (
            f"{self.name} sends no pictures any more and is started again; check its cable "
            "and the power supply"
        )
