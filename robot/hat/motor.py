"""One joint's motor: which device is plugged in, whether it is usable, and how far it turned."""

from __future__ import annotations

import math

from robot.description.wiring import KINDS, PORTS, Wiring, described
from robot.hat.joint_track import JointTrack
from robot.hat.protocol import commands
from robot.hat.settings import BuildHatSettings
from robot.hat.speed_loop import SpeedLoop

EACH_SAMPLE = 0
"""Report period [ms]: zero reports each new position of the motor at once. With a period of the
board's own clock, a report would be up to 10 ms old, and its age would change with the drift of
the two clocks."""

LINE_TIME = 0.002
"""Time of a report of 23 bytes on the wire at 115200 baud [s]."""

QUIET_S = 0.3
"""A motor that sends no report for this time is not trusted, and is set up again [s]."""

HELD_S = 1.0
"""How long a motor that did not turn is not driven [s]."""

SPEED_SPAN = 0.1
"""Speed is measured over this time [s]; 1 degree in it is 10 degrees/s."""


class Motor:
    """A port of the Build HAT that a joint is wired to."""

    def __init__(self, wiring: Wiring, settings: BuildHatSettings) -> None:
        self.wiring = wiring
        self.port = PORTS.index(wiring.port)
        """0 to 3, as the firmware counts."""
        self.track = JointTrack()
        self._settings = settings
        self._type: int | None = None
        """Type id of the device that is plugged in; None if there is none or it is not known."""
        self._loop: SpeedLoop | None = None
        self._set_up = -math.inf
        """When the motor was last set up [s]."""
        self._heard = -math.inf
        """When the motor last reported its position [s]."""
        self._held_until = -math.inf
        self._asked = 0
        """How often the motor was set up since it was plugged in."""

    @property
    def usable(self) -> bool:
        """Whether the right kind of motor is plugged in."""
        return self._loop is not None

    def plugged(self, type_id: int, current: float) -> None:
        """Take a device's type; the device must be set up, unless it is known and reporting."""
        if type_id == self._type and current - self._heard < QUIET_S:
            return
        self._type = type_id
        kind = KINDS.get(type_id)
        fits = kind is not None and self.wiring.motor in (None, kind.kind)
        self._loop = SpeedLoop(kind, self._settings.position_gain) if kind and fits else None
        self._begin_anew()

    def unplugged(self) -> None:
        """Take note that no device is plugged in; the joint's angle stays known."""
        self._type = self._loop = None
        self._begin_anew()

    def _begin_anew(self) -> None:
        self.track.begin_anew()
        self._asked = 0
        self._set_up = self._heard = -math.inf

    def report(self, values: tuple[float, ...], current: float) -> None:
        """Take speed, position and absolute position, which arrived at a moment [s]."""
        if self._loop is None or len(values) != 3 or math.isinf(self._set_up):
            return
        sampled = current - LINE_TIME - self._settings.encoder_delay
        if self.track.report(sampled, values[1], values[2]):
            self._heard = current

    def set_up(self, current: float) -> bytes:
        """Return the set-up (reports on, power limit raised) if it is due now; else nothing."""
        heard = max(self._heard, self._set_up)
        if self._loop is None or current - heard < QUIET_S:
            return b""
        self._set_up = current
        self._asked += 1
        self._loop.rest()
        return commands.set_up_motor(self.port, EACH_SAMPLE, self._settings.power_limit)

    def invalidate_setup(self) -> None:
        """Request another set-up: the last one may not have been understood."""
        self._set_up = self._heard = -math.inf

    def is_ready(self, current: float) -> bool:
        """Return whether the motor is the right one, reports its position and turns on command."""
        tells = self._loop is not None and current - self._heard < QUIET_S
        return tells and current >= self._held_until

    def fault(self, current: float) -> str | None:
        """Return why the motor cannot be used, and what to do; None also just after its arrival."""
        where = f"port {self.wiring.port} ({self.wiring.name})"
        if self._type is None:
            return (
                f"No motor answers on {where}: push its plug in until it clicks; "
                "right after the start it takes up to ten seconds."
            )
        if self._loop is None:
            wanted = f"{self.wiring.motor} motor" if self.wiring.motor else "motor with an encoder"
            return f"On {where} is a {described(self._type)}; there should be a {wanted}."
        if current < self._held_until:
            return f"The motor on {where} does not turn: is the wheel blocked, or the plug loose?"
        if self._asked > 1 and not self.is_ready(current):
            return f"The motor on {where} does not tell its position; it is asked again."
        return None

    def duty(self, velocity: float, current: float, supply_v: float | None) -> float:
        """Return the duty, -1 to 1 in the port's direction, for a joint velocity [rad/s]."""
        assert self._loop is not None
        wanted = math.degrees(velocity) * self.wiring.direction
        duty = self._loop.update(wanted, current, self.track, supply_v)
        if self._loop.is_held:
            self._held_until = current + HELD_S
        return duty

    def rest(self) -> None:
        """Set the duty to zero and forget the lag."""
        if self._loop is not None:
            self._loop.rest()

    def angle(self, stamp: float) -> float:
        """Return the joint position at a moment [rad]."""
        return math.radians(self.track.at(stamp)) * self.wiring.direction

    @property
    def velocity(self) -> float:
        """Joint velocity [rad/s]."""
        return math.radians(self.track.speed(SPEED_SPAN)) * self.wiring.direction
