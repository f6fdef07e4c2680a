"""Searches the field for places again and again, by the short map of the last scans."""

from __future__ import annotations

from robot.geometry import Pose2
from robot.localization.filter import Setup
from robot.localization.hypotheses.local_map import LocalMap
from robot.localization.hypotheses.place_search import PlaceSearch
from robot.localization.parameters import HypothesisParameters
from robot.scan import Scan

FIRST, LOST, SOON, LATE = 12, 2, 8, 64
"""Scans before the first search, and before a search when lost; scans between searches that find
something, and the most between searches that find nothing. Half of all: 1.3 % false alarms; twice:
found after 2.1 s, not 1.6, and 36.8 % certain, not 38.3 (``benchmarks.constants --few``)."""


class Searches:
    """Searches soon while searches find new places, and ever later while they find none."""

    def __init__(self, parameters: HypothesisParameters) -> None:
        """Begin without a scan."""
        self.local = LocalMap.of(parameters)
        """The last scans, by which the field is searched."""
        self._running: PlaceSearch | None = None
        self._wait = FIRST
        """Scans until the next search."""
        self._interval = SOON
        """Scans between searches at present."""

    def use(self, parameters: HypothesisParameters) -> None:
        """Begin with a new short map, by other parameters."""
        self.local, self._running = LocalMap.of(parameters), None
        self.local.whole = False
        self._wait = FIRST

    def restart(self, scans: int) -> None:
        """Forget all but the last ``scans`` scans, and search soon."""
        self.local.begin_anew(scans)
        self._running, self._wait = None, LOST

    def move(self, moved: Pose2) -> None:
        """Move the robot by a step of odometry."""
        self.local.move(moved)
        if self._running is not None:
            self._running.move(moved)

    def add(self, scan: Scan) -> bool:
        """Keep a scan if the robot has moved since the last kept one; return whether it is kept."""
        kept = self.local.add(scan)
        self._wait -= kept
        return kept

    @property
    def is_due(self) -> bool:
        """Whether it is time for the next search."""
        return self._running is None and self._wait <= 0

    def begin(self, leader: Pose2 | None, setup: Setup) -> None:
        """Begin a search; ``leader`` is the likeliest pose of the robot, None without one."""
        likely = [] if leader is None else [leader @ self.local.since.inverse()]
        self._running = PlaceSearch(self.local, likely, setup)
        self._wait = self._interval

    def advance(self) -> PlaceSearch | None:
        """Do the next piece of the running search; return it when it is done."""
        search = self._running
        if search is None or not search.advance():
            return None
        self._running = None
        return search

    def end(self, *, has_places: bool, more: bool) -> None:
        """Note whether a search has found places, and whether some are new."""
        self._interval = SOON if more else min(2 * self._interval, LATE)
        if has_places:
            self._wait = min(self._wait, self._interval)
