"""Draws an occupancy grid by particles, each of which has a path and a map of its own.

FastSLAM with occupancy grids (Probabilistic Robotics, Table 13.4; Rao-Blackwellized: given a path,
the map follows from it). Particles are moved to where their scans fit first, as GMapping does.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from robot.fields.occupancy_grid import UNKNOWN, OccupancyGrid
from robot.geometry import Array, Pose2
from robot.localization.models.motion_models import MotionModel
from robot.localization.models.odometry_motion import DifferentialMotion
from robot.localization.particles.resampling import effective_sample_size, low_variance
from robot.mapping.grid.beams import Beams
from robot.mapping.grid.cells import Grids, updated_occupancy_grid
from robot.mapping.grid.climbing import climbed
from robot.scan import evenly

BLOCK = 32
"""How many cells a map grows by at once."""
FEWEST_MET = 5
"""A scan tells where the robot is if at least this many of its beams met something."""


@dataclass(frozen=True)
class GridSettings:
    """How a grid is drawn."""

    cell: float
    """Side of a cell [m]."""
    sd: float
    """Standard deviation of a beam's end, from where others ended [m]."""
    motion: MotionModel
    """How odometry errs."""
    particles: int = 30
    beams: int = 60
    """Most beams of a scan that are compared with the map; neighbours err alike."""
    temper: float = 0.2
    """Exponent of the likelihood that weighs particles: beams are not independent."""


TAPE = GridSettings(0.01, 0.002, DifferentialMotion(0.01, 0.1, 0.0025, 1e-6))
"""For a camera that sees tape in a metre."""
WALLS = GridSettings(0.1, 0.03, DifferentialMotion(0.005, 0.002, 0.005, 0.0001))
"""For a laser that sees walls in ten metres."""


class FastSlam:
    """Particles that each draw a map; the first picture or scan is taken where the map begins."""

    def __init__(self, settings: GridSettings, start: Pose2, rng: np.random.Generator) -> None:
        """Begin at a pose, without any map."""
        self._settings, self._rng = settings, rng
        count = settings.particles
        self.poses = np.tile(start.to_array(), (count, 1))
        """(m, 3) of the particles."""
        self.weights = np.full(count, 1 / count)
        self._paths = np.zeros((count, 0, 3))
        self._corner = settings.cell * np.floor(start.to_array()[:2] / settings.cell)
        self._odds: Grids = np.zeros((count, 0, 0), np.float32)
        self._ends: Grids = np.zeros((count, 0, 0, 6), np.float32)

    def update(self, moved: Pose2, beams: Beams) -> None:
        """Take a scan after a motion by odometry (Table 13.4)."""
        poses = self._sample_motion_model(moved)
        log_likelihood, self.poses = self._measurement_model_map(poses, moved, beams)
        self._updated_occupancy_grids(beams)
        self._paths = np.concatenate([self._paths, self.poses[:, None]], axis=1)
        weights = self.weights * np.exp(log_likelihood - log_likelihood.max())
        self.weights = weights / weights.sum()
        if effective_sample_size(self.weights) < len(self.weights) / 2:
            self._resample()

    def finish(self) -> None:
        """Do nothing: particles have their paths already, and none is adjusted."""

    @property
    def path(self) -> Array:
        """(t, 3) poses of the heaviest particle, one for each scan [m, m, rad]."""
        best: Array = self._paths[np.argmax(self.weights)]
        return best

    @property
    def grid(self) -> OccupancyGrid:
        """The map of the heaviest particle."""
        odds = self._odds[np.argmax(self.weights)]
        chance = np.rint(100 / (1 + np.exp(-odds)))
        cells = np.where(odds == 0, UNKNOWN, chance).astype(np.int8)
        return OccupancyGrid(cells, self._settings.cell, Pose2(*self._corner.tolist()))

    @property
    def ends(self) -> Array:
        """(n, 2) where beams ended on average in each occupied cell of that map [m]."""
        best = np.argmax(self.weights)
        ends = self._ends[best]
        rows, columns = np.nonzero((ends[..., 0] > 0) & (self._odds[best] > 0))
        inside = ends[rows, columns, 1:3] / ends[rows, columns, :1]
        corners = np.column_stack([columns, rows]) * self._settings.cell
        return np.asarray(self._corner + corners + inside, np.float64)

    def _sample_motion_model(self, moved: Pose2) -> Array:
        return self._settings.motion.sample(self.poses, moved, self._rng)

    def _measurement_model_map(
        self, poses: Array, moved: Pose2, beams: Beams
    ) -> tuple[Array, Array]:
        """Return the log-likelihood (m,) of a scan in each particle's map, and the poses (m, 3).

        These are moved to where the scan fits.
        """
        settings, met = self._settings, beams.end[beams.hit]
        nothing = np.zeros(len(poses))
        if len(met) < FEWEST_MET or not self._odds.size:
            return nothing, poses
        met = np.ascontiguousarray(met[evenly(len(met), settings.beams)])
        _, covariance = settings.motion.moments(moved)
        inverse_sd = 1 / np.sqrt(np.diag(covariance) + settings.sd**2)
        inverse_sd[:2] = inverse_sd[:2].mean()
        fitting = [
            climbed(odds, ends, self._corner, settings.cell, pose, met, settings.sd, inverse_sd)
            for odds, ends, pose in zip(self._odds, self._ends, poses, strict=True)
        ]
        likelihood = np.array([likelihood for _, likelihood in fitting])
        return settings.temper * likelihood, np.array([pose for pose, _ in fitting])

    def _updated_occupancy_grids(self, beams: Beams) -> None:
        self._grow(beams)
        parts = beams.begin, beams.end, beams.beyond, beams.hit
        for odds, ends, pose in zip(self._odds, self._ends, self.poses, strict=True):
            updated_occupancy_grid(odds, ends, self._corner, self._settings.cell, pose, *parts)

    def _grow(self, beams: Beams) -> None:
        """Let the maps reach as far as beams do from all particles."""
        points = np.vstack([beams.begin, beams.end, beams.beyond, np.zeros((1, 2))])
        reach = np.hypot(*points.T).max()
        low = self.poses[:, :2].min(axis=0) - reach
        high = self.poses[:, :2].max(axis=0) + reach
        size = np.array(self._odds.shape[:0:-1])
        before = np.ceil((self._corner - low) / self._settings.cell).astype(int)
        after = np.ceil((high - self._corner) / self._settings.cell).astype(int) - size
        before, after = (np.where(more > 0, more + BLOCK, 0) for more in (before, after))
        if not before.any() and not after.any():
            return
        (left, below), (right, above) = before.tolist(), after.tolist()
        margins = (0, 0), (below, above), (left, right)
        self._odds = np.pad(self._odds, margins)
        self._ends = np.pad(self._ends, (*margins, (0, 0)))
        self._corner = self._corner - self._settings.cell * before

    def _resample(self) -> None:
        count = len(self.weights)
        drawn = low_variance(self.weights, count, self._rng)
        self.poses, self._paths = self.poses[drawn], self._paths[drawn]
        self._odds, self._ends = self._odds[drawn], self._ends[drawn]
        self.weights = np.full(count, 1 / count)
