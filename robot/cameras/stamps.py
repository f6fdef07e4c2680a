"""From what a driver tells of a picture's time to the middle of the exposure of the middle row."""

from __future__ import annotations

import time

LONGEST_WAY_S = 1.0
"""A picture that came is no older [s]; a stamp that says so is of another clock."""


def middle_of_exposure(readout_start: float, exposure: float, readout: float) -> float:
    """The middle of the exposure of the middle row [s].

    Args:
        readout_start: when the first row began to be read out [s], which is when its exposure
            ended: a rolling shutter reads each row at the end of its exposure.
        exposure: how long each row was exposed [s].
        readout: from the first row to the last [s].
    """
    return readout_start - exposure / 2 + readout / 2


def on_monotonic(stamp: float, current: float, asleep: float) -> float | None:
    """A driver's stamp [s] on the clock of ``time.monotonic``; None if it is of neither clock.

    Drivers stamp by CLOCK_MONOTONIC or by CLOCK_BOOTTIME, which also counts the time for which
    the machine was suspended; libcamera documents the latter and passes on the kernel's, which
    is the former. Only one of the two lies in the last second, unless they are the same.

    Args:
        stamp: what the driver tells [s].
        current: when the picture came, by CLOCK_MONOTONIC [s].
        asleep: how much CLOCK_BOOTTIME is ahead of CLOCK_MONOTONIC [s].
    """
    for candidate in (stamp, stamp - asleep):
        if 0 <= current - candidate <= LONGEST_WAY_S:
            return candidate
    return None


def time_asleep() -> float:
    """How long the machine has been suspended since it was started [s]."""
    return time.clock_gettime(time.CLOCK_BOOTTIME) - time.monotonic()
