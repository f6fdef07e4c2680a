"""Figures of LEGO's angular motors: type numbers, speeds and torques."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from robot.errors import BrickPoseError

SUPPLY_V = 8.0
"""Nominal supply voltage of a Build HAT [V]."""

RAIL_V = 7.2
"""Voltage that reaches the motors with this supply [V]; it is proportional to the supply."""

USUAL = "medium angular"
"""Motor of a joint whose description names none."""
_MEDIUM = (7.2, 951.0, 0.138, 0.021, 0.022, 26_300.0)
_LARGE = (7.2, 951.0, 0.42, 0.023, 0.045, 20_000.0)
_SMALL = (6.0, 762.0, 0.053, 0.009, 0.010, 22_000.0)


class DeviceError(BrickPoseError, ValueError):
    """A device does not exist, or not have what was asked for; the message says what is valid."""


@dataclass(frozen=True, slots=True)
class MotorFigures:
    """Figures of one kind of motor, measured at ``volts``; torques are at the shaft.

    Speeds, stall torques, friction and accelerations are from Pybricks' ``motor_data.py`` and
    motor models. LEGO's own sheets give 10 to 17 % more speed and, for the large motor, 40 % less
    stall torque (its current is limited there), with a tolerance of 15 %.
    """

    name: str
    """Its name in commands: one word."""
    kind: str
    """Its name in a robot's description."""
    type_id: int
    volts: float
    """Voltage at which the figures were measured [V]."""
    no_load_speed: float
    """Speed without a load, with the motor's own friction [deg/s]."""
    stall_torque: float
    """Torque that stops the shaft [N m], extrapolated linearly from a moderate load."""
    friction: float
    """Coulomb friction while it turns [N m]."""
    breakaway: float
    """Friction at standstill [N m]."""
    acceleration: float
    """Acceleration from standstill without a load [deg/s^2]."""

    @property
    def time_constant(self) -> float:
        """Time constant of the speed without a load [s]: no-load speed over acceleration."""
        return self.no_load_speed / self.acceleration

    @property
    def torque(self) -> float:
        """Magnetic torque at standstill [N m]: the stall torque plus the friction."""
        return self.stall_torque + self.friction

    @property
    def speed_per_torque(self) -> float:
        """Speed that it loses to a load [deg/s per N m]: the slope of the torque-speed line."""
        return self.no_load_speed / self.stall_torque

    @property
    def gain(self) -> float:
        """Speed that it would reach without friction [deg/s per V]."""
        return self.torque * self.speed_per_torque / self.volts


MOTOR_FIGURES: Mapping[int, MotorFigures] = {
    item.type_id: item
    for item in (
        MotorFigures("medium", "medium angular", 0x30, *_MEDIUM),
        MotorFigures("large", "large angular", 0x31, *_LARGE),
        MotorFigures("small", "small angular", 0x41, *_SMALL),
        MotorFigures("medium-grey", "medium angular", 0x4B, *_MEDIUM),
        MotorFigures("large-grey", "large angular", 0x4C, *_LARGE),
    )
}
"""Figures by LEGO's type number. Breakaway is chosen so that a free motor starts at 10 % of full
drive (large) and 14 % (medium, small); the known range is 8 to 15 %."""


def figures_described(kind: str | None) -> MotorFigures:
    """Return the figures of a motor by its kind in a robot's description; None: a medium motor.

    Raises:
        DeviceError: there is no such kind; names the valid ones.
    """
    return _first("kind", kind or USUAL)


def figures_named(name: str) -> MotorFigures:
    """Return the figures of a motor by its name in commands.

    Raises:
        DeviceError: there is no such name; names the valid ones.
    """
    return _first("name", name)


def _first(field: str, wanted: str) -> MotorFigures:
    known: dict[str, MotorFigures] = {}
    for figures in MOTOR_FIGURES.values():
        known.setdefault(getattr(figures, field), figures)
    if wanted not in known:
        raise DeviceError(f"no motor is called {wanted!r}; valid are {', '.join(known)}")
    return known[wanted]
