"""FreeSpace: how far each place of a field is from what the robot must not touch."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property

import cv2
import numpy as np
from numpy.typing import NDArray

from robot.fields.field import Field
from robot.fields.floor_picture import Extent
from robot.fields.occupancy_grid import cell_distances
from robot.geometry import Array, Pose2
from robot.navigation.settings import REFUSED, NavigationSettings
from robot.navigation.walls import Walls

LETHAL, INSCRIBED = 254, 253
"""nav2's costs of a cell in a wall, and of one where the robot's middle cannot be."""
COST_WEIGHT = 6.0
"""What a cell beside a wall costs more than a free one, in free cells."""
BODY_STEP = 0.012
"""Points on and in the robot's outline are compared with walls at this distance [m]."""
BOUND_STEP = 0.005
"""Bounds are rounded up to multiples of this [m]: those that hardly differ share a free space. Half
and twice: 17 and 5 of them, in place of 9, for bounds of 8 to 50 mm, and ways keep 1.3 and 5 mm
more than they must in the mean, in place of 2.5."""
BEYOND = 3
"""Cells around tape that count as tape where tape is ignored: its edge is blurred."""


@dataclass(frozen=True, eq=False)
class FreeSpace:
    """Distances to walls on a field, and the robot's outline that has to fit between them."""

    origin: tuple[float, float]
    """Lower left corner of the cells in the map [m]."""
    side: float
    """Of a cell [m]."""
    distance: NDArray[np.float32]
    """(h, w) from each cell's middle to the nearest wall [m], row 0 at the bottom; 0 in a wall."""
    body: Array
    """(k, 2) points of the robot [m], in its frame."""
    radius: float
    """Of the circle about the robot's middle in which it can turn [m]."""
    settings: NavigationSettings
    drive_area: Extent
    """Where robots usually drive [m]."""
    beyond: float = 0.0
    """The distance that counts beyond the floor [m]: there is a wall, or inf is none."""
    bound: float = 0.0
    """By this the outline is grown on the way [m], but not at its ends."""

    @classmethod
    def of(
        cls,
        field: Field,
        outline: Array,
        settings: NavigationSettings,
        said: Walls = Walls(),
        *,
        edge: bool = True,
    ) -> FreeSpace:
        """Return the free space of a field for a robot's outline (k, 2) [m].

        Walls are the edge of the floor unless ``edge`` is False, tape unless it is ignored, other
        dark shapes, what is not free on a ROS map, and the zones that are ``said``.
        """
        if field.grid is None:
            grid = field.light_cells(field.extent)
        else:  # along the map frame's axes, as it may lie turned in it
            grid = field.occupancy(field.grid.resolution)
        walls = ~grid.free
        if said.ignore_tape(field, settings) and field.tape:
            tape = field.occupancy(grid.resolution).data > 0
            around = np.ones((2 * BEYOND + 1, 2 * BEYOND + 1), np.uint8)
            grown = cv2.dilate(tape.astype(np.uint8), around) > 0
            rows, columns = (min(a, b) for a, b in zip(grown.shape, walls.shape, strict=True))
            walls[:rows, :columns] &= ~grown[:rows, :columns]
        walls |= said.cells((grid.origin.x, grid.origin.y), grid.resolution, walls.shape)
        framed = np.pad(walls, 1, constant_values=edge)
        cells = cell_distances(~framed)[1:-1, 1:-1]
        # From the middle of a free cell to the edge of the nearest one that is not.
        distance = np.maximum(cells - 0.5, 0.0).astype(np.float32) * np.float32(grid.resolution)
        return cls(
            origin=(grid.origin.x, grid.origin.y),
            side=grid.resolution,
            distance=distance,
            body=_body(outline),
            radius=float(np.hypot(*outline.T).max()),
            settings=settings,
            drive_area=field.drive_area,
            beyond=0.0 if edge else math.inf,
        )

    @cached_property
    def frame(self) -> Array:
        """(4,) x and y of the lower left corner, a cell's side, and what counts beyond [m]."""
        return np.array([*self.origin, self.side, self.beyond])

    def clearance(self, points: Array) -> Array:
        """Return the distance of points (n, 2) [m] to walls (n,) [m]."""
        rows, columns = self.distance.shape
        column = np.floor((points[:, 0] - self.origin[0]) / self.side).astype(np.intp)
        row = np.floor((points[:, 1] - self.origin[1]) / self.side).astype(np.intp)
        inside = (row >= 0) & (row < rows) & (column >= 0) & (column < columns)
        distances = np.full(len(points), self.beyond)
        distances[inside] = self.distance[row[inside], column[inside]]
        return distances

    def room(self, poses: Array) -> Array:
        """Return the smallest distance of the robot to walls (n,) [m] at poses (n, 3)."""
        cos, sin = np.cos(poses[:, 2])[:, None], np.sin(poses[:, 2])[:, None]
        x, y = self.body[:, 0], self.body[:, 1]
        points = np.stack(
            [poses[:, :1] + cos * x - sin * y, poses[:, 1:2] + sin * x + cos * y], axis=-1
        )
        room: Array = self.clearance(points.reshape(-1, 2)).reshape(points.shape[:2]).min(axis=1)
        return room

    def for_bound(self, radius: float) -> FreeSpace:
        """Return the same for an outline that is grown by a bound [m] of the robot's place."""
        bound = BOUND_STEP * math.ceil(radius / BOUND_STEP - 1e-9)
        if bound <= self.settings.clearance:
            return self
        if bound not in self._grown:
            self._grown[bound] = replace(self, bound=bound)
        return self._grown[bound]

    @cached_property
    def _grown(self) -> dict[float, FreeSpace]:
        """By the bound [m]; each keeps the costs of its cells."""
        return {}

    @property
    def hollow(self) -> FreeSpace:
        """The same for the rim of the outline: enough for a robot that comes from free floor."""
        return replace(self, body=self.body[-(len(self.body) // _rings(self.radius)) :])

    @property
    def kept(self) -> float:
        """Room that the outline keeps to walls on the way [m]."""
        return max(self.settings.clearance, self.bound)

    @property
    def thorough(self) -> bool:
        """Whether slow searches are worth it: not where a way nearer to walls will do as well."""
        return self.bound == 0 or self.settings.narrow_ways == REFUSED

    def fits(self, poses: Array) -> bool:
        """Whether the robot's outline keeps its clearance at poses (n, 3) [m, m, rad]."""
        return bool((self.room(poses) >= self.kept).all())

    def admits(self, goal: Pose2) -> bool:
        """Whether the robot's outline, not grown by a bound, keeps its clearance at a goal."""
        return bool(self.room(goal.to_array()[None])[0] >= self.settings.clearance)

    def turns(self, points: Array) -> bool:
        """Whether the robot may have any heading at points (n, 2) [m]."""
        needed = self.radius + self.kept
        return bool((self.clearance(points) >= needed).all())

    @cached_property
    def regions(self) -> NDArray[np.int32]:
        """(h, w) number of each cell's region; 0 where the robot fits in no heading.

        Its middle goes from one region to another one nowhere: that is known before any search.
        """
        inner = float(np.hypot(*self.hollow.body.T).min()) - self.side
        _, regions = cv2.connectedComponents((self.distance > inner).astype(np.uint8))
        return np.asarray(regions, np.int32)

    def are_parted(self, start: Pose2, goal: Pose2) -> bool:
        """Whether walls lie all around one of two places and not around the other one.

        A robot that stands on a wall may leave it to each side: then it is not known.
        """
        if self.stands_in_wall(start):
            return False
        regions = self._region(start), self._region(goal)
        return regions[0] != regions[1] and min(regions) > 0

    def _region(self, pose: Pose2) -> int:
        rows, columns = self.regions.shape
        row = math.floor((pose.y - self.origin[1]) / self.side)
        column = math.floor((pose.x - self.origin[0]) / self.side)
        inside = 0 <= row < rows and 0 <= column < columns
        return int(self.regions[row, column]) if inside else 0

    def stands_in_wall(self, pose: Pose2) -> bool:
        """Whether the robot's outline touches a wall at a pose."""
        return bool(self.room(pose.to_array()[None])[0] <= 0)

    @cached_property
    def costs(self) -> NDArray[np.float32]:
        """(h, w) what a way through each cell of the planner's grid costs; inf is a wall.

        The robot may have any heading in a cell that is no wall. Costs fall with the distance to
        walls as in nav2's inflation layer.
        """
        near, distance = self._inflation()
        costs = np.where(distance < self._needed, np.inf, 1.0 + COST_WEIGHT * near)
        return costs.astype(np.float32)

    def layer(self) -> NDArray[np.uint8]:
        """Return the same in nav2's numbers (h, w).

        254 is a wall, 253 where the robot could not turn, then from 252 down to 0, which is free.
        """
        near, distance = self._inflation()
        layer = np.where(distance < self._needed, INSCRIBED, np.rint((INSCRIBED - 1) * near))
        return np.where(distance <= 0, LETHAL, layer).astype(np.uint8)

    @property
    def _needed(self) -> float:
        """The least distance to walls where the robot may have any heading [m]."""
        # A path between the middles of cells comes nearer to walls by up to half a diagonal.
        return self.radius + self.kept + self.settings.resolution * math.sqrt(0.5)

    def _inflation(self) -> tuple[Array, Array]:
        """Return how near walls are, from 1 down to 0, and their distance [m], both (h, w)."""
        height, width = self.shape
        rows, columns = np.mgrid[:height, :width] + 0.5
        points = np.column_stack([columns.ravel(), rows.ravel()]) * self.settings.resolution
        distance = self.clearance(points + self.origin).reshape(height, width)
        beyond = np.maximum(distance - self._needed, 0.0)
        near = np.exp(-self.settings.cost_scaling_factor * beyond)
        near[distance > self.settings.inflation_radius] = 0.0
        return near, distance

    @property
    def shape(self) -> tuple[int, int]:
        """Rows and columns of the planner's grid."""
        share = self.side / self.settings.resolution
        rows, columns = self.distance.shape
        return max(1, math.floor(rows * share + 1e-6)), max(1, math.floor(columns * share + 1e-6))

    @property
    def extent(self) -> Extent:
        """The floor [m]."""
        (x, y), (rows, columns) = self.origin, self.distance.shape
        return x, y, x + columns * self.side, y + rows * self.side

    def cell(self, x: float, y: float) -> tuple[int, int]:
        """Return row and column of a place [m] in the planner's grid; it may be beyond."""
        resolution = self.settings.resolution
        row = math.floor((y - self.origin[1]) / resolution)
        return row, math.floor((x - self.origin[0]) / resolution)


def _body(outline: Array) -> Array:
    """Return points on and in an outline, so dense that no tape passes between them."""
    around = [outline]
    following = np.roll(outline, -1, axis=0)
    for start, end in zip(outline, following, strict=True):
        parts = max(1, math.ceil(float(np.hypot(*(end - start))) / BODY_STEP))
        shares = np.arange(1, parts)[:, None] / parts
        around.append(start + shares * (end - start))
    rim = np.concatenate(around)
    # The outline is convex, and its middle within: rings that shrink to it fill it.
    rings = _rings(float(np.hypot(*outline.T).max()))
    return np.concatenate([rim * share for share in np.arange(1, rings + 1) / rings])


def _rings(radius: float) -> int:
    return max(1, math.ceil(radius / (2 * BODY_STEP)))
