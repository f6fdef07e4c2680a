"""Measures the rate and the delays of the engine's loop."""

from __future__ import annotations

import time

from app.engine.snapshot import LoopStatistics

SMOOTHING = 0.05
"""Weight of the newest value in the running means."""


class LoopMeter:
    """Running means of the loop's rate, its work and the camera's rate and delay."""

    def __init__(self) -> None:
        self._begun = 0.0
        self._period = 0.0
        self._work = 0.0
        self.frame_period = 0.0
        """Usual time between two pictures [s]; 0 before the second."""
        self._frame_stamp: float | None = None

    def begin(self) -> None:
        """Note that the robot has answered and the work of a tick begins."""
        clock = time.perf_counter()
        if self._begun:
            self._period = _smooth(self._period, clock - self._begun)
        self._begun = clock

    def frame(self, stamp: float, *, rested: bool = False) -> None:
        """Note a picture that was exposed at a stamp [s]; one after a rest tells no rate."""
        if self._frame_stamp is not None and stamp > self._frame_stamp and not rested:
            self.frame_period = _smooth(self.frame_period, stamp - self._frame_stamp)
        self._frame_stamp = stamp

    def end(self, stamp: float) -> LoopStatistics:
        """Note the end of a tick's work, and return its figures at the robot's time [s]."""
        self._work = _smooth(self._work, time.perf_counter() - self._begun)
        seen = self._frame_stamp
        return LoopStatistics(
            step_hz=_rate(self._period),
            step_ms=1e3 * self._work,
            frame_hz=_rate(self.frame_period),
            latency_ms=0.0 if seen is None else 1e3 * (stamp - seen),
        )


def _smooth(mean: float, value: float) -> float:
    return value if mean == 0.0 else mean + SMOOTHING * (value - mean)


def _rate(period: float) -> float:
    return 1.0 / period if period > 0 else 0.0
