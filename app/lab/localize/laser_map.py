"""Prepare a ROS map for a laser robot's filter."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from app.lab.localize.settings import LaserSettings
from robot.fields.field import Field, FieldError
from robot.fields.grid_field import field_from_grid
from robot.fields.grid_map import MapError, OccupancyGrid, load_map_yaml
from robot.geometry import Array, Pose2, turned_covariance
from robot.localization.models.likelihood_field import LikelihoodField
from robot.localization.models.likelihood_field_prob import LikelihoodFieldProb
from robot.localization.models.sensor_models import SensorModel, SensorParameters, sensor_model
from robot.localization.models.wall_field import FreeWay, free_field, wall_field


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
