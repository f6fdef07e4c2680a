"""TapeWatch: clears scans of tape that is not where the drawing has it, and names it.

It is one of two watches of tape, which go along with an engine alike; the other is ``laid_watch``.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from app.engine.added_models import AddedModels, Clearing
from app.engine.controls import Controls
from app.messages.commands import Command
from app.settings.config import Config
from robot.covariance import widest
from robot.fields.field import Field
from robot.geometry import Array, Pose2
from robot.interface import Reading, Robot
from robot.localization.estimate import BOUNDED, KNOWN, Alert, Cause, Integrity, State
from robot.localization.monitoring.monitor import Monitor
from robot.localization.monitoring.mounting_check import LASER, CameraPosition
from robot.scan import Scan

if TYPE_CHECKING:
    from robot.misplaced_tape.search import Misplaced, MisplacedTapeSearch
    from robot.misplaced_tape.tape_drawing import TapeDrawing
    from robot.misplaced_tape.without_piece import WithoutPiece

DOUBT_S, LONGEST_S = 0.4, 40.0
"""A place that is in doubt for so long [s] begins the search, which then lasts for so long [s]."""
GIVEN_M = 0.05
"""A place with a smaller standard deviation that does not fit from the start on was given [m]."""
KNOWN_SDS = (0.005, 0.005, 0.01)
"""What a place may be off that is certain or followed, besides its covariance [m, m, rad]."""
BOUND_SDS = 3.5
"""A bound that holds in 99.9 % is about so many standard deviations of a place or a heading."""
AWAY_M, AWAY_S = 0.04, 0.5
"""The filter is told the place if it knows none, or one that is farther away than this [m], for so
long [s]."""
TOLD_S = 3.0
"""It is told at most once in so many seconds."""
SURE_M = 0.03
"""It is told only a place that is known so well [m], one standard deviation."""

Outline = tuple[tuple[float, float, float, float], ...]
"""Edges of a piece of tape: x and y of both ends of each [m]."""


class KnownPlace(NamedTuple):
    """A place that was known."""

    pose: Pose2
    covariance: Array
    odometry: Pose2

    @classmethod
    def claimed(
        cls, claim: Integrity, pose: Pose2, covariance: Array, odometry: Pose2
    ) -> KnownPlace:
        """Return a place that may be off by as much as is claimed, or by more."""
        along, turn = claim.radius / BOUND_SDS, claim.heading_bound / BOUND_SDS
        return cls(pose, covariance + np.diag(np.square([along, along, turn])), odometry)

    @classmethod
    def usual(cls, pose: Pose2, covariance: Array, odometry: Pose2) -> KnownPlace:
        """Return a place that may be off a little more than its covariance (3, 3) says."""
        return cls(pose, covariance + np.diag(np.square(KNOWN_SDS)), odometry)


@dataclass(slots=True)
class Telling:
    """When the filter is told a place."""

    agreed_at: float = -math.inf
    """When the filter last knew the same place."""
    told_at: float = -math.inf

    def place(
        self,
        stamp: float,
        followed: tuple[Pose2, Array],
        state: State,
        pose: Pose2 | None,
    ) -> tuple[Pose2, Array] | None:
        """Return a place that is followed, with its covariance; None if the filter knows it.

        Args:
            stamp: of the newest scan [s].
            followed: the place, and its covariance (3, 3) [m, m, rad].
            state: what is claimed of the filter's place.
            pose: this place; None without one.
        """
        place, covariance = followed
        covariance = covariance + np.diag(np.square(KNOWN_SDS))
        sure = widest(covariance) < SURE_M
        if not sure or (state in KNOWN and pose and pose.distance_to(place) < AWAY_M):
            self.agreed_at = stamp
        if stamp < max(self.agreed_at + AWAY_S, self.told_at + TOLD_S):
            return None
        self.told_at = stamp
        return place, covariance


class PlaceWatch(AddedModels):
    """Offers no model: it looks at the scans that the program's own ones get, and clears them."""

    clearing = Clearing.MAP
    mounting: CameraPosition = LASER
    """Of what takes the scans."""

    @property
    def outline(self) -> Outline | None:
        """Where the drawing has tape that does not lie there; None if all does."""
        return None

    def look(self, claim: Integrity, pose: Pose2, covariance: Array, odometry: Pose2) -> None:
        """Look whether the place is known that the newest scan has led to.

        Args:
            claim: what is claimed of it.
            pose: the likeliest place.
            covariance: its covariance (3, 3) [m, m, rad].
            odometry: at the scan's stamp.
        """

    def place(
        self, state: State, pose: Pose2 | None, odometry: Pose2
    ) -> tuple[Pose2, Array] | None:
        """Return where the filter shall look for the robot, with a covariance; None if it knows.

        Args:
            state: what is claimed of the filter's place.
            pose: this place at ``odometry``; None without one.
            odometry: now.
        """

    def forget(self) -> None:
        """Forget where the robot was: somebody has said where it is, or that nobody knows."""


@dataclass(slots=True, eq=False)
class _Memory:
    is_first: bool = True
    """Whether nothing was seen yet since the start, or since somebody has said where it is."""
    known: KnownPlace | None = None
    """The last such place."""
    known_at: float = -math.inf
    """Its stamp [s]."""
    search: MisplacedTapeSearch | None = None
    without: WithoutPiece | None = None
    finding: Misplaced | None = None
    """The piece that was found, also while the robot's place is lost."""
    is_new: bool = False
    """Whether the filter does not know yet what was found."""
    newest: tuple[Scan, Pose2] | None = None
    """The newest scan as it was seen, and odometry at its stamp."""
    telling: Telling = field(default_factory=Telling)
    rival: Array | None = None
    """How far from the filter's place (3,) [m, m, rad] the robot is if a piece lies elsewhere, as
    long as that cannot be told from a robot that was moved."""


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

    def advise(self, monitor: Monitor) -> None:
        """Widen what is claimed, as long as tape that lies elsewhere explains as much."""
        if self.memory.rival is not None:
            monitor.of_clearing += np.outer(self.memory.rival, self.memory.rival)

    def cleared(self, scan: Scan, odometry: Pose2) -> Scan:
        """Return a scan with that tape hidden, and all behind it."""
        memory = self.memory
        memory.newest = scan, odometry
        return scan if memory.without is None else memory.without.clear(scan, odometry)

    def look(self, claim: Integrity, pose: Pose2, covariance: Array, odometry: Pose2) -> None:
        """Look for the piece while a place that was known is in doubt."""
        memory = self.memory
        assert memory.newest is not None
        scan, _ = memory.newest
        if memory.without is not None:
            self._mind(memory.without)
        if memory.search is not None:
            self._search(memory.search, scan, odometry)
        memory.rival = None if memory.search is None else _rival(memory.search, pose)
        is_first, memory.is_first = memory.is_first, False
        if claim.state in BOUNDED and memory.rival is None:
            if claim.state is State.CERTAIN:
                known = KnownPlace.usual(pose, covariance, odometry)
                if memory.search is not None:
                    memory.finding = memory.search.settle(pose, covariance)
            else:
                known = KnownPlace.claimed(claim, pose, covariance, odometry)
            memory.known, memory.known_at, memory.search = known, scan.stamp, None
            if memory.finding is not None and memory.without is None:
                self._follow_without(memory.finding, known)
        elif is_first and claim.state is State.APPROXIMATE and widest(covariance) < GIVEN_M:
            memory.known, memory.known_at = KnownPlace.usual(pose, covariance, odometry), scan.stamp
        elif (
            memory.known is not None
            and memory.search is None
            and memory.finding is None
            and DOUBT_S < scan.stamp - memory.known_at < LONGEST_S
        ):
            self._begin(memory.known)

    def place(
        self, state: State, pose: Pose2 | None, odometry: Pose2
    ) -> tuple[Pose2, Array] | None:
        """Return the place that is followed without the piece."""
        memory = self.memory
        if memory.without is None or memory.newest is None:
            return None
        if memory.is_new and state not in BOUNDED:
            # What brought the place into doubt has its reason: the robot was never elsewhere.
            memory.telling, state = Telling(), State.LOST
        memory.is_new = False
        followed = memory.without.place(odometry)
        return memory.telling.place(memory.newest[0].stamp, followed, state, pose)

    def forget(self) -> None:
        """Forget where the robot was: somebody has said where it is, or that nobody knows."""
        self.memory.known = self.memory.search = self.memory.without = None
        self.memory.is_first = True

    def _begin(self, known: KnownPlace) -> None:
        from robot.misplaced_tape.search import MisplacedTapeSearch  # noqa: PLC0415
        from robot.misplaced_tape.tape_drawing import TapeDrawing  # noqa: PLC0415 - the first doubt

        self._drawing = self._drawing or TapeDrawing(self._edges)
        self.memory.search = MisplacedTapeSearch(self._drawing, *known)

    def _search(self, search: MisplacedTapeSearch, scan: Scan, odometry: Pose2) -> None:
        from robot.misplaced_tape.without_piece import WithoutPiece  # noqa: PLC0415 - rarely

        memory = self.memory
        assert self._drawing is not None
        finding = search.add(scan, odometry)
        if finding is not None:
            memory.finding, memory.search = finding, None
            follower = search.without(finding.piece)
            memory.without = WithoutPiece(self._drawing, follower, finding, odometry)
            memory.is_new = True
        elif scan.stamp - memory.known_at > LONGEST_S:
            memory.search = None

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


class TapeCompanion:
    """Shows the watches what the filter made of each scan, and tells the filter a place."""

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
        """Show them what the filter made of the newest scan."""
        localization = controls.localization
        newest, belief = localization.newest, localization.belief
        if newest is self._newest or newest is None or belief is None:
            return
        self._newest, odometry = newest, newest[1]
        if localization.paused:
            return
        claim, estimate = localization.integrity, belief.estimate
        self.shown = None
        for models in localization.added:
            if not isinstance(models, PlaceWatch):
                continue
            if controls.map_from_odom != self._map_from_odom:
                models.forget()
            self.shown = models.outline or self.shown
            best = max(estimate.hypotheses, key=lambda each: each.weight, default=None)
            models.mounting = CameraPosition.of(localization.scanner.view)
            if best is not None:
                pose = best.pose @ belief.moved(odometry)
                models.look(claim, pose, best.covariance, odometry)
            present = controls.odometry.at(reading.stamp).odom_from_robot
            place = models.place(claim.state, belief.pose(present), present)
            if place is not None:
                localization.note(present)
                localization.set_pose(*place)
        self._map_from_odom = controls.map_from_odom

    def close(self) -> None:
        """Do nothing: there is no thread."""


def tape_companion(config: Config, robot: Robot, field: Field) -> Iterable[TapeCompanion]:
    """Return what goes along with an engine."""
    return (TapeCompanion(),)


def _rival(search: MisplacedTapeSearch, pose: Pose2) -> Array | None:
    """Return how far from a place the robot is if a piece lies elsewhere (3,) [m, m, rad]."""
    rival = search.rival
    if rival is None or rival.distance_to(pose) < AWAY_M:
        return None
    return pose.offset_to(rival)


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
