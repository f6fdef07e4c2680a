"""Worlds with forces: their interface and their settings, whichever engine computes them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol, runtime_checkable

from robot.geometry import Array
from robot.settings import check_settings, setting
from sim.world import World

GRAVITY = 9.81
"""Acceleration by gravity [m/s^2]."""


@dataclass(frozen=True)
class PhysicsSettings:
    """How the simulated motors and the floor behave, in every engine."""

    step_time: float = setting(0.002, "Time of one physics step", unit="s", low=0.0002, high=0.005)
    motor_lag: float = setting(
        0.080,
        "Time constant with which a wheel's speed follows its command; 0 is at once",
        unit="s",
        low=0,
        high=1,
    )
    friction: float = setting(
        1.0, "Friction coefficient mu of the tyres on the floor", low=0.001, high=2
    )
    caster_friction: float = setting(
        0.05, "Friction coefficient mu of the sliding caster on the floor", low=0, high=2
    )

    def __post_init__(self) -> None:
        check_settings(self)


@runtime_checkable
class PhysicsWorld(World, Protocol):
    """A world with forces: its motors follow a speed, or give a torque after ``add_rotors``."""

    def add_rotors(self, inertias: Array) -> None:
        """Add the motors' rotors to the wheels; inertias as seen at the joints (j,) [kg m^2].

        From now on the motors give a torque instead of following a speed: use ``hold`` and
        ``step_torques``, no longer ``step``. A rotor spins much faster than its wheel, so the
        robot's body feels almost no reaction when it speeds up.
        """
        ...

    def hold(self, frictions: Array) -> None:
        """Set the Coulomb friction at the joints (j,) [N m]; it stays until it is set again."""
        ...

    def step_torques(self, torques: Sequence[float]) -> None:
        """Advance one step with motor torques at the joints (j,) [N m] and ``hold``'s friction."""
        ...
