"""From the robot's clock to ROS time."""

from __future__ import annotations

import threading
import time

from app.engine.snapshot import Snapshot

JUMPED_NS = 200_000_000
"""Wall clock and robot apart by more mean that one of them was set."""

OLD_S = 1.0
"""Nobody has looked at the clocks for so long: one may have been set meanwhile."""


class RosClock:
    """Nanoseconds since 1970 at the robot's stamps.

    The difference between the two clocks is taken once, so that what is stamped keeps its
    distances. It is taken anew when they have come apart: a Pi without a battery learns the date
    from the network minutes after its start, and a replay jumps.
    """

    def __init__(self) -> None:
        self._offset: int | None = None
        self._holders = 0
        self._followed = 0.0
        """When that was, on the computer's monotonic clock [s]."""
        self._lock = threading.Lock()

    def follow(self, snapshot: Snapshot) -> None:
        """Look whether the clocks still agree; called with each tick."""
        looked = time.monotonic()
        age = looked - snapshot.published
        current = time.time_ns() - round(age * 1e9)  # the wall clock when it was published
        offset = current - round(snapshot.stamp * 1e9)
        with self._lock:
            self._followed = looked
            apart = self._offset is None or abs(offset - self._offset) > JUMPED_NS
            if self._offset is None or (apart and not self._holders):
                self._offset = offset

    def ns(self, stamp: float) -> int:
        """ROS time [ns] at a stamp of the robot [s]."""
        return round(stamp * 1e9) + (self._offset or 0)

    def age(self, time_ns: int) -> float:
        """How long ago a ROS time was by the wall clock [s]."""
        return (time.time_ns() - time_ns) / 1e9

    def hold(self) -> None:
        """Keep the difference, whatever happens: what is recorded has one time.

        One that nobody has looked at lately is taken once more, with the next tick: the clock may
        have been set since the last recording.
        """
        with self._lock:
            if not self._holders and time.monotonic() - self._followed > OLD_S:
                self._offset = None
            self._holders += 1

    def let_go(self) -> None:
        """Follow the clocks again."""
        with self._lock:
            self._holders -= 1
