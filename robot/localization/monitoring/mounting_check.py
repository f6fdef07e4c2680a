"""Is the camera mounted as drawn, and the map of this floor? From what no pose explains in scans.

The state is projected out of the residuals, as receivers of satellite navigation do it (RAIM: Brown
1992); what is left is compared with what a pitch or a roll of the camera, or another scale of the
map, would leave.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
from numba import njit

from robot.geometry import Array
from robot.localization.kernels.matrices import inverse

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
HELD = np.diag(1 / np.square([0.03, 0.03, 0.1]))
"""How firmly a pose is held where it was by what is known besides a scan [1/m², 1/m², 1/rad²]."""
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
        self.error = self._likeliest()
        """The likeliest, whatever is taken off already."""

    def observe(self, sums: Array, rays: int, elapsed: float) -> None:
        """Add a scan.

        Args:
            sums: of ``residual_sums`` (7, 7).
            rays: how many lie on an edge.
            elapsed: since the last one [s].
        """
        keep = math.exp(-elapsed / MEMORY)
        left = self.look(sums)
        self._sums = keep * self._sums + left
        self._rays = keep * self._rays + rays
        self.error = self._likeliest()
        exactness = self.exactness * self.error.unexplained ** (0.5 * ADAPTED)
        self.exactness = min(max(exactness, EXACT), INEXACT)

    def look(self, sums: Array) -> Array:
        """Only see what tilt and scale do to a pose; returns what no pose explains (4, 4)."""
        left, self._caused = _taken_up(sums, self._caused)
        return left

    def follow(self) -> None:
        """Take off what stands out."""
        error = self.error
        tilt = np.array([error.pitch, error.roll])
        (a, b), (_, d) = error.covariance[:2, :2].tolist()
        square = d * error.pitch**2 - 2 * b * error.pitch * error.roll + a * error.roll**2
        sure = square > STANDS_OUT**2 * (a * d - b * b)
        wanted = tilt if sure and error.explained > EXPLAINS else np.zeros(2)
        self.applied = self.applied + BLEND * (wanted - self.applied)

    def _likeliest(self) -> MountingError:
        values, covariance, explained, rest = _explained(self._sums, self._rays)
        pitch, roll, scale = values.tolist()
        return MountingError(pitch, roll, scale, covariance, explained, rest)

    def pose_error(self, scale_sd: float) -> tuple[Array, Array]:
        """How far the last pose is off by what is not taken off, along the map's axes.

        Args:
            scale_sd: how far the map's scale may be off besides what is known [-].

        Returns:
            Mean (3,) and covariance (3, 3) [m, m, rad].
        """
        pitch, roll = self.applied.tolist()
        error = self.error
        left = np.array([error.pitch - pitch, error.roll - roll, error.scale])
        covariance = error.covariance.copy()
        covariance[2, 2] += scale_sd**2
        return self._caused @ left, self._caused @ covariance @ self._caused.T


@njit(cache=True, nogil=True)
def _explained(sums: Array, rays: float) -> tuple[Array, Array, float, float]:
    """Pitch, roll and scale (3,) that explain most of what no pose does, from sums (4, 4).

    Also their covariance (3, 3), the share that they explain, and the mean square of what is left.
    """
    columns = np.ascontiguousarray(sums[:3, :3])
    pull = np.ascontiguousarray(sums[:3, 3])
    covariance = inverse(RAYS_WORTH * columns + PRIOR)
    values = covariance @ (RAYS_WORTH * pull)
    whole = max(sums[3, 3], 1e-12)
    explained = 2 * values @ pull - values @ (columns @ values)
    return values, covariance, explained / whole, (whole - explained) / max(rays, 1.0)


@njit(cache=True, nogil=True)
def _taken_up(sums: Array, caused: Array) -> tuple[Array, Array]:
    """What no pose explains in sums (7, 7) of a scan, and what tilt and scale do to its pose.

    Args:
        sums: of ``residual_sums``.
        caused: pose error (3,) by pitch, roll and scale (3, 3) before.

    Returns:
        Sums (4, 4) without what a pose takes up, and the pose error (3, 3) after.
    """
    by_pose = np.ascontiguousarray(sums[:3, :3]) * RAYS_WORTH
    across = np.ascontiguousarray(sums[:3, 3:])
    gain = inverse(by_pose + np.eye(3)) @ (across * RAYS_WORTH)
    left = sums[3:, 3:] - np.ascontiguousarray(across.T) @ gain
    # Where a scan tells nothing, the pose stays as far off as it was.
    by_errors = np.ascontiguousarray(across[:, :3]) * RAYS_WORTH
    return left, inverse(by_pose + HELD) @ (HELD @ caused - by_errors)
