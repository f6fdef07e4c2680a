"""The motor driver of a port: from a wanted drive to the pulses of an H-bridge."""

from __future__ import annotations

import math

from sim.hat.firmware.single import clamped

ONE = 65536
"""Full drive in the firmware's fixed point."""

STEPS = 255
"""Full drive in steps of the driver chip."""

FIRST_LIMIT = 6554
"""A tenth: what a port may put out until it is told otherwise."""


def fixed_point(part: float) -> int:
    """A part of full drive, brought to 0..1, in fixed point."""
    return int(clamped(part, 0, 1) * ONE + 0.5)


class Bridge:
    """Small drives are made of whole 10 ms slots at the threshold, in the right proportion."""

    __slots__ = ("_owed", "least", "limit", "steps", "threshold")

    def __init__(self) -> None:
        self.reset()

    def reset(self) -> None:
        """As after a start or a disconnection: a tenth of full drive, no threshold, braking."""
        self.limit = FIRST_LIMIT
        self.threshold = 0
        """Drives below it are made of slots."""
        self.least = 0
        """Drives below it are none."""
        self._owed = 0
        self.steps: int | None = 0
        """What the chip puts out, -255..255; None: it is switched off."""

    @property
    def duty(self) -> float | None:
        """What it puts out, -1..1; 0 brakes, None coasts."""
        return None if self.steps is None else self.steps / STEPS

    def coast(self) -> None:
        """Let the motor run out."""
        self.steps = None

    def drive(self, wanted: float) -> None:
        """Put out a drive, limited to -1..1 and then to ``limit``; called every 10 ms."""
        doubled = 0 if math.isnan(wanted) else int(clamped(wanted, -1, 1) * 2 * ONE)
        demand = int((doubled + 1) / 2)
        if abs(demand) < self.least:
            demand = 0
        if abs(demand) < self.threshold:
            demand = self._slot(demand)
        demand = max(-self.limit, min(self.limit, demand))
        # The chip's steps are rounded down, also below zero: what the firmware's shift does.
        self.steps = (demand * STEPS + STEPS // 2) >> 16

    def _slot(self, demand: int) -> int:
        self._owed += demand
        if self._owed >= self.threshold:
            slot = self.threshold
        elif self._owed <= -self.threshold:
            slot = -self.threshold
        else:
            slot = 0
        self._owed -= slot
        return slot
