"""LaidWatch: corrects scans of tape that lies a little beside its drawing, as laid by hand."""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from app.features.misplaced_tape.watch import KnownPlace, PlaceWatch, TapeWatch, Telling
from app.settings.config import Config
from robot.fields.edges import lengths
from robot.fields.field import Field
from robot.geometry import Array, Pose2
from robot.localization.estimate import BOUNDED, Alert, Cause, Integrity, State
from robot.localization.monitoring.monitor import Monitor
from robot.scan import Scan

if TYPE_CHECKING:
    from robot.misplaced_tape.as_laid import AsLaid, Laid
    from robot.misplaced_tape.laid_search import LaidSearch, LaidTapes

MOST_EDGES = 3000
"""In drawings of more edges no single piece is looked for: it would take too long. Of the 1421 of
*town* the pieces are found in 4 ms, and a scan is compared with them in 2 ms."""
MOST_TAPE = 60.0
"""In drawings with longer edges [m] it is not learnt how tape lies: it would take too long."""
RECENT = 15
"""So many scans before a place came into doubt are looked at again."""


class _Recent(NamedTuple):
    """A scan as it was seen."""

    scan: Scan
    odometry: Pose2
    known: KnownPlace | None
    """The place after it; None unless it was known."""


@dataclass(slots=True, eq=False)
class _Memory:
    recent: deque[_Recent] = field(default_factory=lambda: deque(maxlen=RECENT))
    search: LaidSearch | None = None
    laid: AsLaid | None = None
    """How the tape lies, as it was learnt; None if it lies as drawn."""
    follows: bool = False
    """Whether it follows the robot now: its place is known."""
    corrects: bool = False
    """Whether it has corrected a scan since it follows the robot."""
    is_new: bool = False
    """Whether the newest scan is the first that is corrected."""
    newest: Scan | None = None
    """As it was seen."""
    telling: Telling = field(default_factory=Telling)


class LaidWatch(PlaceWatch):
    """Watches whether all tape lies a little beside its drawing."""

    memory: _Memory

    def __init__(self, floor: Field) -> None:
        """Watch the tape of a field."""
        super().__init__()
        self._edges = floor.edges
        self._tapes: LaidTapes | None = None
        self.memory = _Memory()

    @property
    def alerts(self) -> tuple[Alert, ...]:
        """How tape lies beside its drawing; nothing if it lies as drawn."""
        laid = self.memory.laid
        return () if laid is None else (_alert(laid.finding),)

    @property
    def unsure(self) -> Array:
        """By how much corrected scans may lead elsewhere: a covariance (3, 3) [m, m, rad]."""
        memory = self.memory
        return memory.laid.unsure if memory.laid and memory.follows else np.zeros((3, 3))

    def advise(self, monitor: Monitor) -> None:
        """Widen what is claimed; before the first scan that is corrected, tape misled."""
        monitor.of_clearing += self.unsure
        if self.memory.is_new:
            monitor.forget()

    def cleared(self, scan: Scan, odometry: Pose2) -> Scan:
        """Return a scan as it would be if the tape lay as drawn."""
        memory = self.memory
        memory.newest, memory.is_new = scan, False
        if memory.laid is None or not memory.follows:
            return scan
        memory.is_new = not memory.corrects
        memory.corrects = True
        return memory.laid.clear(scan, odometry)

    def look(self, claim: Integrity, pose: Pose2, covariance: Array, odometry: Pose2) -> None:
        """Look how tape lies from when a place that was known came into doubt."""
        memory = self.memory
        assert memory.newest is not None
        known = None
        if claim.state in BOUNDED:
            known = KnownPlace.claimed(claim, pose, covariance, odometry)
        if memory.laid is not None:
            if not memory.laid.is_plausible:
                memory.laid, memory.follows, memory.corrects = None, False, False
            elif memory.follows:
                memory.follows = memory.corrects = not memory.laid.is_lost
            elif known is not None:
                memory.laid.restart(*known)
                memory.follows = True
            return
        memory.recent.append(_Recent(memory.newest, odometry, known))
        if memory.search is None and known is None:
            self._begin()
        elif memory.search is not None:
            self._search(memory.search, memory.recent[-1])

    def place(
        self, state: State, pose: Pose2 | None, odometry: Pose2
    ) -> tuple[Pose2, Array] | None:
        """Return the place that is followed by tape as it lies."""
        memory = self.memory
        if memory.laid is None or not memory.follows or memory.newest is None:
            return None
        if not memory.corrects and state not in BOUNDED:
            # What brought the place into doubt has its reason: the robot was never elsewhere.
            memory.telling, state = Telling(), State.LOST
        return memory.telling.place(memory.newest.stamp, memory.laid.place(odometry), state, pose)

    def forget(self) -> None:
        """Forget where the robot was: somebody has said where it is, or that nobody knows."""
        memory = self.memory
        memory.recent.clear()
        memory.search, memory.follows, memory.corrects = None, False, False

    def _begin(self) -> None:
        """Begin at the first place of the recent ones that was known; without one, wait."""
        memory, recent = self.memory, list(self.memory.recent)
        first = next((n for n, each in enumerate(recent) if each.known is not None), None)
        if first is None:
            return
        from robot.misplaced_tape.laid_search import LaidSearch, LaidTapes  # noqa: PLC0415 - rarely

        self._tapes = self._tapes or LaidTapes(self._edges)
        begun = recent[first].known
        assert begun is not None
        memory.search = LaidSearch(self._tapes, self.mounting, *begun)
        for each in recent[first + 1 :]:
            if memory.search is not None:
                self._search(memory.search, each)

    def _search(self, search: LaidSearch, seen: _Recent) -> None:
        from robot.misplaced_tape.as_laid import AsLaid  # noqa: PLC0415 - rarely

        memory = self.memory
        tracker = search.add(seen.scan, seen.odometry)
        if tracker is not None:
            memory.laid, memory.follows = AsLaid(tracker, seen.odometry), True
            memory.search = None
            memory.recent.clear()
        elif search.failed:
            # It was moved: a search from a place a moment later would hide that in its covariance.
            memory.search = None
            memory.recent.clear()


def tape_watches(config: Config, floor: Field) -> Sequence[PlaceWatch]:
    """Return what watches the tape of an engine's field; nothing if it is of walls."""
    if not floor.tape or floor.grid is not None:
        return []
    # A piece that lies elsewhere does so besides what all tape does.
    pieces = [TapeWatch(floor)] if len(floor.edges) <= MOST_EDGES else []
    laid = [LaidWatch(floor)] if lengths(floor.edges).sum() <= MOST_TAPE else []
    return [*laid, *pieces]


def _alert(laid: Laid) -> Alert:
    if laid.scale is not None:
        percent = 100 * abs(laid.scale - 1)
        if laid.scale > 1:
            return Alert(Cause.MAP, f"the floor is {percent:.1f} % larger than its drawing")
        return Alert(Cause.MAP, f"the floor is {percent:.1f} % smaller than its drawing")
    return Alert(
        Cause.MAP,
        f"tape lies beside its drawing, most of all around x {laid.x:.2f} m, y {laid.y:.2f} m: "
        f"{1000 * laid.aside:.0f} mm",
    )
