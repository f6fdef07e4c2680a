"""Searches the whole field for places where a short map fits, a little at a time.

First, a coarse grid of poses is scored by how far the ends of the map's rays lie from edges. Then
the best poses are laid on the edges exactly. Finally, the recent scans are replayed for the poses
that fit about as well as the best.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from robot import ray_columns as column
from robot.fields.floor_picture import Extent
from robot.geometry import Array, Pose2
from robot.localization.filter import Setup
from robot.localization.hypotheses.coarse_grid import Cheapest, CoarseGrid
from robot.localization.hypotheses.local_map import LocalMap
from robot.localization.hypotheses.rescoring import Rescored, ScanHistory, rescore
from robot.localization.scan_matching import Match

COARSE_SCANS, COARSE_BEAMS = 12, 6
"""Scans, and rays of each, by which the grid is scored. Half of these, of the four below and of
PEAKS: 2.6 % of pictures are misleading, not 0.6, and one of ten places is not found; twice: found
after 1.9 s, not 1.6, and one is not found (``--few``)."""
SCANS, BEAMS = 12, 12
"""Scans, and rays of each, that are laid on the edges."""
REPLAYED_SCANS, REPLAYED_BEAMS = 8, 30
"""Scans, and rays of each, that are replayed."""
PEAKS = 90
"""Poses of the grid that are laid on the edges."""
BESIDE = 0.3
"""If the likeliest pose lies beside where robots drive, as stuck wheels may lead one, the field is
searched so far around it, too [m]. Of such a drive (*tee*, stuck, seed 20220) 21 % is certain;
half: 7; twice: 27."""
WORSE = 1.5
"""A place is dropped if its log-likelihood per ray is this much below the best one's. Half and
twice: nothing changes beyond chance (``python -m benchmarks.constants --few``)."""
SEARCHED_PER_PIECE = 100_000
"""Poses that are searched for the cheapest ones in one piece of work: about 1 ms."""
POSES_PER_PIECE, FITS_PER_PIECE, REPLAYS_PER_PIECE = 20_000, 45, 12
"""Poses scored, poses laid on edges (two thirds of these in one piece), and places replayed in one
piece of work: 1 to 3 ms."""


class PlaceSearch:
    """One search, cut into pieces so that no frame has to wait for it."""

    def __init__(
        self,
        local: LocalMap,
        alive: list[Pose2],
        setup: Setup,
    ) -> None:
        """Begin to search.

        Args:
            local: the short map; the search finds poses of its newest scan.
            alive: poses of that scan that are already likely, for which scans are replayed as well.
            setup: the field, and the parameters of the search.
        """
        self.scans = len(local)
        """Number of scans in the short map."""
        self.whole = local.whole
        """Whether the short map goes back to its start or restart."""
        self.since = local.since
        """How the robot moved since the newest scan of the short map."""
        self.found: list[Rescored] = []
        """The found places; complete when the search is done."""
        self.alive: list[Rescored] = []
        """The poses that were already likely, after the replay."""
        self._setup = setup
        self._entries, self._parameters = setup.entries, setup.hypotheses
        self._ends = _ends(local.rays(COARSE_SCANS, COARSE_BEAMS))
        self._rays = local.rays(SCANS, BEAMS)
        self._past: ScanHistory = local.past(REPLAYED_SCANS, REPLAYED_BEAMS, setup.motion)
        self._likely = alive
        self._done = 0
        """Number of pieces of work that are done."""
        self._pieces: Iterator[bool] | None = self._work()

    @property
    def scans_replayed(self) -> int:
        """Number of scans that are replayed for each place."""
        return len(self._past.moves)

    def rescored_at(self, pose: Pose2) -> Rescored | None:
        """Return the replayed hypothesis that is now at a pose; None if there is none."""
        for candidate in (*self.alive, *self.found):
            if self._parameters.alike(candidate.pose @ self.since, pose):
                return candidate
        return None

    def places_apart_from(self, poses: Sequence[Pose2]) -> list[Rescored]:
        """Return the found places that are now at none of some poses."""
        alike = self._parameters.alike
        return [
            candidate
            for candidate in self.found
            if not any(alike(candidate.pose @ self.since, pose) for pose in poses)
        ]

    @property
    def best_rescored(self) -> Rescored:
        """The replayed hypothesis that fits best."""
        return max((*self.alive, *self.found), key=lambda candidate: float(candidate.fits.sum()))

    def move(self, moved: Pose2) -> None:
        """Add a step of odometry to ``since``."""
        self.since = self.since @ moved

    def advance(self) -> bool:
        """Do one piece of the work; return true when all of it is done."""
        if self._pieces is None:
            self._catch_up()
        self._done += 1
        assert self._pieces is not None
        return next(self._pieces, True)

    def __getstate__(self) -> dict[str, object]:
        """Return the state to save: without unfinished work, which is repeated after a restore."""
        return {**self.__dict__, "_pieces": None, "found": [], "alive": []}

    def _catch_up(self) -> None:
        self._pieces = self._work()
        for _ in range(self._done):
            next(self._pieces, True)

    def _work(self) -> Iterator[bool]:
        grid = CoarseGrid.over(
            self._area,
            self._parameters.search_step_xy,
            self._parameters.search_step_theta,
        )
        costs = np.empty(grid.shape, dtype=np.float32)
        for turns in _pieces(grid.shape[0], POSES_PER_PIECE // (grid.shape[1] * grid.shape[2])):
            grid.score(turns, self._ends, self._entries, self._parameters.search_blur, costs)
            yield False
        cheapest = Cheapest(PEAKS, self._hopeless_cost())
        for turns in _pieces(grid.shape[0], SEARCHED_PER_PIECE // (grid.shape[1] * grid.shape[2])):
            cheapest.look(costs, turns)
            yield False
        blur, starts = self._parameters.search_blur, grid.poses(cheapest.cells)
        fits: list[tuple[float, Pose2]] = []
        for part in np.array_split(starts, 1 + math.ceil(len(starts) / FITS_PER_PIECE)):
            fits += self._fits(grid.refined_poses(part, self._ends, self._entries, blur))
            yield False
        places = self._distinct(fits)
        for some in _pieces(len(places), REPLAYS_PER_PIECE):
            self.found += [self._replayed(place) for place in places[some]]
            yield False
        self.alive = [self._replayed(self._match(pose).pose) for pose in self._likely]
        yield True

    @property
    def _area(self) -> Extent:
        """Where robots drive, and around where this one is likely to be, if it has left that."""
        field = self._setup.field
        area = np.reshape(field.drive_area, (2, 2))
        for place in (np.array([pose.x, pose.y]) for pose in self._likely):
            if field.farthest_outside(place) > 0:
                low, high = np.minimum(area[0], place - BESIDE), np.maximum(area[1], place + BESIDE)
                area = np.array([low, high])
        xmin, ymin, xmax, ymax = np.clip(area, *np.reshape(field.extent, (2, 2))).ravel().tolist()
        return xmin, ymin, xmax, ymax

    def _hopeless_cost(self) -> float:
        """Return the cost of a pose where hardly any end lies near an edge."""
        far, blur = self._entries.max_distance, self._parameters.search_blur
        return 0.9 * len(self._ends) * far**2 / (far**2 + blur**2)

    def _match(self, start: Pose2) -> Match:
        return self._setup.matcher.match(start, self._rays)

    def _fits(self, starts: Array) -> list[tuple[float, Pose2]]:
        """Lay the rays on the edges from each of the poses (n, 3); return how well, and where."""
        poses = [self._match(Pose2(*start)).pose for start in starts.tolist()]
        laid = np.array([pose.to_array() for pose in poses]).reshape(-1, 3)
        logs = self._setup.evidence.log_likelihoods(laid, self._rays, within=WORSE).tolist()
        return list(zip(logs, poses, strict=True))

    def _replayed(self, pose: Pose2) -> Rescored:
        return rescore(pose, self._past, self._setup.matcher, self._setup.evidence)

    def _distinct(self, fits: list[tuple[float, Pose2]]) -> list[Pose2]:
        """Return the best pose of each place; not too many, and no bad ones."""
        kept: list[Pose2] = []
        fits = sorted(fits, key=lambda fit: -fit[0])
        for log_likelihood, pose in fits:
            if log_likelihood <= fits[0][0] - WORSE:
                break
            if not any(self._parameters.alike(pose, other) for other in kept):
                kept.append(pose)
        return kept[: self._parameters.max_hypotheses]


def _pieces(count: int, size: int) -> Iterator[slice]:
    size = max(size, 1)
    return (slice(first, first + size) for first in range(0, count, size))


def _ends(rays: Array) -> NDArray[np.float64]:
    """Return end and direction (n, 3) of the rays that returned something."""
    seen = np.isfinite(rays[:, column.RANGE]) & ~np.isnan(rays[:, column.NEAR])
    x, y, direction, length = rays[seen, :4].T
    return np.column_stack(
        [x + length * np.cos(direction), y + length * np.sin(direction), direction]
    )
