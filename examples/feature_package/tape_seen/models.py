"""A sensor model, ``near_tape``: a ray fits if it ends near an edge of tape that faces it."""

import numpy as np
from scipy.spatial import cKDTree

from app.features.own_models.named_models import NamedModels
from app.settings.config import Config
from robot.fields.field import Field
from robot.geometry import Array
from robot.scan import Scan

STEP_M = 0.005
REACH_M = 0.03
SD_M = 0.008
FACING_M = 0.05
"""An edge that faces away counts as this much farther, twice."""


def models(config: Config, field: Field) -> tuple[NamedModels]:
    """Return what the filter's drop-downs offer besides."""
    return (NamedModels(field, sensors={"near_tape": NearTape}),)


class NearTape:
    """Rates each ray by the distance between its end and the nearest edge, up to 3 cm."""

    def __init__(self, edges: Array) -> None:
        points = []
        for begin, end in edges.reshape(-1, 2, 2):
            length = float(np.hypot(*(end - begin)))
            along = np.linspace(begin, end, 2 + int(length / STEP_M))
            dx, dy = FACING_M * (end - begin) / length  # the tape is to the left
            points.append(np.column_stack([along, np.tile([-dy, dx], (len(along), 1))]))
        self._points = np.vstack(points)
        self._edges = cKDTree(self._points)

    def log_likelihood(self, poses: Array, scan: Scan) -> Array:
        """Return (n,) for poses (n, 3)."""
        cos, sin = np.cos(poses[:, 2:]), np.sin(poses[:, 2:])
        x, y = scan.points()[::3].T
        ways = np.stack([cos * x - sin * y, sin * x + cos * y], axis=2)
        ends = poses[:, None, :2] + ways
        facing = FACING_M * ways / np.linalg.norm(ways, axis=2, keepdims=True)
        _, nearest = self._edges.query(np.concatenate([ends, facing], axis=2))
        apart = np.linalg.norm(self._points[nearest, :2] - ends, axis=2)
        variance = SD_M**2 + scan.extra_sd**2
        fits: Array = (-0.5 * np.minimum(apart, REACH_M) ** 2 / variance).sum(axis=1)
        return fits
