"""The Build HAT with its motors, without a port and without a clock: bytes in, bytes out.

One thread talks to the board (``SerialLink``: ``receive`` and ``tick``), another asks for joint
velocities and looks at the joints (``command`` and ``state``). Whatever goes wrong, the motors
stop: the program's set-points end when they are not renewed, and so do those in the firmware,
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
from robot.hat.protocol import bootloader_events, commands, events
from robot.hat.protocol.decoder import Decoder
from robot.hat.settings import BuildHatSettings
from robot.hat.start.bring_up import BringUp
from robot.hat.supply import Supply

PULSE_S = 0.2
"""Length of the pulses: the motors stop by themselves so long after the last one [s]."""

RENEW_S = 0.08
"""A set-point that stays is sent again after this time [s]."""

COMMAND_S = 0.2
"""A command of the program ends after this time [s]."""

SILENT_S = 0.6
"""The board is asked for its voltage all the time; without an answer for so long it is gone, or
does not hear [s]."""

LIST_S = 3.0
"""How often it is asked for its devices while one is missing [s]."""

OLDEST_S = 0.05
"""A motor that has fallen silent keeps the others' positions back by no more than this [s]."""

STOP_AGAIN_S = 0.3
"""How often the motors are told to stop while something is wrong [s]."""

SOON_S = 1.0
"""A start that takes no longer than this is not worth a word [s]."""

MISHEARD_S = 0.1
"""An error so soon after a set-up may be about it [s]."""

DUTY_STEPS = 255
"""The firmware's pulse width has so many steps."""


@dataclass(frozen=True, slots=True)
class BoardState:
    """The joints at one moment."""

    stamp: float
    """When the motors were where they are said to be, on the program's clock [s]."""
    positions: Array = field(repr=False)
    """(j,) [rad]"""
    velocities: Array = field(repr=False)
    """(j,) [rad/s]"""
    ready: bool
    """Whether the joints follow commands."""
    faults: tuple[str, ...]
    """Why not, with the cure; empty too while the board has just begun to start."""
    supply_v: float | None
    """[V]"""


class Board:
    """Drives joints through a Build HAT; a ``Talker`` for the serial link."""

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
        """Duties that the firmware has, in steps."""
        self._sent_at = -math.inf
        self._set_up_at = self._listed = -math.inf
        self._answered = self._ready_at = -math.inf
        """When the board last told its voltage, and when it was found to be ready [s]."""
        self._begun = -math.inf
        self._open = False
        self._lost: str | None = None

    # What the serial link calls.

    @property
    def wants_reset(self) -> bool:
        """Whether the board must be reset by its pin."""
        return self.bring_up.wants_reset

    def was_reset(self, current: float) -> None:
        """It was."""
        with self._lock:
            self.bring_up.was_reset(current)

    def cannot_reset(self, reason: str, current: float) -> None:
        """It cannot be."""
        with self._lock:
            self.bring_up.cannot_reset(reason, current)

    def opened(self, current: float) -> bytes:
        """The port is open; returns what to ask first."""
        with self._lock:
            self._lost = None
            self._open = True
            self._decoder = Decoder()
            return self._begin(current)

    def lost(self, reason: str, current: float) -> None:
        """The port cannot be opened, or went away."""
        with self._lock:
            self._lost = reason
            self._open = False
            self._forget()

    def receive(self, data: bytes, current: float) -> bytes:
        """Bytes came; returns what to answer."""
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
        """A hundredth of a second passed; returns what to send."""
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
        """What stops the motors for good."""
        # Twice: a byte that is lost in the first can leave a motor at the old set-point.
        return 2 * commands.stop(self._by_port)

    # What the program calls.

    def command(self, velocities: Array, current: float) -> Array:
        """Ask for joint velocities (j,) [rad/s]; returns those that the joints will go for."""
        with self._lock:
            limits = self._limits if self._is_ready(current) else 0 * self._limits
            self._wanted = np.clip(velocities, -limits, limits)
            self._wanted_until = current + COMMAND_S
            return self._wanted.copy()

    def state(self, current: float) -> BoardState:
        """The joints, at a moment when all of them were sampled."""
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

    # Under the lock.

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
            case events.Supply(volts):
                self._answered = current
                self._supply.told(volts)
            case events.MotorPowerFault():
                return self._supply.fault("motor", current)
            case events.PortPowerFault():
                return self._supply.fault("port", current)
            case events.CommandError() if current - self._set_up_at < MISHEARD_S:
                for motor in self.motors:
                    motor.set_up_again()
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
        """Ask what is plugged in while a motor is missing: its arrival may not have been heard."""
        if all(motor.usable for motor in self.motors) or current - self._listed < LIST_S:
            return b""
        self._listed = current
        return commands.devices()

    def _set_up(self, current: float) -> bytes:
        """The next motor's set-up, one a tick: it takes 9 ms of wire."""
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
            slow = current - self._begun > SOON_S
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
            # Not pulses of zero: a bit that flips in one of them would be a wheel that turns.
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
    prompts = bootloader_events.BootloaderPrompt | bootloader_events.BootloaderVersion
    return isinstance(event, prompts | events.InitDone)
