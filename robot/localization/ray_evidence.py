"""How well do rays fit at a pose, hits and misses alike?

Particles are weighed by where rays end. To tell one place from another that looks much like it, it
also counts that a mark should have been seen and was not. So each ray is cast, as in the beam model
(Probabilistic Robotics, Table 6.1), and what the line scanner may not see is left out: what lies
nearer or farther than the picture shows, tape that is met close to its end, and edges at which the
scanner's own judgement finds no tape (``robot.fields.visibility``).
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
from numba import njit

from robot.fields.edge_index import EdgeIndex
from robot.fields.field import Field
from robot.fields.ray_casting import cast_toward
from robot.fields.visibility import Visibility
from robot.geometry import Array, Pose2
from robot.scanning.tape_edges import GAP

SEEN, STRAY, MISSED = 0.85, 0.12, 0.03
"""Of rays where an edge is due, the shares that return it, something else, and nothing, in a clear
picture. The scanner does better (1 % missed, hardly anything else): these leave room for a floor
that is less clean. In noise and in the dark a scan says itself how much less returns."""
SURPRISE = 0.05
"""Share of the rays that return something where no edge is due."""
NEAR, FAR = 0.015, 0.06
"""So close to where sight begins or ends [m] an edge may be missed: tape is seen as a whole."""
WORSE_ANYWHERE, MISSED_ANYWHERE = 1.8, 0.2
"""How much less likely a ray is at a place that fits but badly, as log-likelihood: one that
returned, than where it fits exactly (as if it were off by 1.9 standard deviations); one that did
not, than where nothing is due."""
END = 0.06
"""So close to its end [m] tape may be missed, and what is behind it seen."""
ACROSS = 0.06
"""A ray that would leave tape by its end, and not across so much [m], may find it too narrow."""


@dataclass(frozen=True, slots=True)
class RayEvidence:
    """Weighs poses by rays that return and rays that do not."""

    index: EdgeIndex = field(repr=False)
    sight: Visibility = field(repr=False)
    """Which edges the scanner sees."""
    range_max: float
    """How far rays reach [m]."""
    sd: float
    """Standard deviation of a near range [m]."""
    slope: float = 0.0
    """How it grows with a range r, as 1 + slope r^2 [1/m²]."""
    missed: float = MISSED
    """Likelihood of no return where an edge is due; 1 would let it tell nothing."""

    @classmethod
    def of(cls, field: Field, range_max: float, sd: float, slope: float = 0.0) -> RayEvidence:
        """For the edges of a field."""
        return cls(field.edge_index, field.visibility, range_max, sd, slope)

    def log_peaks(self, ranges: Array) -> Array:
        """Log-likelihoods (n,) of ranges (n,) that are exactly those of the edges which are due."""
        wide = self.sd * (1 + self.slope * ranges**2) * math.sqrt(2 * math.pi)
        peaks: Array = np.log(SEEN / wide + STRAY / self.range_max)
        return peaks

    def log_likelihood_anywhere(self, rays: Array) -> float:
        """Log-likelihood of rays (n, 7) at a place that fits but badly, on average of all.

        Where no ray returns, any empty part of the floor fits.
        """
        ranges = rays[:, 3]
        returned = ranges[np.isfinite(ranges)]
        if not len(returned):
            return 0.0
        worse = WORSE_ANYWHERE * len(returned) + MISSED_ANYWHERE * (len(ranges) - len(returned))
        return (float(self.log_peaks(returned).sum()) - worse) / len(ranges)

    def log_likelihood(self, pose: Pose2, rays: Array) -> float:
        """Log-likelihood of rays (n, 7) at a pose, on average of all of them."""
        return ray_log_likelihood(
            pose.to_array(),
            rays,
            self.index,
            self.sight,
            self.range_max,
            self.sd,
            self.slope,
            self.missed,
        )

    def log_likelihoods(self, poses: Array, rays: Array) -> Array:
        """The same (m,) of the same rays at each of some poses (m, 3)."""
        return _at_each(
            poses,
            rays,
            self.index,
            self.sight,
            self.range_max,
            self.sd,
            self.slope,
            self.missed,
        )


@njit(cache=True, nogil=True)
def ray_log_likelihood(
    pose: Array,
    rays: Array,
    index: EdgeIndex,
    sight: Visibility,
    range_max: float,
    sd: float,
    slope: float,
    missed: float,
) -> float:
    """Log-likelihood of rays (n, 7) at a pose (3,), on average of all of them; 0 without rays."""
    dues = np.empty((len(rays), 5))
    c, s = math.cos(pose[2]), math.sin(pose[2])
    for i in range(len(rays)):
        if math.isnan(rays[i, 4]):
            dues[i, 4] = 0.0
            continue
        heading = pose[2] + rays[i, 2]
        dx, dy = math.cos(heading), math.sin(heading)
        near, far = rays[i, 4], min(rays[i, 5], range_max)
        x = pose[0] + c * rays[i, 0] - s * rays[i, 1] + near * dx
        y = pose[1] + s * rays[i, 0] + c * rays[i, 1] + near * dy
        _look(x, y, dx, dy, far - near, index, sight, dues[i])
    total, counted = 0.0, 0
    for i in range(len(rays)):
        if math.isnan(rays[i, 4]):
            continue
        counted += 1
        due, behind = dues[i, 0], dues[i, 1]
        result = rays[i, 3] - rays[i, 4]
        if math.isfinite(result):
            wide = sd * (1 + slope * rays[i, 3] * rays[i, 3])
            density = SURPRISE / range_max
            if math.isfinite(due):
                density = _density(result - due, wide, range_max, rays[i, 6])
            if math.isfinite(behind):
                density = max(density, _density(result - behind, wide, range_max, rays[i, 6]))
            total += math.log(density)
        elif dues[i, 4] > 1 and _is_supported(dues, i, sight.support):
            total += math.log(missed + SEEN * (1 - rays[i, 6]) * (1 - missed))
    return total / max(counted, 1)


@njit(cache=True, nogil=True)
def _at_each(
    poses: Array,
    rays: Array,
    index: EdgeIndex,
    sight: Visibility,
    range_max: float,
    sd: float,
    slope: float,
    missed: float,
) -> Array:
    logs = np.empty(len(poses))
    for i in range(len(poses)):
        logs[i] = ray_log_likelihood(poses[i], rays, index, sight, range_max, sd, slope, missed)
    return logs


@njit(cache=True, nogil=True, inline="always")
def _look(
    x: float,
    y: float,
    dx: float,
    dy: float,
    reach: float,
    index: EdgeIndex,
    sight: Visibility,
    row: Array,
) -> None:
    """What a ray meets that begins at (x, y): a row (5,).

    Distance of the edge that is due, and of the one behind it where that one may be missed, else
    infinite [m]; x, y where the first is met [m]; 0 if nothing is met or not as a whole, 1 if it
    may be missed, 2 if it should be seen.
    """
    due, edge = cast_toward(x, y, dx, dy, index, reach)
    row[0], row[1], row[4] = math.inf, math.inf, 0.0
    if edge < 0:
        return
    row[0], row[2], row[3] = due, x + due * dx, y + due * dy
    at_end, across = _met(row[2], row[3], dx, dy, edge, index.edges, sight)
    if NEAR < due < reach - FAR / across:
        row[4] = 1.0 if at_end else 2.0
    if at_end:
        past = due + 0.005
        behind, edge = cast_toward(x + past * dx, y + past * dy, dx, dy, index, reach - past)
        if edge >= 0:
            row[1] = past + behind


@njit(cache=True, nogil=True)
def _is_supported(dues: Array, ray: int, support: float) -> bool:
    """Whether neighbouring rays meet enough of an edge, and as a whole, for it to be tape."""
    first, last = ray, ray
    while first > 0 and _is_next(dues[first - 1], dues[first], support):
        first -= 1
    while last + 1 < len(dues) and _is_next(dues[last + 1], dues[last], support):
        last += 1
    return math.hypot(dues[last, 2] - dues[first, 2], dues[last, 3] - dues[first, 3]) >= support


@njit(cache=True, nogil=True, inline="always")
def _is_next(row: Array, beside: Array, support: float) -> bool:
    """Whether a ray meets the same edge as one beside it."""
    apart = math.hypot(row[2] - beside[2], row[3] - beside[3])
    return row[4] > 0 and apart <= GAP * support


@njit(cache=True, nogil=True, inline="always")
def _density(offset: float, sd: float, range_max: float, clear: float) -> float:
    """Of a return that is off the edge which is due [1/m]."""
    peak = SEEN * clear / (sd * math.sqrt(2 * math.pi))
    return peak * math.exp(-0.5 * (offset / sd) ** 2) + STRAY / range_max


@njit(cache=True, nogil=True, inline="always")
def _met(
    x: float, y: float, dx: float, dy: float, edge: int, edges: Array, sight: Visibility
) -> tuple[bool, float]:
    """Whether a point of an edge may be missed as it is near an end, or blind there.

    Also the sine of the edge's angle to the ray.
    """
    ex, ey = edges[edge, 2] - edges[edge, 0], edges[edge, 3] - edges[edge, 1]
    length = math.hypot(ex, ey)
    along = ((x - edges[edge, 0]) * ex + (y - edges[edge, 1]) * ey) / length
    sine, cosine = abs(dx * ey - dy * ex) / length, (dx * ex + dy * ey) / length
    # A ray that grazes goes on along the tape, from its start or to it.
    ahead = ACROSS * abs(cosine) / max(sine, 1e-9)
    to_start, to_end = (END, max(END, ahead)) if cosine > 0 else (max(END, ahead), END)
    ends, first, last = sight.ends, sight.starts[edge], sight.starts[edge + 1]
    part = first + min(max(int(along / length * (last - first)), 0), last - first - 1)
    at_end = (ends[edge, 0] and along < to_start) or (ends[edge, 1] and length - along < to_end)
    return at_end or not sight.seen[part], sine
