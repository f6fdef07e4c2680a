"""Draws walls from a laser's scans by a pose graph (graph SLAM, Probabilistic Robotics, 11)."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from robot.estimation.fit_quality import FitQuality
from robot.fields.occupancy_grid import OccupancyGrid
from robot.geometry import Array, Pose2
from robot.localization.models.motion_models import MotionModel
from robot.localization.models.odometry_motion import DifferentialMotion
from robot.mapping.graph.constraints import Constraint
from robot.mapping.graph.detours import straighten
from robot.mapping.graph.key_frames import KeyFrames
from robot.mapping.graph.loop_closing import LoopCloser
from robot.mapping.graph.pose_graph import PoseGraph
from robot.mapping.graph.surfaces import Surfaces
from robot.mapping.graph.tracking import track
from robot.mapping.graph.wall_drawing import WallDrawing
from robot.mapping.grid.beams import Beams

EVERY = 2
"""Loops are searched for once in this many scans."""
ROUNDS = (0.4, 0.3, 0.2)
"""At the end all scans are matched with those nearby, with ever narrower gates [m]."""
REACH_M, REACH_RAD = 4.0, 1.6
"""Scans that were taken nearer than this are matched."""
LINKS = 10
"""... but each only with this many."""
BLOCK = 4
"""At most one of this many successive scans."""
OWN_SD = np.array([0.035, 0.035, 0.01])
"""What each pose is uncertain by that scans cannot show, because it is in all of them [m, m, rad]:
ranges are off by 15 mm, a laser sits 10 mm and half a degree from where it should, its stamps are
late. Of the differences between poses in the Intel lab's log, 95 % of which are to be held, 92 to
100 % are. Half: 60 to 89 %; twice: all (seed 1 of ``laser_trials.py``)."""
TORN_AFTER = 10
"""A path is torn where so many scans fit some of each other, and none from before."""


@dataclass(frozen=True)
class GraphSettings:
    """How walls are drawn."""

    cell: float = 0.05
    """Side of a cell [m]."""
    motion: MotionModel = DifferentialMotion(0.01, 0.0025, 0.01, 0.0004)
    """How odometry errs."""


class GraphSlam:
    """Scans as nodes of a pose graph; the first is taken where the map begins."""

    def __init__(self, settings: GraphSettings, start: Pose2) -> None:
        """Begin at a pose, without any scan."""
        self._settings, self._start = settings, start
        self._beams: list[Beams] = []
        self._frames: KeyFrames | None = None
        self._loops: LoopCloser | None = None
        self._drawing: WallDrawing | None = None
        self.doubtful: dict[int, float] = {}
        """Scans that fit only beside the way: how far from where odometry led [m]."""

    def update(self, moved: Pose2, beams: Beams) -> None:
        """Take a scan after a motion by odometry."""
        self._beams.append(beams)
        self._drawing = None
        surfaces = Surfaces.of_beams(beams)
        if self._frames is None or self._loops is None:
            self._frames = KeyFrames(self._start, surfaces)
            self._loops = LoopCloser(self._frames)
            return
        track(self._frames, moved, self._settings.motion, surfaces)
        node = len(self._frames) - 1
        if node % EVERY == 0:
            self._loops.close(node)

    def finish(self) -> None:
        """Match all scans with those nearby, and adjust the whole path."""
        for gate in ROUNDS:
            relink(self._known, gate)
        self.doubtful = straighten(self._known)
        self._drawing = None

    def torn(self) -> int | None:
        """Return the scan, ten before the newest, from which on nothing but odometry leads back.

        Those before it and from it on met walls, and fit each other on their own side, but no scan
        of one side fits any of the other: the robot saw nothing twice on its way, was carried off,
        or this is another building.
        """
        node = len(self._beams) - TORN_AFTER
        if node < TORN_AFTER:
            return None
        frames, before = self._known, range(node - TORN_AFTER, node)
        after = range(node, node + TORN_AFTER)
        if min(len(frames.telling(side)) for side in (before, after)) < TORN_AFTER:
            return None
        ties = {0: 0, 1: 0, 2: 0}
        for constraint in frames.graph.constraints:
            if constraint.end >= before.start and not constraint.by_odometry:
                ties[(constraint.begin >= node) + (constraint.end >= node)] += 1
        return node if not ties[1] and min(ties[0], ties[2]) >= TORN_AFTER else None

    def is_tied(self, node: int) -> bool:
        """Return whether more than odometry leads to a scan or those after it, from before."""
        constraints = self.graph.constraints
        return any(each.begin < node <= each.end and not each.by_odometry for each in constraints)

    def forget_from(self, node: int) -> None:
        """Forget a scan to which nothing but odometry leads, and all after it."""
        self._known.forget_from(node)
        del self._beams[node:]
        self._drawing = None

    @property
    def path(self) -> Array:
        """(t, 3) poses, one for each scan [m, m, rad]."""
        return self._known.graph.poses

    @property
    def graph(self) -> PoseGraph:
        """The poses, and how certain they are of each other."""
        return self._known.graph

    @property
    def loops(self) -> int:
        """How many matches closed loops."""
        return 0 if self._loops is None else self._loops.count

    def covariance(self, node: int, other: int) -> Array:
        """Return the covariance (3, 3) of a scan's pose, seen from another's [m, m, rad]."""
        factor = self.quality.interval_factor
        return self.graph.covariance(node, other, np.diag((OWN_SD / factor) ** 2)) * factor**2

    def position_sd(self) -> Array:
        """Return the standard deviation of each place (t,), seen from the first, where largest.

        Where scans and odometry disagree, either may be right.
        """
        covariances = [self.covariance(node, 0)[:2, :2] for node in range(1, len(self.path))]
        sd = np.sqrt([0.0, *(np.linalg.eigvalsh(each)[-1] for each in covariances)])
        for node, away in self.doubtful.items():
            sd[node] = np.hypot(sd[node], away / 2)
        return np.asarray(sd)

    @property
    def quality(self) -> FitQuality:
        """How well the path fits what was measured; without a loop, where it is is not told."""
        unobservable = () if self.loops else ("drift",)
        return replace(self.graph.quality, unobservable=unobservable)

    @property
    def grid(self) -> OccupancyGrid:
        """The map that all scans show at the corrected poses."""
        return self._drawn.grid

    @property
    def ends(self) -> Array:
        """(n, 2) where beams ended on average in each occupied cell [m]."""
        return self._drawn.ends

    @property
    def _known(self) -> KeyFrames:
        if self._frames is None:
            raise ValueError("there is no scan yet")
        return self._frames

    @property
    def _drawn(self) -> WallDrawing:
        if self._drawing is None:
            self._drawing = WallDrawing.of(self.path, self._beams, self._settings.cell)
        return self._drawing


def relink(frames: KeyFrames, gate: float) -> None:
    """Replace all matches by new ones from where the scans now lie, and adjust the poses."""
    graph = frames.graph
    odometry = [constraint for constraint in graph.constraints if constraint.by_odometry]
    matched: list[Constraint] = []
    for node in frames.telling(range(1, len(frames))):
        for other in _neighbours(frames, node):
            constraint = frames.constraint(other, node, graph.pose(node), gate)
            if constraint is not None:
                matched.append(constraint)
    graph.keep_constraints(odometry + matched)
    graph.adjust()


def _neighbours(frames: KeyFrames, node: int) -> list[int]:
    """Return earlier nodes nearby, the nearest of each few that follow each other."""
    poses = frames.graph.poses
    offset = poses[:node] - poses[node]
    turn = np.abs((offset[:, 2] + np.pi) % (2 * np.pi) - np.pi)
    away = np.hypot(offset[:, 0], offset[:, 1])
    nearest: dict[int, int] = {}
    for other in np.argsort(away + 2 * turn).tolist():
        if len(nearest) == LINKS:
            break
        if away[other] < REACH_M and turn[other] < REACH_RAD:
            nearest.setdefault((node - other) // BLOCK, other)
    return frames.telling({node - 1, *nearest.values()})
