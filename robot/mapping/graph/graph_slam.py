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

    def position_sd(self) -> Array:
        """Return the standard deviation of each place (t,), seen from the first, where largest."""
        graph = self.graph
        covariances = [graph.covariance(node, 0)[:2, :2] for node in range(1, len(graph.poses))]
        sd = np.sqrt([0.0, *(np.linalg.eigvalsh(each)[-1] for each in covariances)])
        return self.quality.interval_factor * np.asarray(sd)

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
