"""TapeWatch: clears scans of tape that is not where the drawing has it, and names it."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from app.features.misplaced_tape.place_watch import (
    KNOWN_SDS,
    KnownPlace,
    Outline,
    PlaceWatch,
    Telling,
)
from robot.fields.field import Field
from robot.geometry import Array, Pose2
from robot.localization.estimate import BOUNDED, Alert, Cause, Integrity, State
from robot.scan import Scan

if TYPE_CHECKING:
    from robot.misplaced_tape.search import Misplaced, MisplacedTapeSearch
    from robot.misplaced_tape.tape_drawing import TapeDrawing
    from robot.misplaced_tape.without_piece import WithoutPiece

DOUBT_S, LONGEST_S = 0.4, 40.0
"""A place that is in doubt for so long [s] begins the search, which then lasts for so long [s]."""


@dataclass(slots=True, eq=False)
class _Memory:
    known: KnownPlace | None = None
    """The last such place."""
    certain_at: float = -math.inf
    """Its stamp [s]."""
    search: MisplacedTapeSearch | None = None
    without: WithoutPiece | None = None
    finding: Misplaced | None = None
    """The piece that was found, also while the robot's place is lost."""
    newest: tuple[Scan, Pose2] | None = None
    """The newest scan as it was seen, and odometry at its stamp."""
    telling: Telling = field(default_factory=Telling)


class TapeWatch(PlaceWatch):
    """Watches whether one piece of tape lies elsewhere."""

    memory: _Memory

    def __init__(self, floor: Field) -> None:
        """Watch the tape of a field."""
        super().__init__()
        self._edges = floor.edges
        self._drawing: TapeDrawing | None = None
        self.memory = _Memory()

    @property
    def alerts(self) -> tuple[Alert, ...]:
        """Which tape is not where the drawing has it; nothing if all is."""
        finding = self.memory.finding
        if finding is None or self._drawing is None:
            return ()
        return (_alert(finding, self._drawing),)

    @property
    def outline(self) -> Outline | None:
        """Where the drawing has that tape; None if all is where it is drawn."""
        finding = self.memory.finding
        if finding is None or self._drawing is None:
            return None
        edges = self._edges[self._drawing.pieces[finding.piece].edges]
        return tuple((x1, y1, x2, y2) for x1, y1, x2, y2 in edges.round(4).tolist())

    def cleared(self, scan: Scan, odometry: Pose2) -> Scan:
        """Return a scan with that tape hidden, and all behind it."""
        memory = self.memory
        memory.newest = scan, odometry
        return scan if memory.without is None else memory.without.clear(scan, odometry)

    def look(self, claim: Integrity, pose: Pose2, covariance: Array, odometry: Pose2) -> None:
        """Look for the piece while a place that was certain is in doubt."""
        memory = self.memory
        assert memory.newest is not None
        scan, _ = memory.newest
        if memory.without is not None:
            self._mind(memory.without)
        if claim.state is State.CERTAIN:
            memory.known = KnownPlace(pose, covariance + np.diag(np.square(KNOWN_SDS)), odometry)
            memory.certain_at, memory.search = scan.stamp, None
            if memory.finding is not None and memory.without is None:
                self._follow_without(memory.finding, memory.known)
            return
        if memory.finding is not None or memory.known is None or claim.state in BOUNDED:
            return
        if DOUBT_S < scan.stamp - memory.certain_at < LONGEST_S:
            self._search(memory.known, scan, odometry)

    def place(
        self, state: State, pose: Pose2 | None, odometry: Pose2
    ) -> tuple[Pose2, Array] | None:
        """Return the place that is followed without the piece."""
        memory = self.memory
        if memory.without is None or memory.newest is None:
            return None
        followed = memory.without.place(odometry)
        return memory.telling.place(memory.newest[0].stamp, followed, state, pose)

    def forget(self) -> None:
        """Forget where the robot was: somebody has said where it is, or that nobody knows."""
        self.memory.known = self.memory.search = self.memory.without = None

    def _search(self, known: KnownPlace, scan: Scan, odometry: Pose2) -> None:
        from robot.misplaced_tape.search import MisplacedTapeSearch  # noqa: PLC0415
        from robot.misplaced_tape.tape_drawing import TapeDrawing  # noqa: PLC0415 - the first doubt
        from robot.misplaced_tape.without_piece import WithoutPiece  # noqa: PLC0415

        memory = self.memory
        self._drawing = drawing = self._drawing or TapeDrawing(self._edges)
        memory.search = search = memory.search or MisplacedTapeSearch(drawing, *known)
        finding = search.add(scan, odometry)
        if finding is not None:
            memory.finding, memory.search = finding, None
            follower = search.without(finding.piece)
            memory.without = WithoutPiece(drawing, follower, finding, odometry)

    def _follow_without(self, finding: Misplaced, known: KnownPlace) -> None:
        from robot.misplaced_tape.without_piece import WithoutPiece  # noqa: PLC0415 - rarely

        assert self._drawing is not None
        follower = self._drawing.follower(known.pose, known.covariance, finding.piece)
        self.memory.without = WithoutPiece(self._drawing, follower, finding, known.odometry)

    def _mind(self, without: WithoutPiece) -> None:
        memory = self.memory
        memory.finding = without.finding
        if without.fits_again:
            memory.finding = memory.without = None
        elif without.is_lost:
            memory.without = None


def _alert(finding: Misplaced, drawing: TapeDrawing) -> Alert:
    x, y = drawing.pieces[finding.piece].middle
    if finding.aside is None:
        return Alert(
            Cause.MAP, f"the tape around x {x:.2f} m, y {y:.2f} m is not where it is drawn"
        )
    return Alert(
        Cause.MAP,
        f"the tape around x {x:.2f} m, y {y:.2f} m lies {100 * finding.aside:.0f} cm beside its "
        "place in the drawing",
    )
