"""A scan: distances by bearing, as a laser would report them."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from robot import ray_columns as column
from robot.geometry import Array, Pose2, heading_vectors


@dataclass(frozen=True, slots=True, eq=False)
class Scan:
    """Ranges by bearing around a centre; no return is +inf."""

    stamp: float
    """When the measurement was made, on the robot's clock [s]."""
    bearings: Array
    """(k,) [rad], from +x of the scan's centre, anticlockwise."""
    ranges: Array
    """(k,) [m] from the scan's centre; +inf where nothing was found."""
    robot_from_scan: Pose2 = field(default=Pose2())
    """Pose of the rays' start; with the default, the rays start at the robot's origin."""

    sight: Array | None = None
    """(k, 2) nearest and farthest distance that each ray can see [m]; nan if it sees nothing. None
    means that all rays see everything."""
    extra_sd: float = 0.0
    """Standard deviation [m] that a sensor model adds to its own for this scan."""
    clear: Array | None = None
    """(k,) probability that a ray returns an edge that it meets, by the noise and the light of the
    picture; None means certainty."""
    hidden: Array | None = None
    """(k, 2) from where to where [m] something else lies on each ray that may hide an edge: a shoe
    on the floor, for example. Without such a thing it is from inf to -inf; None means no ray has
    one."""
    picture: int = 0
    """Checksum of its picture, which no camera takes twice; 0 without noise, as it then may."""

    def within(self, low: float, high: float) -> Scan:
        """Return the same scan as a laser with this range would report it.

        A return nearer than ``low`` gives no information: its ray sees nothing. A return farther
        than ``high`` becomes no return.
        """
        far = self.hit & (self.ranges > high)
        kept = self.until(np.where(self.ranges < low, 0.0, np.inf))
        return replace(kept, ranges=np.where(far, np.inf, kept.ranges)) if far.any() else kept

    def until(self, ends: Array) -> Scan:
        """Return the same scan, in which rays see nothing from these distances (k,) on [m]."""
        if np.isinf(ends).all():
            return self
        sight = np.tile([0.0, np.inf], (len(ends), 1)) if self.sight is None else self.sight.copy()
        sight[:, 1] = np.minimum(sight[:, 1], ends)
        sight[sight[:, 0] >= sight[:, 1]] = np.nan
        return replace(self, ranges=np.where(self.ranges < ends, self.ranges, np.inf), sight=sight)

    def only(self, rays: NDArray[np.intp]) -> Scan:
        """Return the same scan with some of its rays, by their indices."""
        return replace(
            self,
            bearings=self.bearings[rays],
            ranges=self.ranges[rays],
            sight=None if self.sight is None else self.sight[rays],
            clear=None if self.clear is None else self.clear[rays],
            hidden=None if self.hidden is None else self.hidden[rays],
        )

    @property
    def hit(self) -> np.ndarray[tuple[int], np.dtype[np.bool_]]:
        """Which rays have a return, (k,)."""
        return np.isfinite(self.ranges)

    def points(self) -> Array:
        """Return the end points (n, 2) [m] of the rays with a return, in the robot frame."""
        hit = self.hit
        local = heading_vectors(self.bearings[hit]) * self.ranges[hit, None]
        return self.robot_from_scan.apply(local)


@lru_cache(maxsize=100)
def evenly(count: int, most: int) -> NDArray[np.intp]:
    """Return at most ``most`` indices, spread evenly over 0 to count - 1: the rays to use."""
    indices = np.linspace(0, count - 1, min(count, most)).astype(np.intp)
    indices.flags.writeable = False
    return indices


def rays_of(scan: Scan, most: int) -> Array:
    """Return at most ``most`` rays of a scan, evenly spread (n, 9).

    ``robot.ray_columns`` names the columns.
    """
    rays: Array = _rays_of(scan)[evenly(len(scan.ranges), most)]
    return rays


@lru_cache(maxsize=32)
def _rays_of(scan: Scan) -> Array:
    """Return all rays of a scan (n, 9), which many ask for: each track, check and search."""
    rays = np.empty((len(scan.ranges), column.NUMBER))
    rays[:, column.X], rays[:, column.Y] = scan.robot_from_scan.x, scan.robot_from_scan.y
    rays[:, column.DIRECTION] = scan.robot_from_scan.theta + scan.bearings
    rays[:, column.RANGE] = scan.ranges
    rays[:, column.NEAR : column.CLEAR] = (0.0, np.inf) if scan.sight is None else scan.sight
    rays[:, column.CLEAR] = 1.0 if scan.clear is None else scan.clear
    rays[:, column.HIDDEN_FROM :] = (np.inf, -np.inf) if scan.hidden is None else scan.hidden
    return rays
