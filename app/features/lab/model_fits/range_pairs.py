"""Pair measured ranges with the exact ones at the true poses, and compute their errors."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from robot.fields.field import Field
from robot.fields.ray_casting import cast_rays
from robot.geometry import Array, Pose2, heading_vectors
from robot.localization.models.beam import MISSED_AT_END, MISSED_AT_START
from robot.scan import Scan

FAR_OFF = 0.03
"""A return farther than this from the expected edge is false [m], as in the scanner's benchmark:
it is a hundred times the spread of a good range, and less than the 50 mm to the tape's other
edge."""

TO_SD = 1.4826
"""Ratio of standard deviation to median absolute deviation, for a normal distribution."""


@dataclass(frozen=True, eq=False)
class RangePairs:
    """n rays of some scans, each with its measured and its expected range.

    Rays without any sight are left out; ``scan`` and ``ray`` say which rays these are.
    """

    measured: Array
    """(n,) [m]; +inf is no return."""
    expected: Array
    """(n,) [m] range to the first edge after the start of sight; +inf if none is within the range.

    For a ray that returned from about the start of sight, edges count from ``MISSED_AT_START``
    before it.
    """
    bearings: Array
    """(n,) [rad] from +x of the scan's centre, anticlockwise."""
    scan: NDArray[np.int64]
    """(n,) number of the scan, rising."""
    ray: NDArray[np.int64]
    """(n,) number of the ray within its scan."""
    sure: NDArray[np.bool_]
    """(n,) whether the ray surely sees the expected edge, as the beam model (``Beam``) defines."""
    sight: Array
    """(n, 2) begin and end of the ray's sight [m]; the end is at most the longest range."""

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
        """(n,) whether the ray returned the expected range, within ``FAR_OFF``."""
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
    """Cast the rays of scans from their true poses at a field's exact edges.

    Returns from beyond the longest range [m] count as no return.

    Raises:
        ValueError: there are no scans, or another number of poses.
    """
    if not scans or len(scans) != len(poses):
        raise ValueError(
            f"{len(scans)} scans and {len(poses)} poses; valid is one or more, as many of both"
        )
    cut_scans = [scan.within(0.0, range_max) for scan in scans]
    counts = [len(scan.ranges) for scan in cut_scans]
    measured = np.concatenate([scan.ranges for scan in cut_scans])
    # A sensor that does not give the borders of its sight sees everywhere.
    everywhere = np.array([[0.0, np.inf]])
    sight = np.concatenate(
        [
            everywhere.repeat(count, axis=0) if scan.sight is None else scan.sight
            for scan, count in zip(cut_scans, counts, strict=True)
        ]
    )
    sighted = np.array([scan.sight is not None for scan in cut_scans]).repeat(counts)
    near, far = sight.T
    # The line of an edge seen beside a ray may also end the ray a little before its sight begins.
    begin = near - np.minimum(MISSED_AT_START, near) * (measured < near + MISSED_AT_START)
    centres = [pose @ scan.robot_from_scan for pose, scan in zip(poses, cut_scans, strict=True)]
    bearings = np.concatenate([scan.bearings for scan in cut_scans])
    starts = np.repeat([centre.to_array() for centre in centres], counts, axis=0)
    starts[:, 2] += bearings
    expected = _cast(field, starts, begin, range_max)
    surely_near, surely_far = (
        near + MISSED_AT_START * sighted,
        np.minimum(far - MISSED_AT_END * sighted, range_max),
    )
    useful = ~np.isnan(near)
    return RangePairs(
        measured=measured[useful],
        expected=expected[useful],
        bearings=bearings[useful],
        scan=np.arange(len(cut_scans)).repeat(counts)[useful],
        ray=np.concatenate([np.arange(count) for count in counts])[useful],
        sure=((surely_near <= expected) & (expected <= surely_far))[useful],
        sight=np.minimum(sight, range_max)[useful],
    )


def _cast(field: Field, starts: Array, begin: Array, range_max: float) -> Array:
    """Return distances (n,) [m] from the starts to the first edges beyond the start of sight.

    Tape below the camera's view hides nothing, so a ray is cast from where its sight begins.
    """
    begins = starts.copy()
    begins[:, :2] += begin[:, None] * heading_vectors(starts[:, 2])
    # A ray without any sight is cast too, and left out later.
    ways = np.empty((len(starts), 1))
    cast_rays(np.nan_to_num(begins), np.zeros(1), field.edge_index, range_max, ways)
    expected: Array = begin + ways[:, 0]
    return np.where(expected <= range_max, expected, np.inf)


@dataclass(frozen=True, slots=True)
class RangeStatistics:
    """Statistics of the rays of one bin. A figure without rays is nan."""

    low: float
    """Lower border of the bin [m] or [rad]."""
    high: float
    count: int
    """Rays that returned the expected range, within ``FAR_OFF``: bias and spread are of these."""
    bias: float
    """Mean of measured minus exact range [m]."""
    sd: float
    """Standard deviation of measured minus exact range [m]."""
    robust_sd: float
    """1.4826 times the median absolute deviation [m]: the standard deviation without outliers."""
    expected: int
    """Rays that surely see an edge."""
    missed: float
    """Share of those without a right return: no return, or a false one."""
    returns: int
    """Rays that returned anything."""
    false: float
    """Share of those with a false return: farther than ``FAR_OFF`` from the edge, or no edge."""


def by_distance(pairs: RangePairs, borders: Array) -> list[RangeStatistics]:
    """Return statistics between borders (k + 1,) [m], rising.

    Expected ranges are sorted into bins by their exact distance, returns by their measured one.
    """
    return _pairs_by(pairs, pairs.expected, pairs.measured, borders)


def by_bearing(pairs: RangePairs, borders: Array) -> list[RangeStatistics]:
    """Return statistics between borders (k + 1,) of bearings [rad], rising."""
    return _pairs_by(pairs, pairs.bearings, pairs.bearings, borders)


def overall(pairs: RangePairs) -> RangeStatistics:
    """Return statistics of all rays."""
    return _pairs_by(pairs, pairs.bearings, pairs.bearings, np.array([-math.inf, math.inf]))[0]


def _pairs_by(
    pairs: RangePairs, expected: Array, measured: Array, borders: Array
) -> list[RangeStatistics]:
    """Return statistics of the rays between borders, by expected and by measured values."""
    right, bins = pairs.right, []
    for low, high in zip(borders[:-1].tolist(), borders[1:].tolist(), strict=True):
        due, came = ((low <= values) & (values < high) for values in (expected, measured))
        errors = pairs.residuals[right & due]
        sure, returned = pairs.sure & due, pairs.returned & came
        several = len(errors) > 1
        bins.append(
            RangeStatistics(
                low,
                high,
                count=len(errors),
                bias=float(errors.mean()) if len(errors) else math.nan,
                sd=float(errors.std(ddof=1)) if several else math.nan,
                robust_sd=TO_SD * float(np.median(np.abs(errors - np.median(errors))))
                if several
                else math.nan,
                expected=int(sure.sum()),
                missed=_share(sure & ~right, sure),
                returns=int(returned.sum()),
                false=_share(returned & ~right, returned),
            )
        )
    return bins


def _share(some: NDArray[np.bool_], whole: NDArray[np.bool_]) -> float:
    return float(some.sum() / whole.sum()) if whole.any() else math.nan
