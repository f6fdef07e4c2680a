"""Wheel encoders: they count the angle that the wheels turned, with slip, in whole degrees."""

from __future__ import annotations

import math
from collections import deque

import numpy as np

from robot.description.spec import RobotSpec
from robot.geometry import Array
from sim.imperfections import Imperfections

VELOCITY_SPAN = 0.1
"""Time over which velocity is the difference of positions [s]. One degree then is 10 degrees/s,
which is also the unit of speed of LEGO's motors."""


class Encoders:
    """Turns true joint positions into those that a driver reports, with slip and quantization.

    Slip is a relative error of each wheel that drifts slowly, a first-order autoregressive process
    in time: ``s' = a s + sd sqrt(1 - a^2) n`` with ``a = exp(-dt / slip_time)``. When a wheel rolls
    a distance, it turns by ``1 + s`` times the angle of that distance.
    """

    def __init__(
        self, spec: RobotSpec, imperfections: Imperfections, rng: np.random.Generator
    ) -> None:
        count = len(spec.joints)
        self._imperfections = imperfections
        self._rng = rng
        self._step = math.radians(imperfections.encoder_step)
        self._phase = self._step * rng.random(count)
        """Position of each wheel within its first encoder step [rad]."""
        self._slip = imperfections.slip_sd * rng.standard_normal(count)
        self._slipped = np.zeros(count)
        self._past: deque[tuple[float, Array, Array]] = deque()
        """Stamps, true positions and reported positions of the last readings."""

    def use(self, imperfections: Imperfections) -> None:
        """Slip otherwise from now on; what slipped before stays, and the step as well."""
        self._imperfections = imperfections

    def read(self, positions: Array, stamp: float) -> tuple[Array, Array]:
        """Return reported positions (j,) [rad] and velocities (j,) [rad/s] for true positions (j,).

        Raises:
            ValueError: the stamp [s] is not later than the last one.
        """
        if self._past:
            self._slide(positions, stamp)
        reported = positions + self._slipped
        if self._step > 0:
            reported = self._step * np.floor((reported + self._phase) / self._step)
        self._past.append((stamp, positions.copy(), reported))
        # Keep the newest reading that is at least ``VELOCITY_SPAN`` old, and all newer ones.
        while len(self._past) > 2 and self._past[1][0] <= stamp - VELOCITY_SPAN + 1e-9:
            self._past.popleft()
        earlier, _, before = self._past[0]
        velocities = (reported - before) / (stamp - earlier) if stamp > earlier else 0 * reported
        return reported.copy(), velocities

    def _slide(self, positions: Array, stamp: float) -> None:
        """Update the slip since the last reading, and add the angle that the wheels slipped."""
        last_stamp, last_positions, _ = self._past[-1]
        if stamp <= last_stamp:
            raise ValueError(f"a reading at {stamp:g} s follows one at {last_stamp:g} s")
        kept = math.exp((last_stamp - stamp) / self._imperfections.slip_time)
        drift = self._imperfections.slip_sd * math.sqrt(1 - kept * kept)
        self._slip = kept * self._slip + drift * self._rng.standard_normal(len(self._slip))
        self._slipped += self._slip * (positions - last_positions)
