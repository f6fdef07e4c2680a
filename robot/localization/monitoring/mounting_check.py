"""Is the camera mounted as drawn, and the map of this floor? From what no pose explains in scans.

The state is projected out of the residuals, as receivers of satellite navigation do it (RAIM: Brown
1992); what is left is compared with what a pitch or a roll of the camera, or another scale of the
map, would leave.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from robot.geometry import Array

MEMORY = 6.0
"""Scans older than this hardly count [s]."""
RAYS_WORTH = 0.1
"""Neighbouring rays, and scans that follow each other, err together: one counts for so many."""
PRIOR = np.diag(1 / np.square([math.radians(1.0), math.radians(1.0), 0.03]))
"""How far off pitch, roll and scale usually are at most."""


@dataclass(frozen=True, slots=True)
class MountingError:
    """How far camera and map seem to be off."""

    pitch: float
    """[rad], positive where ranges are too long."""
    roll: float
    """[rad]"""
    scale: float
    """Of the map, as a share of it: positive where it is drawn too large."""
    covariance: Array = field(repr=False)
    """(3, 3) of these."""
    explained: float
    """Share of what no pose explains that these explain."""
    unexplained: float
    """Mean square of what is left, in spreads of a ray."""

    @property
    def tilt(self) -> float:
        """Pitch and roll together [rad]."""
        return math.hypot(self.pitch, self.roll)


class MountingCheck:
    """Adds up scans."""

    def __init__(self) -> None:
        self._sums = np.zeros((4, 4))
        self._rays = 0.0
        self._caused = np.zeros((3, 3))
        """Pose error (3,) [m, m, rad] by pitch, roll and scale, at the last scan."""

    def observe(self, sums: Array, rays: int, elapsed: float, known: Array) -> None:
        """Add a scan.

        Args:
            sums: of ``residual_sums`` (7, 7).
            rays: how many lie on an edge.
            elapsed: since the last one [s].
            known: information (3, 3) of the pose without this scan.
        """
        keep = math.exp(-elapsed / MEMORY)
        by_pose = sums[:3, :3] * RAYS_WORTH + known
        gain = np.asarray(np.linalg.solve(by_pose, sums[:3, 3:] * RAYS_WORTH), dtype=np.float64)
        left = sums[3:, 3:] - sums[3:, :3] @ gain
        self._sums = keep * self._sums + left
        self._rays = keep * self._rays + rays
        self._caused = -gain[:, :3]

    def error(self) -> MountingError:
        """The likeliest."""
        information = RAYS_WORTH * self._sums[:3, :3] + PRIOR
        covariance = np.asarray(np.linalg.inv(information), dtype=np.float64)
        found = covariance @ (RAYS_WORTH * self._sums[:3, 3])
        whole = max(float(self._sums[3, 3]), 1e-12)
        explained = float(2 * found @ self._sums[:3, 3] - found @ self._sums[:3, :3] @ found)
        rest = (whole - explained) / max(self._rays, 1.0)
        pitch, roll, scale = found.tolist()
        return MountingError(pitch, roll, scale, covariance, explained / whole, rest)

    def pose_error(self, error: MountingError) -> Array:
        """How far (3,) [m, m, rad] the last pose is off by that, along the map's axes."""
        offset: Array = self._caused @ np.array([error.pitch, error.roll, error.scale])
        return offset
