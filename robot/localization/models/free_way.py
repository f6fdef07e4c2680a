"""A scan fits a pose when its rays end on walls, and run through free space before."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from robot.geometry import Array
from robot.localization.models.likelihood_field import LikelihoodField
from robot.localization.models.likelihood_field_prob import LikelihoodFieldProb
from robot.scan import Scan, evenly

SHARES = (0.5, 0.8, 0.3, 0.65, 0.9)
"""Where along the way rays are looked at, one after the other."""


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
    """So far before its end a way is looked at no more [m]: walls of maps are thicker than real."""

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
