"""Driver of a Build HAT with its motors, without port and clock: bytes in, bytes out.

One thread talks to the board (``SerialLink``: ``receive`` and ``tick``). Another thread requests
joint velocities and reads the joints (``command`` and ``state``). Whatever goes wrong, the motors
stop: the program's set-points end when they are not renewed. So do the firmware's set-points,
which are pulses.
"""

from __future__ import annotations

import math
import threading
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from robot.description.wiring import Wiring
from robot.geometry import Array
from robot.hat.motor import LINE_TIME, Motor
from robot.hat.protocol import commands, events
from robot.hat.protocol.decoder import Decoder
from robot.hat.settings import BuildHatSettings
from robot.hat.start.bring_up import BringUp
from robot.hat.supply import Supply

PULSE_S = 0.2
"""Length of the pulses [s]: without a new one the motors stop by themselves after this time."""

RENEW_S = 0.08
"""An unchanged set-point is sent again after this time [s]."""

COMMAND_S = 0.2
"""A command of the program ends after this time [s]."""

SILENT_S = 0.6
"""The board is asked for its voltage all the time. Without an answer for this time [s], it is gone
or does not hear."""

LIST_S = 3.0
"""How often the board is asked for its devices while a motor is missing [s]."""

OLDEST_S = 0.05
"""A silent motor delays the positions of the others by at most this time [s]."""

STOP_AGAIN_S = 0.3
"""How often the motors are told to stop while they rest or something is wrong [s]."""

QUICK_START_S = 1.0
"""A start that takes no longer than this is not reported [s]."""

SETUP_ERROR_S = 0.1
"""A command error within this time after a set-up may be about the set-up [s]."""

DUTY_STEPS = 255
"""Number of steps of the firmware's pulse width."""


@dataclass(frozen=True, slots=True, eq=False)
class BoardState:
    """The joints at one moment."""

    stamp: float
    """When the motors were at these positions, on the program's clock [s]."""
    positions: Array = field(repr=False)
    """(j,) [rad]"""
    velocities: Array = field(repr=False)
    """(j,) [rad/s]"""
    ready: bool
    """Whether the joints follow commands."""
    faults: tuple[str, ...]
    """Why they do not follow commands, with the cure; also empty just after the start begins."""
    supply_v: float | None
    """Voltage of the supply [V]; None while unknown."""


class BoardDriver:
    """Drives joints through a Build HAT."""

    def __init__(
        self, wirings: Sequence[Wiring], settings: BuildHatSettings, bring_up: BringUp
    ) -> None:
        self.bring_up = bring_up
        self.motors = [Motor(wiring, settings) for wiring in wirings]
        self._by_port = {motor.port: motor for motor in self.motors}
        self._settings = settings
        self._supply = Supply(settings.low_supply)
        self._decoder = Decoder()
        self._lock = threading.Lock()
        self._limits = np.array([wiring.max_velocity for wiring in wirings])
        self._wanted = np.zeros(len(wirings))
        self._wanted_until = -math.inf
        self._sent: dict[int, int] = {}
        """Duty in steps that the firmware has, by port."""
        self._sent_at = -math.inf
        self._set_up_at = self._listed = -math.inf
        self._answered = self._ready_at = -math.inf
        """When the board last reported its voltage, and when it became ready [s]."""
        self._begun = -math.inf
        self._open = False
        self._lost: str | None = None

    # Called by the serial link.

    @property
    def wants_reset(self) -> bool:
        """Whether the board must be reset by its pin."""
        return self.bring_up.wants_reset

    def was_reset(self, current: float) -> None:
        """Take note that the board was reset by its pin."""
        with self._lock:
            self.bring_up.was_reset(current)

    def cannot_reset(self, reason: str, current: float) -> None:
        """Take note that the board cannot be reset by its pin."""
        with self._lock:
            self.bring_up.cannot_reset(reason, current)

    def opened(self, current: float) -> bytes:
        """Begin with an open port; return what to send first."""
        with self._lock:
            self._lost = None
            self._open = True
            self._decoder = Decoder()
            return self._begin(current)

    def lost(self, reason: str, current: float) -> None:
        """Take note that the port cannot be opened, or is gone; the reason includes the cure."""
        with self._lock:
            self._lost = reason
            self._open = False
            self._forget()

    def receive(self, data: bytes, current: float) -> bytes:
        """Take bytes of the board; return what to send."""
        with self._lock:
            result = self._decoder.feed(data)
            answer = b""
            if self.bring_up.ready and any(map(_is_restart, result)):
                answer = self._begin(current)
            if not self.bring_up.ready:
                answer += self.bring_up.receive(result, current)
                self._ready_at = self._listed = current
            return answer + b"".join(self._take(event, current) for event in result)

    def tick(self, current: float) -> bytes:
        """Do the work of one tick, every hundredth of a second; return what to send."""
        with self._lock:
            if not self.bring_up.ready:
                return self.bring_up.tick(current)
            if current - max(self._answered, self._ready_at) > SILENT_S:
                return self._begin(current)
            return (
                self._list(current)
                + self._set_up(current)
                + self._supply.ask(current)
                + self._drive(current)
            )

    def farewell(self) -> bytes:
        """Return the bytes that stop the motors for good."""
        # Sent twice: if a byte of the first is lost, a motor can stay at the old set-point.
        return 2 * commands.stop(self._by_port)

    # Called by the program.

    def command(self, velocities: Array, current: float) -> Array:
        """Request joint velocities (j,) [rad/s]; return those that the joints really aim for."""
        with self._lock:
            limits = self._limits if self._is_ready(current) else 0 * self._limits
            self._wanted = np.clip(velocities, -limits, limits)
            self._wanted_until = current + COMMAND_S
            return self._wanted.copy()

    def state(self, current: float) -> BoardState:
        """Return the joints at a moment when all of them were sampled."""
        with self._lock:
            ready = self._is_ready(current)
            stamp = current - LINE_TIME - self._settings.encoder_delay
            if ready:
                oldest = min(motor.track.newest_stamp for motor in self.motors)
                stamp = max(oldest, stamp - OLDEST_S)
            return BoardState(
                stamp,
                np.array([motor.angle(stamp) for motor in self.motors]),
                np.array([motor.velocity if ready else 0.0 for motor in self.motors]),
                ready,
                tuple(self._faults(current)),
                self._supply.volts,
            )

    # Called with the lock held.

    def _begin(self, current: float) -> bytes:
        self._forget()
        self._begun = current
        return self.bring_up.begin(current)

    def _forget(self) -> None:
        self._supply.forget()
        self._sent.clear()
        for motor in self.motors:
            motor.unplugged()

    def _take(self, event: events.Event, current: float) -> bytes:
        match event:
            case events.SupplyVoltage(volts):
                self._answered = current
                self._supply.take_voltage(volts)
            case events.MotorPowerFault():
                return self._supply.fault("motor", current)
            case events.PortPowerFault():
                return self._supply.fault("port", current)
            case events.CommandRefused() if current - self._set_up_at < SETUP_ERROR_S:
                for motor in self.motors:
                    motor.invalidate_setup()
            case _:
                self._take_from_port(event, current)
        return b""

    def _take_from_port(self, event: events.Event, current: float) -> None:
        motor = self._by_port.get(getattr(event, "port", -1))
        if motor is None:
            return
        match event:
            case events.Connected(type_id=type_id) | events.Established(type_id=type_id):
                motor.plugged(type_id, current)
            case events.Disconnected() | events.NoDevice() | events.ConnectionFailed():
                motor.unplugged()
            case events.CombiData(slot=0, values=values):
                motor.report(values, current)

    def _list(self, current: float) -> bytes:
        """Ask for the devices while a motor is missing: its arrival may not have been heard."""
        if all(motor.usable for motor in self.motors) or current - self._listed < LIST_S:
            return b""
        self._listed = current
        return commands.devices()

    def _set_up(self, current: float) -> bytes:
        """Return the next motor's set-up, one per tick: it takes 9 ms on the wire."""
        for motor in self.motors:
            line = motor.set_up(current)
            if line:
                self._set_up_at = current
                self._sent, self._sent_at = {}, -math.inf
                return line
        return b""

    def _is_ready(self, current: float) -> bool:
        return (
            self._open
            and self.bring_up.ready
            and all(motor.is_ready(current) for motor in self.motors)
            and not self._supply.complaints(current)
        )

    def _faults(self, current: float) -> list[str]:
        if not self._open:
            return [self._lost] if self._lost else []
        if not self.bring_up.ready:
            if self.bring_up.trouble:
                return [self.bring_up.trouble]
            slow = current - self._begun > QUICK_START_S
            return [f"The Build HAT is starting: {self.bring_up.stage.value}."] if slow else []
        motors = [motor.fault(current) for motor in self.motors]
        return self._supply.complaints(current) + [fault for fault in motors if fault]

    def _drive(self, current: float) -> bytes:
        if not self._is_ready(current):
            return self._stop(current)
        wanted = self._wanted if current < self._wanted_until else 0 * self._wanted
        duties = {
            motor.port: round(DUTY_STEPS * motor.duty(float(velocity), current, self._supply.volts))
            for motor, velocity in zip(self.motors, wanted, strict=True)
        }
        resting = not any(duties.values())
        due = current - self._sent_at >= (STOP_AGAIN_S if resting else RENEW_S)
        if duties == self._sent and not due:
            return b""
        self._sent, self._sent_at = duties, current
        if resting:
            # No pulses of zero are sent: a flipped bit in one of them would make a wheel turn.
            return commands.stop(self._by_port)
        return commands.pulses({port: duty / DUTY_STEPS for port, duty in duties.items()}, PULSE_S)

    def _stop(self, current: float) -> bytes:
        for motor in self.motors:
            motor.rest()
        if not self._sent and current - self._sent_at < STOP_AGAIN_S:
            return b""
        self._sent, self._sent_at = {}, current
        return commands.stop(self._by_port)


def _is_restart(event: events.Event) -> bool:
    prompts = events.BootloaderPrompt | events.BootloaderVersion
    return isinstance(event, prompts | events.InitDone)
