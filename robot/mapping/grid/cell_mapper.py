"""What every mapper of cells offers: a way to draw an occupancy grid."""

from __future__ import annotations

from typing import Protocol

from robot.fields.occupancy_grid import OccupancyGrid
from robot.geometry import Array, Pose2
from robot.mapping.grid.beams import Beams


class CellMapper(Protocol):
    """Draws cells from what a robot saw; the first look is taken where the map begins."""

    def update(self, moved: Pose2, beams: Beams) -> None:
        """Take a look after a motion by odometry."""

    def finish(self) -> None:
        """Make the map as good as it gets, after the last look."""

    @property
    def path(self) -> Array:
        """(t, 3) poses, one for each look [m, m, rad]."""

    @property
    def grid(self) -> OccupancyGrid:
        """The map."""

    @property
    def ends(self) -> Array:
        """(n, 2) where beams ended on average in each occupied cell [m]."""
