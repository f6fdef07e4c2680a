"""Wheel encoders: whole degrees of what the wheels turned, which is not quite what they rolled."""

from __future__ import annotations

import math
from collections import deque

import numpy as np

from robot.description.spec import RobotSpec
from robot.geometry import Array
from sim.imperfections import Imperfections

VELOCITY_SPAN = 0.1
"""Velocity is the difference over this time [s]: 1 degree then is 10 degrees/s, which is also the
unit in which LEGO's motors tell their speed."""


class Encoders:
    """Turns true joint positions into what a driver would report, with slip and counting.

    Slip is a relative error of each wheel that drifts slowly, a first-order autoregressive process
    in time: ``s' = a s + sd sqrt(1 - a^2) n`` with ``a = exp(-dt / slip_time)``. A wheel that rolls
    a distance has turned by ``1 + s`` times the angle that belongs to it.
    """

    def __init__(
        self, spec: RobotSpec, imperfections: Imperfections, rng: np.random.Generator
    ) -> None:
        count = len(spec.joints)
        self._imperfections = imperfections
        self._rng = rng
        self._step = math.radians(imperfections.encoder_step)
        self._phase = self._step * rng.random(count)
        """How far each wheel stands into its first degree."""
        self._slip = imperfections.slip_sd * rng.standard_normal(count)
        self._slipped = np.zeros(count)
        self._past: deque[tuple[float, Array, Array]] = deque()
        """Stamp, true positions and reported ones of the last readings."""

    def read(self, positions: Array, stamp: float) -> tuple[Array, Array]:
        """Reported positions (j,) [rad] and velocities (j,) [rad/s] from true positions (j,) [rad].

        Raises:
            ValueError: the stamp [s] is not later than the last one.
        """
        if self._past:
            self._slide(positions, stamp)
        reported = self._count(positions + self._slipped)
        self._past.append((stamp, positions.copy(), reported))
        # Of the readings that are old enough, the newest one stays.
        while len(self._past) > 2 and self._past[1][0] <= stamp - VELOCITY_SPAN + 1e-9:
            self._past.popleft()
        earlier, _, before = self._past[0]
        velocities = (reported - before) / (stamp - earlier) if stamp > earlier else 0 * reported
        return reported.copy(), velocities

    def _slide(self, positions: Array, stamp: float) -> None:
        """Let slip drift since the last reading, and add up what it makes of the turn since."""
        last_stamp, last_positions, _ = self._past[-1]
        if stamp <= last_stamp:
            raise ValueError(f"a reading at {stamp:g} s follows one at {last_stamp:g} s")
        kept = math.exp((last_stamp - stamp) / self._imperfections.slip_time)
        drift = self._imperfections.slip_sd * math.sqrt(1 - kept * kept)
        self._slip = kept * self._slip + drift * self._rng.standard_normal(len(self._slip))
        self._slipped += self._slip * (positions - last_positions)

    def _count(self, turned: Array) -> Array:
        if self._step == 0:
            return turned
        return self._step * np.floor((turned + self._phase) / self._step)
