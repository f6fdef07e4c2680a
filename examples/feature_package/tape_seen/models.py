"""A sensor model, ``near_tape``: a ray fits if it ends near an edge of tape."""

import numpy as np
from scipy.spatial import cKDTree

from app.features.own_models.named_models import NamedModels
from app.settings.config import Config
from robot.fields.field import Field
from robot.geometry import Array
from robot.scan import Scan

STEP_M = 0.005
REACH_M = 0.05
SD_M = 0.005


def models(config: Config, field: Field) -> tuple[NamedModels]:
    """Return what the filter's drop-downs offer besides."""
    return (NamedModels(field, sensors={"near_tape": NearTape}),)


class NearTape:
    """Rates each ray by the distance between its end and the nearest edge, up to 5 cm."""

    def __init__(self, edges: Array) -> None:
        lengths = np.hypot(*(edges[:, 2:] - edges[:, :2]).T)
        points = [
            np.linspace(edge[:2], edge[2:], 2 + int(length / STEP_M))
            for edge, length in zip(edges, lengths, strict=True)
        ]
        self._edges = cKDTree(np.vstack(points))

    def log_likelihood(self, poses: Array, scan: Scan) -> Array:
        """Return (n,) for poses (n, 3)."""
        cos, sin = np.cos(poses[:, 2:]), np.sin(poses[:, 2:])
        x, y = scan.points()[::3].T
        ends = poses[:, None, :2] + np.stack([cos * x - sin * y, sin * x + cos * y], axis=2)
        apart, _ = self._edges.query(ends, distance_upper_bound=REACH_M)
        variance = SD_M**2 + scan.extra_sd**2
        fits: Array = (-0.5 * np.minimum(apart, REACH_M) ** 2 / variance).sum(axis=1)
        return fits
