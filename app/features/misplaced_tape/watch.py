"""TapeWatch: clears scans of tape that is not where the drawing has it, and names it."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from app.engine.added_models import AddedModels
from app.engine.controls import Controls
from app.messages.commands import Command
from app.settings.config import Config
from robot.covariance import widest
from robot.fields.field import Field
from robot.geometry import Array, Pose2
from robot.interface import Reading, Robot
from robot.localization.estimate import BOUNDED, KNOWN, Alert, Cause, State
from robot.scan import Scan

if TYPE_CHECKING:
    from robot.misplaced_tape.search import Misplaced, MisplacedTapeSearch
    from robot.misplaced_tape.tape_drawing import TapeDrawing
    from robot.misplaced_tape.without_piece import WithoutPiece

DOUBT_S, LONGEST_S = 0.4, 40.0
"""A place that is in doubt for so long [s] begins the search, which then lasts for so long [s]."""
KNOWN_SDS = (0.005, 0.005, 0.01)
"""What a certain place may be off, besides its covariance [m, m, rad]."""
AWAY_M, AWAY_S = 0.04, 0.5
"""The filter is told the place if it knows none, or one that is farther away than this [m], for so
long [s]."""
TOLD_S = 3.0
"""It is told at most once in so many seconds."""
SURE_M = 0.03
"""It is told only a place that is known so well [m], one standard deviation."""
MOST_EDGES = 600
"""Drawings of more edges are not watched: it would take too long."""


Outline = tuple[tuple[float, float, float, float], ...]
"""Edges of a piece of tape: x and y of both ends of each [m]."""


class _Known(NamedTuple):
    """A place that was certain."""

    pose: Pose2
    covariance: Array
    odometry: Pose2


@dataclass(slots=True, eq=False)
class _Memory:
    known: _Known | None = None
    """The last such place."""
    certain_at: float = -math.inf
    """Its stamp [s]."""
    search: MisplacedTapeSearch | None = None
    without: WithoutPiece | None = None
    finding: Misplaced | None = None
    """The piece that was found, also while the robot's place is lost."""
    newest: tuple[Scan, Pose2] | None = None
    """The newest scan as it was seen, and odometry at its stamp."""
    agreed_at: float = -math.inf
    """When the filter last knew the same place."""
    told_at: float = -math.inf


class TapeWatch(AddedModels):
    """Offers no model: it looks at the scans that the program's own ones get."""

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

    def look(self, state: State, pose: Pose2, covariance: Array, odometry: Pose2) -> None:
        """Look whether the place is known that the newest scan has led to.

        Args:
            state: what is claimed of it.
            pose: the likeliest place.
            covariance: its covariance (3, 3) [m, m, rad].
            odometry: at the scan's stamp.
        """
        memory = self.memory
        assert memory.newest is not None
        scan, _ = memory.newest
        if memory.without is not None:
            self._mind(memory.without)
        if state is State.CERTAIN:
            wider = covariance + np.diag(np.square(KNOWN_SDS))
            memory.known, memory.certain_at = _Known(pose, wider, odometry), scan.stamp
            memory.search = None
            if memory.finding is not None and memory.without is None:
                self._follow_without(memory.finding, pose, wider, odometry)
            return
        if memory.finding is not None or memory.known is None or state in BOUNDED:
            return
        if DOUBT_S < scan.stamp - memory.certain_at < LONGEST_S:
            self._search(memory.known, scan, odometry)

    def place(
        self, state: State, pose: Pose2 | None, odometry: Pose2
    ) -> tuple[Pose2, Array] | None:
        """Return where the filter shall look for the robot, with a covariance; None if it knows.

        Args:
            state: what is claimed of the filter's place.
            pose: this place at ``odometry``; None without one.
            odometry: now.
        """
        memory = self.memory
        if memory.without is None or memory.newest is None:
            return None
        stamp = memory.newest[0].stamp
        place, covariance = memory.without.place(odometry)
        covariance = covariance + np.diag(np.square(KNOWN_SDS))
        sure = widest(covariance) < SURE_M
        if not sure or (state in KNOWN and pose and pose.distance_to(place) < AWAY_M):
            memory.agreed_at = stamp
        if stamp < max(memory.agreed_at + AWAY_S, memory.told_at + TOLD_S):
            return None
        memory.told_at = stamp
        return place, covariance

    def forget(self) -> None:
        """Forget where the robot was: somebody has said where it is, or that nobody knows."""
        self.memory.known = self.memory.search = self.memory.without = None

    def _search(self, known: _Known, scan: Scan, odometry: Pose2) -> None:
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

    def _follow_without(
        self, finding: Misplaced, pose: Pose2, covariance: Array, odometry: Pose2
    ) -> None:
        from robot.misplaced_tape.without_piece import WithoutPiece  # noqa: PLC0415 - rarely

        assert self._drawing is not None
        follower = self._drawing.follower(pose, covariance, finding.piece)
        self.memory.without = WithoutPiece(self._drawing, follower, finding, odometry)

    def _mind(self, without: WithoutPiece) -> None:
        memory = self.memory
        memory.finding = without.finding
        if without.fits_again:
            memory.finding = memory.without = None
        elif without.is_lost:
            memory.without = None


def tape_watches(config: Config, floor: Field) -> Sequence[TapeWatch]:
    """Return what watches the tape of an engine's field; nothing if it is of walls."""
    watched = floor.tape and floor.grid is None and len(floor.edges) <= MOST_EDGES
    return [TapeWatch(floor)] if watched else []


class TapeCompanion:
    """Shows the watch what the filter made of each scan, and tells the filter a place."""

    needs_pictures = False

    def __init__(self) -> None:
        self.shown: Outline | None = None
        """Where the drawing has tape that does not lie there."""
        self._map_from_odom = Pose2()
        """Where somebody has put the robot, and that was told."""
        self._newest: tuple[Scan, Pose2] | None = None

    def commands(self, odom_from_robot: Pose2, controls: Controls) -> Iterable[Command]:
        """Give no commands: a replay finds the same place by itself."""
        return ()

    def add(self, reading: Reading, controls: Controls) -> None:
        """Comparison at what the filter made of the newest scan."""
        localization = controls.localization
        newest, belief = localization.newest, localization.belief
        if newest is self._newest or newest is None or belief is None:
            return
        self._newest, odometry = newest, newest[1]
        state, estimate = localization.integrity.state, belief.estimate
        for models in localization.added:
            if not isinstance(models, TapeWatch) or localization.paused:
                continue
            if controls.map_from_odom != self._map_from_odom:
                models.forget()
            self.shown = models.outline
            best = max(estimate.hypotheses, key=lambda each: each.weight, default=None)
            if best is not None:
                pose = best.pose @ belief.moved(odometry)
                models.look(state, pose, best.covariance, odometry)
            present = controls.odometry.at(reading.stamp).odom_from_robot
            place = models.place(state, belief.pose(present), present)
            if place is not None:
                localization.note(present)
                localization.set_pose(*place)
        self._map_from_odom = controls.map_from_odom

    def close(self) -> None:
        """Do nothing: there is no thread."""


def tape_companion(config: Config, robot: Robot, field: Field) -> Iterable[TapeCompanion]:
    """Return what goes along with an engine."""
    return (TapeCompanion(),)


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
