"""A scan: distances by bearing, as a laser would report them."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from robot.geometry import Array, Pose2, heading_vectors


@dataclass(frozen=True, slots=True)
class Scan:
    """Ranges by bearing around a centre; no return is +inf."""

    stamp: float
    """When the measurement was made, on the robot's clock [s]."""
    bearings: Array
    """(k,) [rad], from +x of the scan's centre, anticlockwise."""
    ranges: Array
    """(k,) [m] from the scan's centre; +inf where nothing was found."""
    robot_from_scan: Pose2 = field(default=Pose2())
    """Where the rays start; the line scanner's start at the robot's own origin."""

    sight: Array | None = None
    """(k, 2) from where to where each ray can see [m], nan if nowhere; None is everywhere."""
    extra_sd: float = 0.0
    """Standard deviation [m] that a sensor model adds to its own for this scan."""
    clear: Array | None = None
    """(k,) probability that a ray returns an edge which is due, as far as noise and light of the
    picture let it; None is certainty."""

    def within(self, low: float, high: float) -> Scan:
        """The same scan as a laser of such a range would report it.

        A return from nearer says nothing: its ray sees nowhere. One from farther is no return.
        """
        near, far = self.ranges < low, self.hit & (self.ranges > high)
        if not (near | far).any():
            return self
        sight = self.sight
        if near.any():
            sight = np.tile([0.0, np.inf], (len(near), 1)) if sight is None else sight.copy()
            sight[near] = np.nan
        return replace(self, ranges=np.where(near | far, np.inf, self.ranges), sight=sight)

    @property
    def hit(self) -> np.ndarray[tuple[int], np.dtype[np.bool_]]:
        """Which rays returned something, (k,)."""
        return np.isfinite(self.ranges)

    def points(self) -> Array:
        """The end points of the rays that hit, (n, 2) [m] in the robot frame."""
        hit = self.hit
        local = heading_vectors(self.bearings[hit]) * self.ranges[hit, None]
        return self.robot_from_scan.apply(local)


@lru_cache(maxsize=100)
def evenly(count: int, most: int) -> NDArray[np.intp]:
    """At most so many indices, evenly spread over 0 to count - 1: the rays that are used."""
    indices = np.linspace(0, count - 1, min(count, most)).astype(np.intp)
    indices.flags.writeable = False
    return indices
