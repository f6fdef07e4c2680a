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
from robot.localization.kernels.matrices import inverse, solved

MEMORY = 20.0
"""Scans older than this hardly count [s]."""
RAYS_WORTH = 0.1
"""Neighbouring rays, and scans that follow each other, err together: one counts for so many."""
EXACT, INEXACT, ADAPTED = 0.15, 4.0, 0.1
"""Rays lie no closer to their edges than this, nor farther, in usual spreads; and how much of that
is learnt from a scan. Without it a few rays that meet another edge than they should would count for
more than all that are exact."""
PRIOR = np.diag(1 / np.square([math.radians(0.3), math.radians(0.3), 0.0015]))
"""How far off pitch, roll and scale usually are: a camera that was mounted with care."""
STANDS_OUT, EXPLAINS = 2.0, 0.3
"""A tilt of so many standard deviations, which explains such a share, is taken off the scans."""
BLEND = 0.2
"""How much of what is new of the tilt is taken off the next scan."""


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
        self.exactness = 0.25
        """How far rays lie from their edges, in usual spreads."""
        self.applied = np.zeros(2)
        """Pitch and roll [rad] that are taken off the scans."""

    def observe(self, sums: Array, rays: int, elapsed: float) -> None:
        """Add a scan.

        Args:
            sums: of ``residual_sums`` (7, 7).
            rays: how many lie on an edge.
            elapsed: since the last one [s].
        """
        keep = math.exp(-elapsed / MEMORY)
        gain = self.look(sums)
        left = sums[3:, 3:] - sums[3:, :3] @ gain
        self._sums = keep * self._sums + left
        self._rays = keep * self._rays + rays
        exactness = self.exactness * self.error().unexplained ** (0.5 * ADAPTED)
        self.exactness = min(max(exactness, EXACT), INEXACT)

    def look(self, sums: Array) -> Array:
        """Only see how a pose (3,) takes up tilt, scale and distances (3, 4) in a scan's sums."""
        by_pose = sums[:3, :3] * RAYS_WORTH + np.eye(3)
        gain = solved(by_pose, sums[:3, 3:] * RAYS_WORTH)
        self._caused = -gain[:, :3]
        return gain

    def error(self) -> MountingError:
        """The likeliest, whatever is taken off already."""
        return self._solved(RAYS_WORTH)

    def follow(self, error: MountingError) -> None:
        """Take off what stands out."""
        tilt = np.array([error.pitch, error.roll])
        sure = tilt @ inverse(np.ascontiguousarray(error.covariance[:2, :2])) @ tilt > STANDS_OUT**2
        wanted = tilt if sure and error.explained > EXPLAINS else np.zeros(2)
        self.applied = self.applied + BLEND * (wanted - self.applied)

    def _solved(self, worth: float) -> MountingError:
        information = worth * self._sums[:3, :3] + PRIOR
        covariance = inverse(information)
        result = covariance @ (worth * self._sums[:3, 3])
        whole = max(float(self._sums[3, 3]), 1e-12)
        explained = float(2 * result @ self._sums[:3, 3] - result @ self._sums[:3, :3] @ result)
        rest = (whole - explained) / max(self._rays, 1.0)
        pitch, roll, scale = result.tolist()
        return MountingError(pitch, roll, scale, covariance, explained / whole, rest)

    def pose_error(self, error: MountingError, scale_sd: float) -> tuple[Array, Array]:
        """How far the last pose is off by what is not taken off, along the map's axes.

        Args:
            error: as it is known.
            scale_sd: how far the map's scale may be off besides.

        Returns:
            Mean (3,) and covariance (3, 3) [m, m, rad].
        """
        left = np.array([error.pitch, error.roll, error.scale])
        left[:2] -= self.applied
        covariance = error.covariance.copy()
        covariance[2, 2] += scale_sd**2
        return self._caused @ left, self._caused @ covariance @ self._caused.T
