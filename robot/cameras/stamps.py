"""Converts a driver's time stamp to the middle of the exposure of the middle row."""

from __future__ import annotations

import time

LONGEST_WAY_S = 1.0
"""Largest age of a picture on arrival [s]; a stamp that is older is of another clock."""


def middle_of_exposure(readout_start: float, exposure: float, readout: float) -> float:
    """Return the middle of the exposure of the middle row [s].

    Args:
        readout_start: when the readout of the first row began [s]. Its exposure ended then: a
            rolling shutter reads each row at the end of its exposure.
        exposure: how long each row was exposed [s].
        readout: time from the first row to the last [s].
    """
    return readout_start - exposure / 2 + readout / 2


def on_monotonic(stamp: float, current: float, asleep: float) -> float | None:
    """Convert a driver's stamp [s] to the clock of ``time.monotonic``; None if no clock fits.

    Drivers stamp by CLOCK_MONOTONIC or by CLOCK_BOOTTIME. CLOCK_BOOTTIME also counts the time for
    which the machine was suspended. libcamera documents CLOCK_BOOTTIME, but passes on the kernel's
    stamp, which is by CLOCK_MONOTONIC. Only one of the two interpretations lies in the last second,
    unless both clocks agree.

    Args:
        stamp: the driver's stamp [s].
        current: when the picture arrived, by CLOCK_MONOTONIC [s].
        asleep: how far CLOCK_BOOTTIME is ahead of CLOCK_MONOTONIC [s].
    """
    for candidate in (stamp, stamp - asleep):
        if 0 <= current - candidate <= LONGEST_WAY_S:
            return candidate
    return None


def suspend_time() -> float:
    """Return how long the machine has been suspended since its start [s]."""
    return time.clock_gettime(time.CLOCK_BOOTTIME) - time.monotonic()
