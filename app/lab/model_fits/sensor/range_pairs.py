"""Measured ranges beside those that exact edges give from the true poses."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from robot.fields.field import Field
from robot.fields.ray_casting import cast_rays
from robot.geometry import Array, Pose2, heading_vectors
from robot.localization.models.beam import FAR, NEAR
from robot.scan import Scan

FAR_OFF = 0.03
"""A return farther than this from the expected edge is false [m], as in the scanner's benchmark:
a hundred times the spread of a good range, and less than the 50 mm to the tape's other edge."""


@dataclass(frozen=True)
class RangePairs:
    """n rays of some scans, each with what it measured and what it should have.

    Rays that see nowhere are left out; ``scan`` and ``ray`` tell which those here are.
    """

    measured: Array
    """(n,) [m]; +inf is no return."""
    expected: Array
    """(n,) to the first edge from where sight begins [m]; +inf is none within the range.

    Of a ray that returned from about where sight begins: from ``NEAR`` before that.
    """
    bearings: Array
    """(n,) [rad] from +x of the scan's centre, anticlockwise."""
    scan: NDArray[np.int64]
    """(n,) number of the scan, rising."""
    ray: NDArray[np.int64]
    """(n,) number of the ray within its scan."""
    sure: NDArray[np.bool_]
    """(n,) whether the ray surely sees the expected edge, as the beam model (``Beam``) has it."""
    sight: Array
    """(n, 2) from where to where the ray can see [m], ending at the longest range at most."""

    def __len__(self) -> int:
        return len(self.measured)

    @property
    def empty(self) -> NDArray[np.bool_]:
        """(n,) whether no edge is in the ray's sight; rays neither sure nor empty may see one."""
        return self.expected > self.sight[:, 1]

    @property
    def returned(self) -> NDArray[np.bool_]:
        """(n,) whether there is a range."""
        return np.isfinite(self.measured)

    @property
    def right(self) -> NDArray[np.bool_]:
        """(n,) whether the ray returned what it should, within ``FAR_OFF``."""
        return np.abs(self.residuals) < FAR_OFF

    @property
    def residuals(self) -> Array:
        """(n,) measured minus expected [m]; nan unless both are finite."""
        both = self.returned & np.isfinite(self.expected)
        residuals = np.full(len(self), np.nan)
        residuals[both] = self.measured[both] - self.expected[both]
        return residuals


def pair_ranges(
    field: Field, scans: Sequence[Scan], poses: Sequence[Pose2], range_max: float
) -> RangePairs:
    """Cast the rays of scans at a field's exact edges.

    Args:
        field: where the robot was.
        scans: what it measured.
        poses: where it truly was at each scan's stamp, in the map frame.
        range_max: longest range [m]; farther returns count as none.

    Raises:
        ValueError: no scans, or not as many poses.
    """
    if not scans or len(scans) != len(poses):
        raise ValueError(
            f"{len(scans)} scans and {len(poses)} poses; valid is one or more, as many of both"
        )
    seen = [scan.within(0.0, range_max) for scan in scans]
    counts = [len(scan.ranges) for scan in seen]
    measured = np.concatenate([scan.ranges for scan in seen])
    sight = np.concatenate([_sight(scan) for scan in seen])
    starts = np.concatenate(
        [_starts(pose @ scan.robot_from_scan, scan) for pose, scan in zip(poses, seen, strict=True)]
    )
    # Borders are what a sensor told of its sight; one that sees everywhere has none.
    sighted = np.array([scan.sight is not None for scan in seen]).repeat(counts)
    near, far = sight.T
    # The line of an edge that is seen beside a ray also ends the ray a little before its sight.
    before = measured < near + NEAR
    expected = _cast(field, starts, near - np.minimum(NEAR, near) * before, range_max)
    surely_near, surely_far = near + NEAR * sighted, np.minimum(far - FAR * sighted, range_max)
    kept = ~np.isnan(near)
    return RangePairs(
        measured=measured[kept],
        expected=expected[kept],
        bearings=np.concatenate([scan.bearings for scan in seen])[kept],
        scan=np.arange(len(seen)).repeat(counts)[kept],
        ray=np.concatenate([np.arange(count) for count in counts])[kept],
        sure=((surely_near <= expected) & (expected <= surely_far))[kept],
        sight=np.minimum(sight, range_max)[kept],
    )


def _sight(scan: Scan) -> Array:
    """From where to where the rays of a scan see (k, 2) [m]."""
    return np.tile([0.0, np.inf], (len(scan.ranges), 1)) if scan.sight is None else scan.sight


def _starts(centre: Pose2, scan: Scan) -> Array:
    """Where the rays of a scan start, and along which heading (k, 3)."""
    headings = centre.theta + scan.bearings
    return np.column_stack([np.tile([centre.x, centre.y], (len(headings), 1)), headings])


def _cast(field: Field, starts: Array, begin: Array, range_max: float) -> Array:
    """Distances (n,) from the starts to the first edges that are met from a distance on [m].

    Tape below the camera's view hides nothing, so a ray is cast from where its sight begins.
    """
    begins = starts.copy()
    begins[:, :2] += begin[:, None] * heading_vectors(starts[:, 2])
    # A ray that sees nowhere is cast all the same, and left out later.
    found = np.empty((len(starts), 1))
    cast_rays(np.nan_to_num(begins), np.zeros(1), field.edge_index, range_max, found)
    expected: Array = begin + found[:, 0]
    return np.where(expected <= range_max, expected, np.inf)
