"""When the field is searched for places, counted in scans."""

from __future__ import annotations

FIRST, LOST, SOON, LATE = 12, 2, 8, 64
"""Scans before the first search, and before a search when lost; scans between searches that find
something, and the most between searches that find nothing."""


class SearchSchedule:
    """Searches soon while searches find new places, and ever later while they find none."""

    def __init__(self) -> None:
        self._wait = FIRST
        """Scans until the next search."""
        self._interval = SOON
        """Scans between searches at present."""

    @property
    def is_due(self) -> bool:
        """Whether it is time for the next search."""
        return self._wait <= 0

    def wait(self, scans: int) -> None:
        """Search after so many scans."""
        self._wait = scans

    def count_scan(self) -> None:
        """Count one more scan."""
        self._wait -= 1

    def begin(self) -> None:
        """Note that a search begins."""
        self._wait = self._interval

    def end(self, *, has_places: bool, more: bool) -> None:
        """Note that a search has ended: whether it found places, and whether some are new."""
        self._interval = SOON if more else min(2 * self._interval, LATE)
        if has_places:
            self._wait = min(self._wait, self._interval)
