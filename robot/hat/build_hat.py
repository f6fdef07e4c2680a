"""The LEGO robot: motors on a Build HAT and a camera, behind the common interface of robots."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import replace
from typing import Protocol

import numpy as np

from robot.cameras.camera import Camera
from robot.cameras.choice import open_camera
from robot.cameras.settings import CameraSourceSettings
from robot.description.spec import RobotSpec
from robot.geometry import Array
from robot.hat.board import BoardDriver
from robot.hat.serial_link import SerialLink
from robot.hat.serial_port import find_device
from robot.hat.settings import BuildHatSettings
from robot.hat.start.bring_up import BringUp
from robot.hat.start.firmware_image import FirmwareImage
from robot.hat.start.reset_line import GpioResetLine
from robot.interface import Frame, Reading, RobotError

PERIOD = 0.02
"""Time between two readings [s]: control at 50 Hz."""


class BoardLink(Protocol):
    """Carries bytes between the board and its driver."""

    failure: Exception | None
    """The exception that ended the link; None while it works."""

    def start(self) -> None:
        """Open the port, and keep it open."""
        ...

    def close(self) -> None:
        """Stop the motors and close the port; may be called twice."""
        ...


class BuildHat:
    """A ``Robot``; every reading reports what is wrong with a motor or the camera."""

    def __init__(
        self,
        spec: RobotSpec,
        board: BoardDriver,
        link: BoardLink,
        camera: Camera,
        clock: Callable[[], float] = time.monotonic,
        sleep: Callable[[float], None] = time.sleep,
    ) -> None:
        """Take the connected parts and start the link; ``close`` ends it."""
        self.name = "LEGO robot"
        self.spec = spec
        self._board = board
        self._link = link
        self._camera = camera
        self._clock = clock
        self._sleep = sleep
        self._zero = self._due = clock()
        self._last = 0.0
        self._closed = False
        link.start()

    @classmethod
    def open(
        cls, spec: RobotSpec, settings: BuildHatSettings, camera: CameraSourceSettings
    ) -> BuildHat:
        """Connect the robot of this computer; every reading reports what is missing.

        Raises:
            ValueError: no camera can have the name in the settings.
        """
        board = BoardDriver(spec.joints, settings, BringUp(FirmwareImage.installed))
        device = find_device() if settings.serial_port == "auto" else settings.serial_port
        link = SerialLink(device, board, GpioResetLine().pulse)
        return cls(spec, board, link, open_camera(spec.lens, camera))

    def read(self) -> Reading:
        """Wait for the next period, and return the joints' state and the camera's newest picture.

        Raises:
            RobotError: the link to the Build HAT has failed.
        """
        self._wait()
        if self._link.failure is not None:
            raise RobotError(f"the link to the Build HAT failed: {self._link.failure}")
        current = self._clock()
        state = self._board.state(current)
        # Stamps rise even without motors, because callers expect time to advance.
        stamp = max(state.stamp - self._zero, self._last + 1e-4)
        self._last = stamp
        problem = self._camera.problem
        return Reading(
            stamp=stamp,
            positions=state.positions,
            velocities=state.velocities,
            frame=self._frame(),
            battery_v=state.supply_v,
            connected=state.ready,
            faults=state.faults if problem is None else (*state.faults, problem),
        )

    def write(self, velocities: Array) -> Array:
        """Request joint velocities (j,) [rad/s]; return those really aimed for, 0 in a fault."""
        if self._closed:
            return np.zeros_like(velocities)
        return self._board.command(velocities, self._clock())

    def close(self) -> None:
        """Stop the motors, close the port and release the camera; may be called twice."""
        if self._closed:
            return
        self._closed = True
        try:
            self._link.close()
        finally:
            self._camera.close()

    def _frame(self) -> Frame | None:
        frame = self._camera.newest()
        return None if frame is None else replace(frame, stamp=frame.stamp - self._zero)

    def _wait(self) -> None:
        current = self._clock()
        # After a stall the schedule restarts instead of catching up.
        self._due = max(self._due + PERIOD, current - PERIOD)
        self._sleep(max(0.0, self._due - current))
