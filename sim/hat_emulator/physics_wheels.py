"""LEGO motors on the wheels of the world with forces, driven by the board's drivers."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping

import numpy as np

from robot.description.spec import RobotSpec
from robot.description.wiring import PORTS
from sim.hat.motor_figures import RAIL_V, SUPPLY_V, DeviceError, MotorFigures, figures_described
from sim.hat.plants import FreeMotor, FreeMotors
from sim.physics import PhysicsWorld

BLOCKED = 100.0
"""Friction torque of a blocked shaft [N m]: far more than any motor's torque."""


class WheelMotor:
    """A motor on a wheel's axle; a ``Plant``.

    While the driver is on, the torque on the shaft is ``(gain V - w) / s``, where s is the slope of
    the torque-speed line; while the motor coasts, it is 0. Friction always acts. The rotor's
    inertia is ``tau / s``, so that a free motor has the time constant tau. The physics computes how
    the torque accelerates rotor, wheel and robot.
    """

    def __init__(self, figures: MotorFigures, direction: int) -> None:
        self.figures = figures
        self.angle = 0.0
        """Angle of the shaft [deg], clockwise is positive."""
        self.speed = 0.0
        """Speed of the shaft [deg/s]."""
        self.duty: float | None = None
        self.stalled = False
        """Whether something blocks the wheel."""
        self.load = 0.0
        """Torque [N m] that turns the shaft anticlockwise."""
        self._direction = direction
        self._gain = figures.gain * RAIL_V / SUPPLY_V

    @property
    def inertia(self) -> float:
        """Inertia of the rotor, as seen at the shaft [kg m^2]."""
        return self.figures.time_constant / math.radians(self.figures.speed_per_torque)

    @property
    def friction(self) -> float:
        """Coulomb friction [N m]; it also holds a blocked wheel."""
        return BLOCKED if self.stalled else self.figures.friction

    def drive(self, duty: float | None) -> None:
        """Set the share of its voltage that the driver puts out, -1..1; see ``Plant``.

        Raises:
            DeviceError: the duty is outside -1..1, or not a number.
        """
        if duty is not None and not -1 <= duty <= 1:
            raise DeviceError(f"duty is {duty}; valid is -1 to 1, or None to coast")
        self.duty = duty

    def torque(self, supply_v: float) -> float:
        """Return the torque on the joint [N m], positive forward, without the friction."""
        torque = -self.load
        if self.duty is not None:
            free_speed = self._gain * supply_v * self.duty
            torque += (free_speed - self.speed) / self.figures.speed_per_torque
        return self._direction * torque

    def follow(self, position: float, velocity: float) -> None:
        """Set angle and speed from the joint's position [rad] and velocity [rad/s]."""
        self.angle = self._direction * math.degrees(position)
        self.speed = self._direction * math.degrees(velocity)


def ignore_step(current: float) -> None:
    """Do nothing after a step."""


class PhysicsWheels:
    """Motors on the wheels of a world, and free motors at the other ports; ``Plants``.

    The physics has its own step time; it makes a step whenever one is due.
    """

    def __init__(
        self,
        world: PhysicsWorld,
        spec: RobotSpec,
        figures: Mapping[int, MotorFigures] | None = None,
        watch: Callable[[float], None] = ignore_step,
    ) -> None:
        """Put motors on a world that was made from ``spec``.

        Args:
            figures: figures of the motors by port, 0 to 3; the default is the motor in ``spec``.
            watch: called with the time that has passed [s] after each step of the physics.
        """
        figures = dict(figures or {})
        for joint in spec.joints:
            figures.setdefault(PORTS.index(joint.port), figures_described(joint.motor))
        self.now = 0.0
        """Time of the physics [s]."""
        self._world = world
        self._watch = watch
        self._due = 0.0
        self._supply_v = SUPPLY_V
        self._free = FreeMotors(figures)
        self._wheels = [
            WheelMotor(figures[PORTS.index(joint.port)], joint.direction) for joint in spec.joints
        ]
        self._by_port = {
            PORTS.index(joint.port): wheel
            for joint, wheel in zip(spec.joints, self._wheels, strict=True)
        }
        self._friction = np.full(len(self._wheels), np.nan)
        world.add_rotors(np.array([wheel.inertia for wheel in self._wheels]))
        self._follow()

    @property
    def supply_v(self) -> float:
        """Supply voltage of the board [V]."""
        return self._supply_v

    @supply_v.setter
    def supply_v(self, volts: float) -> None:
        self._supply_v = self._free.supply_v = volts

    def plant(self, port: int) -> FreeMotor | WheelMotor:
        """Return the motor at a port.

        Raises:
            DeviceError: a port outside 0..3.
        """
        free = self._free.plant(port)
        return self._by_port.get(port, free)

    def step(self, seconds: float) -> None:
        """Let time pass [s]."""
        self._free.step(seconds)
        self._due += seconds
        while self.now + self._world.step_time <= self._due + 1e-9:
            self._step()

    def _step(self) -> None:
        friction = np.array([wheel.friction for wheel in self._wheels])
        if not np.array_equal(friction, self._friction):
            self._friction = friction
            self._world.hold(friction)
        self._world.step_torques([wheel.torque(self._supply_v) for wheel in self._wheels])
        self._follow()
        self.now += self._world.step_time
        self._watch(self.now)

    def _follow(self) -> None:
        states = zip(self._world.positions, self._world.velocities, strict=True)
        for wheel, (position, velocity) in zip(self._wheels, states, strict=True):
            wheel.follow(float(position), float(velocity))
