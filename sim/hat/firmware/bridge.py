"""Motor driver of a port: converts a wanted drive to the pulses of an H-bridge."""

from __future__ import annotations

import math

from sim.hat.firmware.variables import clamped

ONE = 65536
"""Full drive in the firmware's fixed point."""

STEPS = 255
"""Full drive in steps of the driver chip."""

FIRST_LIMIT = 6554
"""Largest drive of a port until it is set: a tenth of full drive."""


def fixed_point(part: float) -> int:
    """Return a share of full drive, clipped to 0..1, in fixed point."""
    return int(clamped(part, 0, 1) * ONE + 0.5)


class Bridge:
    """Motor driver; it makes small drives from the right share of 10 ms slots at the threshold."""

    __slots__ = ("_owed", "least", "limit", "steps", "threshold")

    def __init__(self) -> None:
        self.reset()

    def reset(self) -> None:
        """Reset as after a start or a disconnection: limit a tenth, no threshold, braking."""
        self.limit = FIRST_LIMIT
        self.threshold = 0
        """Smaller drives are made of slots."""
        self.least = 0
        """Smaller drives become 0."""
        self._owed = 0
        self.steps: int | None = 0
        """Output of the chip, -255..255; None: it is switched off."""

    @property
    def duty(self) -> float | None:
        """Output, -1..1; 0 brakes, None coasts."""
        return None if self.steps is None else self.steps / STEPS

    def coast(self) -> None:
        """Let the motor coast."""
        self.steps = None

    def drive(self, wanted: float) -> None:
        """Put out a drive, clipped to -1..1 and then to ``limit``; called every 10 ms."""
        doubled = 0 if math.isnan(wanted) else int(clamped(wanted, -1, 1) * 2 * ONE)
        demand = int((doubled + 1) / 2)
        if abs(demand) < self.least:
            demand = 0
        if abs(demand) < self.threshold:
            demand = self._slot(demand)
        demand = max(-self.limit, min(self.limit, demand))
        # The firmware's shift rounds the chip's steps down, also below zero.
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
