"""LEGO angular motor as seen by its port: its description, its data, and its sampling times."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from enum import IntEnum

from sim.hat.motor_figures import MOTOR_FIGURES, DeviceError
from sim.hat.plants import Plant

SAMPLE_PERIOD = 0.01
"""Time between two data messages of a device [s]."""

CONNECT_SECONDS = 2.0
"""Usual time from plugging in until a device is usable [s]; real devices take up to 8 to 11 s."""
POWER, SPEED, POS, APOS, CALIB, STATS = range(6)
BAUD = 115200
HARDWARE_VERSION = 0x00000004
SOFTWARE_VERSION = 0x10000000
SPEED_UNIT = 10.0
"""One unit of SPEED [deg/s]."""
SPEED_LAG = 0.02
"""Time constant with which the motor smooths its speed [s]; the true one is not known, here it is
two samples."""


class ValueType(IntEnum):
    """Types of a mode's values on the wire; the numbers are those in the listing."""

    INT8 = 0
    INT16 = 1
    INT32 = 2

    @property
    def size(self) -> int:
        """Size of one value [bytes]."""
        return (1, 2, 4)[self]


@dataclass(frozen=True, slots=True)
class Mode:
    """One kind of data that a device can send."""

    name: str
    """Name of the mode; it may contain a blank."""
    unit: str
    """Unit of the values; it may be empty."""
    type: ValueType
    count: int
    """Number of values in one message."""
    chars: int
    """Number of characters that a display needs for one value."""
    dp: int
    """Number of digits after the decimal point."""
    raw: int
    """Largest raw value; the listing shows every smallest value as 0."""
    pct: int
    """Largest value in percent."""
    si: int
    """Largest value in ``unit``."""


MODES = (
    Mode("POWER", "PCT", ValueType.INT8, 1, 4, 0, raw=100, pct=100, si=100),
    Mode("SPEED", "PCT", ValueType.INT8, 1, 4, 0, raw=100, pct=100, si=100),
    Mode("POS", "DEG", ValueType.INT32, 1, 11, 0, raw=360, pct=100, si=360),
    Mode("APOS", "DEG", ValueType.INT16, 1, 3, 0, raw=179, pct=200, si=179),
    Mode("CALIB", "CAL", ValueType.INT16, 2, 5, 0, raw=3600, pct=100, si=3600),
    Mode("STATS", "MIN", ValueType.INT16, 14, 5, 0, raw=65535, pct=100, si=65535),
)


class LegoMotor:
    """Counts whole degrees of a plant's shaft, and samples them every 10 ms by its own clock.

    POS counts from the shaft's angle at power-up. APOS is -180..179, relative to a mark on the
    motor, so the next power-up does not change it. SPEED is the smoothed change of the angle since
    the last sample, in units of 10 degrees a second.
    """

    modes = MODES
    combinations = ((SPEED, POS, APOS),)
    pid_defaults = ((3000, 100, 9000, 1080), (12000, 1000, 80000, 0))

    def __init__(
        self,
        type_id: int,
        plant: Plant,
        *,
        mark: float = 0.0,
        phase: float = 0.0,
        drift: float = 0.0,
        connect_seconds: float = CONNECT_SECONDS,
    ) -> None:
        """Put one of the motors of ``MOTOR_FIGURES`` on a plant's shaft.

        Args:
            mark: the absolute angle at which the plant's angle is 0 [deg].
            phase: how much later than the board's clock its own samples are [s].
            drift: how much slower its clock runs than the board's, as a share. The board reports
                by its own clock, so the samples in reports have every age up to 10 ms.

        Raises:
            DeviceError: no angular motor has this type number.
        """
        if type_id not in MOTOR_FIGURES:
            valid = ", ".join(
                f"{number:02X} ({item.name})" for number, item in MOTOR_FIGURES.items()
            )
            raise DeviceError(f"no angular motor has type {type_id:02X}; valid are {valid}")
        self.type_id = type_id
        self.connect_seconds = connect_seconds
        self.responding = True
        """False: it is plugged in but no longer sends data."""
        self._plant = plant
        self._mark = mark
        self._phase = phase
        self._period = SAMPLE_PERIOD * (1 + drift)
        self._keep = math.exp(-SAMPLE_PERIOD / SPEED_LAG)
        self.power_up()

    def description(self, port: int) -> str:
        """Return what ``list`` prints for it at a port, 0 to 3: lines that end in CR LF.

        All smallest values are 0, because the firmware converts negative floats to unsigned
        numbers. ``nmodes`` is the highest mode number, not the number of modes.
        """
        lines = [
            f"P{port}: connected to active ID {self.type_id:02X}",
            f"type {self.type_id:02X}",
            f"  nmodes ={len(self.modes) - 1}",
            "  nview  =3",
            f"  baud   ={BAUD}",
            f"  hwver  ={HARDWARE_VERSION:08X}",
            f"  swver  ={SOFTWARE_VERSION:08X}",
        ]
        for number, mode in enumerate(self.modes):
            lines += _mode(number, mode)
        for slot, modes in enumerate(self.combinations):
            lines.append(f"  C{slot}: " + "+".join(f"M{mode}" for mode in modes))
        speed, position = self.pid_defaults
        lines.append("     speed PID: " + " ".join(f"{word:08X}" for word in speed))
        lines.append("  position PID: " + " ".join(f"{word:08X}" for word in position))
        return "".join(line + "\r\n" for line in lines)

    def power_up(self) -> None:
        """Switch its power on: POS counts from here."""
        self._angle = self._plant.angle
        self._smooth = 0.0
        self._samples: int | None = None
        self._start = self._count()
        self._latch()

    def sample(self, current: float) -> bool:
        """Measure if 10 ms have passed, or for the first time since power-up.

        Call it every millisecond, or as often as wanted, with the time of the board's clock [s],
        which never goes back. Returns whether there is a new message.
        """
        # The small term allows for the rounding of a clock that adds milliseconds.
        samples = math.floor((current - self._phase) / self._period + 1e-6)
        last = self._samples
        if not self.responding or (last is not None and samples <= last):
            return False
        self._measure_speed(0 if last is None else samples - last)
        self._samples = samples
        self._latch()
        return True

    def read(self, mode: int) -> tuple[int, ...]:
        """Return the newest values of a mode; POWER, CALIB and STATS are always zeros."""
        if mode == SPEED:
            return (self._speed,)
        if mode == POS:
            return (self._pos,)
        if mode == APOS:
            return (self._apos,)
        if not 0 <= mode < len(MODES):
            raise DeviceError(f"mode is {mode}; valid are 0 to {len(MODES) - 1}")
        return (0,) * MODES[mode].count

    def _measure_speed(self, periods: int) -> None:
        """Update the speed from the angle gained in ``periods`` sample periods; 0: first sample."""
        angle = self._plant.angle
        if periods > 0:
            raw = (angle - self._angle) / (periods * self._period)
            keep = self._keep**periods
            self._smooth = keep * self._smooth + (1 - keep) * raw
        self._angle = angle

    def _count(self) -> int:
        """Return whole degrees from the mark; the edges between them are fixed on the shaft."""
        return math.floor(self._plant.angle + self._mark + 0.5)

    def _latch(self) -> None:
        count = self._count()
        self._speed = max(-100, min(100, round(self._smooth / SPEED_UNIT)))
        self._pos = (count - self._start + 2**31) % 2**32 - 2**31
        self._apos = (count + 180) % 360 - 180


def _mode(number: int, mode: Mode) -> Iterator[str]:
    yield f"  M{number} {mode.name} SI = {mode.unit}"
    yield f"    format count={mode.count} type={mode.type:d} chars={mode.chars} dp={mode.dp}"
    ranges = (("RAW", mode.raw), ("PCT", mode.pct), ("SI", mode.si))
    yield "    " + "    ".join(f"{name}: {0:08X} {top:08X}" for name, top in ranges)
