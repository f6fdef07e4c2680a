"""Prepare a ROS map for a laser robot's filter."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from app.features.lab.localize.settings import LaserSettings
from robot.fields.field import Field, FieldError
from robot.fields.grid_field import field_from_grid
from robot.fields.grid_map import load_map_yaml
from robot.fields.occupancy_grid import MapError, OccupancyGrid, cell_distances
from robot.geometry import Array, Pose2, turned_covariance
from robot.localization.models.entry_field import EntryField
from robot.localization.models.likelihood_field import LikelihoodField
from robot.localization.models.likelihood_field_prob import LikelihoodFieldProb
from robot.localization.models.sensor_models import SensorModel, SensorParameters, sensor_model
from robot.scan import Scan, evenly

SHARES = (0.5, 0.8, 0.3, 0.65, 0.9)
"""Where along the way rays are looked at, one after the other."""


@dataclass(frozen=True)
class LaserMap:
    """A map for the filter, which works in the frame of the cells; results are in the map frame."""

    field: Field
    """The map in the frame of the cells: rows along x, the first cell's corner at the origin."""
    map_from_cells: Pose2

    @classmethod
    def of(cls, grid: OccupancyGrid, name: str) -> LaserMap:
        """Prepare a map; its cells may be turned against its frame.

        Raises:
            FieldError: the map has no occupied cell or no free one.
        """
        return cls(field_from_grid(replace(grid, origin=Pose2()), name), grid.origin)

    @classmethod
    def load(cls, path: Path) -> LaserMap:
        """Load the YAML of a map_server map.

        Raises:
            FieldError: a file is missing or broken, has absurd values, or the map is unusable.
        """
        if path.suffix.lower() == ".svg":
            raise FieldError(f"{path} is a drawing of tape; valid for a laser is a map's YAML")
        try:
            return cls.of(load_map_yaml(path), path.stem)
        except MapError as error:
            raise FieldError(str(error)) from error

    @property
    def grid(self) -> OccupancyGrid:
        """The cells of the map."""
        assert self.field.grid is not None
        return self.field.grid

    @property
    def free_area(self) -> float:
        """Area of the free floor [m²]."""
        return float(np.count_nonzero(self.grid.free)) * self.grid.resolution**2

    @property
    def across(self) -> float:
        """Diagonal of the map [m]."""
        return float(np.hypot(*self.grid.data.shape)) * self.grid.resolution

    def pose_in_map(self, pose: Pose2) -> Pose2:
        """Return a pose of the filter in the map's frame."""
        return self.map_from_cells @ pose

    def covariance_in_map(self, covariance: Array) -> Array:
        """Return a covariance (3, 3) of the filter in the map's frame."""
        return turned_covariance(covariance, self.map_from_cells.theta)

    def sensor(self, parameters: SensorParameters, laser: LaserSettings) -> SensorModel:
        """Return the sensor model that the parameters name."""
        reach = parameters.laser_likelihood_max_dist
        model = sensor_model(parameters, wall_field(self.grid, reach), self.field.edges)
        if laser.free_way_weight == 0 or not isinstance(
            model, LikelihoodField | LikelihoodFieldProb
        ):
            return model
        ways = LikelihoodField(
            free_field(self.grid, reach),
            laser.free_way_sd,
            1.0,
            laser.free_way_false,
            1.0,
            parameters.max_beams,
        )
        return FreeWay(model, ways, laser.free_way_weight, laser.free_way_margin)


def wall_field(grid: OccupancyGrid, max_distance: float) -> EntryField:
    """The table of a map's occupied cells; 4 million cells take less than a second.

    Args:
        grid: the map; its rows lie along x.
        max_distance: what is farther from a wall counts as this far [m].

    Raises:
        FieldError: the map is turned against its frame, or no cell is occupied.
    """
    if not grid.occupied.any():
        raise FieldError("the map has no occupied cell to localize by")
    return _distances_from(grid.occupied, grid, max_distance)


def free_field(grid: OccupancyGrid, max_distance: float) -> EntryField:
    """The same of its free cells.

    Raises:
        FieldError: the map is turned against its frame, or no cell is free.
    """
    if not grid.free.any():
        raise FieldError("the map has no free cell to drive on")
    return _distances_from(grid.free, grid, max_distance)


def _distances_from(
    chosen: NDArray[np.bool_], grid: OccupancyGrid, max_distance: float
) -> EntryField:
    """Distances from chosen cells (h, w), one table for all directions."""
    if grid.origin.theta != 0:
        raise FieldError(f"the map is turned by {grid.origin.theta:g} rad; valid is 0")
    # Beyond the map's rim distances go on, until they are the greatest.
    rim = math.ceil(max_distance / grid.resolution) + 1
    cells = cell_distances(np.pad(~chosen, rim, constant_values=True))
    distances = np.minimum(cells * np.float32(grid.resolution), np.float32(max_distance))
    first = (0.5 - rim) * grid.resolution
    origin = grid.origin.x + first, grid.origin.y + first
    return EntryField(distances[None], origin, grid.resolution, max_distance, grid.resolution)


@dataclass(frozen=True)
class FreeWay:
    """A likelihood field that does not see through walls.

    To a likelihood field alone a room full of furniture explains every scan, for wherever a ray
    ends, something is near. As in map matching (Probabilistic Robotics, section 6.5), free space
    counts as well: a place along each ray should lie in a free cell. Its distance d from one costs
    as a ray's end off a wall does. Each ray is looked at in one place only, at another share of its
    way than its neighbours: that is one look-up more for each.
    """

    ends: LikelihoodField | LikelihoodFieldProb
    ways: LikelihoodField
    """By distances from free cells."""
    weight: float
    """Of the ways, beside the ends."""
    margin: float
    """A way is examined up to this distance before its end [m]: walls in maps are thicker than
    real."""

    def log_likelihood(self, poses: Array, scan: Scan) -> Array:
        """Log-likelihood (n,) of a scan at poses (n, 3), up to a constant."""
        ends = self.ends.log_likelihood(poses, scan)
        return ends + self.weight * self.ways.log_likelihood(poses, self._on_the_way(scan))

    def count_rays(self, poses: Array, scan: Scan) -> int:
        """How many rays the log-likelihood is the sum of."""
        return self.ends.count_rays(poses, scan)

    def _on_the_way(self, scan: Scan) -> Scan:
        """The scan with rays that end on the way of those that count."""
        hits = np.flatnonzero(scan.hit)
        used = hits[evenly(len(hits), self.ways.max_beams)] if len(hits) else hits
        until = scan.ranges[used] - self.margin
        ranges = np.where(until > 0, until * np.resize(SHARES, len(used)), np.inf)
        return Scan(
            scan.stamp, scan.bearings[used], ranges, scan.robot_from_scan, None, scan.extra_sd
        )
