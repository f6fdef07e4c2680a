"""A driver on an emulated board, in simulated time: without threads, ports or a real clock."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np

from robot.cameras.camera import Camera
from robot.description.spec import RobotSpec
from robot.description.wiring import Wiring
from robot.geometry import Array
from robot.hat.board import BoardDriver
from robot.hat.build_hat import BuildHat
from robot.hat.settings import BuildHatSettings
from robot.hat.start.bring_up import BringUp
from robot.hat.start.firmware_image import FirmwareImage
from sim.hat.emulated_board import EmulatedBoard
from sim.hat.lego_motor import LegoMotor
from sim.hat.plants import FreeMotor, FreeMotors
from sim.hat_emulator.physics_wheels import PhysicsWheels, WheelMotor

MEDIUM = 0x30
DRIFTS = (0.004, -0.007, 0.002, -0.003)
"""Drift of each motor's own clock against the board's, by port."""

TICK_MS = 10
"""How often the serial link calls the driver."""


@dataclass
class Bricks:
    """Two motors on an emulated board, and the driver; both use the board's clock."""

    settings: BuildHatSettings = field(default_factory=BuildHatSettings)
    types: tuple[int, ...] = (MEDIUM, MEDIUM)
    """Types of the motors at ports A, B, ..."""
    wirings: Sequence[Wiring] | None = None
    """Joints of the driver; None: the wheels of the robot."""
    plants: FreeMotors | PhysicsWheels = field(default_factory=FreeMotors)
    warm: bool = True
    phase_ms: int = 3
    """Millisecond, within each 10 ms of the board's clock, at which the driver is called."""

    def __post_init__(self) -> None:
        self.spec = RobotSpec.load()
        self.devices = {
            port: LegoMotor(
                kind,
                self.plants.plant(port),
                mark=37.0 * port,
                phase=0.004 * port,
                drift=DRIFTS[port],
            )
            for port, kind in enumerate(self.types)
        }
        self.emulated = EmulatedBoard(self.plants, self.devices, warm=self.warm)
        wirings = self.wirings or self.spec.joints
        self.board = BoardDriver(wirings, self.settings, BringUp(FirmwareImage.installed))
        self.wanted: Array | None = None
        """Joint velocities that the program commands every 20 ms; None: the program hangs."""
        self.alive = True
        """Whether the driver is called."""
        self.sent = self.received = 0
        """Number of bytes to the board and from it."""
        self._ms = 0
        self._send(self.board.opened(self.now))

    @property
    def now(self) -> float:
        """The board's clock [s]."""
        return self.emulated.now

    def motor(self, port: int) -> FreeMotor | WheelMotor:
        """Return the motor at a port."""
        return self.plants.plant(port)

    def speeds(self) -> Array:
        """Return the speeds of the shafts [degree/s], in the motors' own direction."""
        return np.array([self.motor(port).speed for port in self.devices])

    def run(self, seconds: float) -> Array:
        """Let time pass; return time, both speeds and both angles (n, 5), one row a millisecond."""
        rows = []
        for _ in range(round(1000 * seconds)):
            self._step()
            motors = [self.motor(port) for port in (0, 1)]
            rows.append([self.now, *(m.speed for m in motors), *(m.angle for m in motors)])
        return np.array(rows)

    def until(self, condition: Callable[[], bool], seconds: float = 20.0) -> float:
        """Let time pass until a condition holds; return how long that took [s].

        Raises:
            TimeoutError: the condition did not hold within ``seconds``.
        """
        begin = self.now
        while not condition():
            if self.now - begin > seconds:
                raise TimeoutError(f"not within {seconds} s: {self.board.state(self.now)}")
            self._step()
        return self.now - begin

    def robot(self, camera: Camera) -> BuildHat:
        """Return the whole robot; time passes while it waits for its next reading."""
        return SteppedHat(
            self.spec, self.board, BricksWire(self), camera, lambda: self.now, self.wait
        )

    def wait(self, seconds: float) -> None:
        """Let time pass."""
        for _ in range(round(1000 * seconds)):
            self._step()

    def ready(self) -> bool:
        """Whether the joints follow commands."""
        return self.board.state(self.now).ready

    def stands(self) -> bool:
        """Whether no shaft turns faster than 1 degree/s."""
        return bool(np.abs(self.speeds()).max() < 1)

    def _step(self) -> None:
        data = self.emulated.advance(0.001)
        self._ms += 1
        if not self.alive:
            return
        if data:
            self.received += len(data)
            self._send(self.board.receive(data, self.now))
        if self._ms % TICK_MS != self.phase_ms:
            return
        if self.board.wants_reset:
            self.emulated.reset()
            self.board.was_reset(self.now)
        if self.wanted is not None and self._ms % (2 * TICK_MS) == self.phase_ms:
            self.board.command(self.wanted, self.now)
        self._send(self.board.tick(self.now))

    def _send(self, data: bytes) -> None:
        self.sent += len(data)
        self.emulated.receive(data)


class SteppedHat(BuildHat):
    """The real robot's driver, whose time passes by steps only."""

    in_real_time = False


class BricksWire:
    """The link of a robot whose driver is called by ``Bricks``."""

    failure: Exception | None = None

    def __init__(self, bricks: Bricks) -> None:
        self._bricks = bricks

    def start(self) -> None:
        """Do nothing: the board is open from the start."""

    def close(self) -> None:
        """Stop the motors, and end the calls of the driver."""
        if self._bricks.alive:
            self._bricks.alive = False
            self._bricks.emulated.receive(self._bricks.board.farewell())
