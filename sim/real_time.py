"""Makes simulated time pass as fast as real time."""

from __future__ import annotations

import time
from collections import deque


class RealTime:
    """Waits until a simulated stamp is due; pass it to a simulated robot as ``wait``.

    By the finest clock: before Python 3.13, Windows' monotonic one ticks 64 times a second only.
    The schedule is fixed, so waiting does not drift. After a stall the schedule starts again at the
    present time instead of catching up.
    """

    def __init__(self, longest_lag: float = 0.1) -> None:
        self.busy: deque[float] = deque(maxlen=5000)
        """Times spent between two waits [s]: simulation and engine together."""
        self._longest_lag = longest_lag
        self._zero: float | None = None
        self._went_on = 0.0

    def __call__(self, stamp: float) -> None:
        """Sleep until a stamp [s]."""
        clock = time.perf_counter()
        if self._zero is None:
            self._zero = clock - stamp
        else:
            self.busy.append(clock - self._went_on)
        if clock - self._zero - stamp > self._longest_lag:
            self._zero = clock - stamp
        time.sleep(max(0.0, self._zero + stamp - clock))
        self._went_on = time.perf_counter()
