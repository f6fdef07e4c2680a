"""LEGO's angular motors in figures: who they are and how fast and strong they turn."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

SUPPLY_V = 8.0
"""What a Build HAT should be supplied with [V]."""

RAIL_V = 7.2
"""What reaches the motors then [V]; with another supply in proportion."""

USUAL = "medium angular"
"""What drives a joint whose description leaves it open."""


class KindError(ValueError):
    """No motor of that kind is known."""


@dataclass(frozen=True, slots=True)
class MotorFigures:
    """Of one kind of motor, as measured at ``volts``; torques at the shaft.

    Speeds, stall torques, friction and accelerations are those of Pybricks' ``motor_data.py`` and
    motor models. LEGO's own sheets give 10 to 17 % more speed and, for the large motor, 40 % less
    stall torque (its current is limited there), with a tolerance of 15 %.
    """

    name: str
    """What commands call it: one word."""
    kind: str
    """What a robot's description calls it."""
    type_id: int
    volts: float
    """At which the figures were measured [V]."""
    no_load_speed: float
    """[deg/s], with the motor's own friction."""
    stall_torque: float
    """What holds the shaft still [N m], extrapolated linearly from a moderate load."""
    friction: float
    """Coulomb friction while it turns [N m]."""
    breakaway: float
    """Friction that holds it while it stands [N m]."""
    acceleration: float
    """From standstill without a load [deg/s^2]."""

    @property
    def time_constant(self) -> float:
        """Of the speed without a load [s]: no-load speed over initial acceleration."""
        return self.no_load_speed / self.acceleration

    @property
    def torque(self) -> float:
        """Of the magnet field alone, at standstill [N m]: what is seen, and the friction."""
        return self.stall_torque + self.friction

    @property
    def speed_per_torque(self) -> float:
        """How much a load slows it down [deg/s per N m]: the slope of the torque-speed line."""
        return self.no_load_speed / self.stall_torque

    @property
    def gain(self) -> float:
        """Speed that it would reach without any friction [deg/s per V]."""
        return self.torque * self.speed_per_torque / self.volts


_MEDIUM = (7.2, 951.0, 0.138, 0.021, 0.022, 26_300.0)
_LARGE = (7.2, 951.0, 0.42, 0.023, 0.045, 20_000.0)
_SMALL = (6.0, 762.0, 0.053, 0.009, 0.010, 22_000.0)

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
"""By LEGO's type number. Breakaway is chosen so that a free motor starts at 10 % of full drive
(large) and 14 % (medium, small); what is known is 8 to 15 %."""


def figures_described(kind: str | None) -> MotorFigures:
    """Of what a robot's description calls a joint's motor; a medium one where it leaves that open.

    Raises:
        KindError: there is none; names those there are.
    """
    return _first("kind", kind or USUAL)


def figures_named(name: str) -> MotorFigures:
    """Of the motor that commands call so.

    Raises:
        KindError: there is none; names those there are.
    """
    return _first("name", name)


def _first(field: str, wanted: str) -> MotorFigures:
    known: dict[str, MotorFigures] = {}
    for figures in MOTOR_FIGURES.values():
        known.setdefault(getattr(figures, field), figures)
    if wanted not in known:
        raise KindError(f"no motor is called {wanted!r}; valid are {', '.join(known)}")
    return known[wanted]
