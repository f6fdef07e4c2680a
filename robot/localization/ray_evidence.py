"""Likelihood of rays at a pose, by hits and by misses.

Particles are weighed by where rays end. To distinguish two places that look much alike, a mark that
should be seen and is not has to count as well. So each ray is cast, as in the beam model
(Probabilistic Robotics, Table 6.1). Edges that the line scanner may miss are left out: edges nearer
or farther than the picture shows, tape that a ray meets close to its end, and edges at which the
scanner's own rules find no tape (``robot.fields.visibility``). Where a ray runs over floor that
nobody has looked at, tape is neither due nor forbidden: it says as much as at a place that fits
badly, and nothing if it does not return.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from robot import ray_columns as column
from robot.compiling import compiled
from robot.fields.edge_index import EdgeIndex
from robot.fields.field import Field
from robot.fields.ray_casting import cast_toward
from robot.fields.unseen_floor import UnseenFloor, is_seen, seen_until
from robot.fields.visibility import Visibility
from robot.geometry import Array, Pose2
from robot.scanning.tape_edges import GAP

SEEN, STRAY, MISSED = 0.85, 0.12, 0.03
"""Shares of the rays with an expected edge that return it, something else, and nothing, in a clear
picture. The scanner does better (1 % missed, hardly anything else); these values leave a margin for
less clean floors. In noise and in the dark, the scan itself says how much less returns."""
UNEXPECTED_SHARE = 0.05
"""Share of the rays that return something where no edge is expected."""
THING = 0.3
"""Likelihood that something lies on a ray that is not drawn: a shoe, a shadow. It hides edges, so
it must cost something: otherwise any tape that the scanner does not recognize would be a shoe."""
DRAWN = 0.04
"""What lies on a ray is drawn if it begins and ends within this distance of drawn edges [m]."""
NEAR, FAR = 0.015, 0.06
"""An edge closer than this to the start or the end of a ray's sight [m] may be missed, because the
scanner must see the whole width of the tape."""
BACKGROUND_LOSS, BACKGROUND_MISS_LOSS = 1.8, 0.2
"""Loss of a ray's log-likelihood at a place that fits badly. A ray that returned is compared with
an exact fit (the loss is that of 1.9 standard deviations). A ray that did not return is compared
with a place where no edge is expected. A ray that returned from floor that nobody has looked at
loses as much, so it says nothing: with a loss of 0.3 instead of 1.8, robots are certain in 77
instead of 15 % of pictures where a sixth of *stub* was never drawn, but also certain of a wrong
place in 4 % where most of *town* was not. Half: nothing changes beyond chance; twice: two of ten
places are not found (``--few``)."""
END = 0.06
"""Closer than this to its end [m], tape may be missed and the edge behind it seen instead."""
ACROSS = 0.06
"""If a ray leaves tape by its end before it crosses this width [m], it may find it too narrow."""

ROUNDED = 1e-6
"""More than sums of log-likelihoods differ by rounding."""

AT_BORDER = 0.06
"""Tape that ends the seen floor, and was not drawn, may be this much nearer than its border [m].
Half: nothing changes; twice: certain in 87 instead of 100 % in a map of *tee* that has gaps."""

_MET_X, _MET_Y, _SEEN, _THING, _HIT = range(5)
"""Columns of what rays meet (n, 5): where the ray meets the expected edge [m]; 0 if the ray meets
no edge, or one that is hidden or at the border of its sight, 1 if the edge may be missed at its
end, 2 if it should be seen; 1 if something lies there that is not drawn, else 0; and the
log-likelihood of what it returned, 0 without a return."""


class RayEvidence(NamedTuple):
    """Weighs poses by rays that return and rays that do not; compiled functions use it, too."""

    edge_index: EdgeIndex
    sight: Visibility
    """Which edges the scanner sees."""
    range_max: float
    """How far rays reach [m]."""
    sd: float
    """Standard deviation of a near range [m]."""
    slope: float = 0.0
    """Growth of that deviation with a range r, as 1 + slope r^2 [1/m²]."""
    unseen: UnseenFloor = UnseenFloor.beyond(())
    """Floor on which nobody knows what is due."""
    missed: float = MISSED
    """Likelihood of no return where an edge is expected; with 1, misses would not count."""

    @classmethod
    def of(cls, field: Field, range_max: float, sd: float, slope: float = 0.0) -> RayEvidence:
        """Return the evidence for the edges of a field."""
        return cls(field.edge_index, field.visibility, range_max, sd, slope, field.unseen)

    def log_peaks(self, ranges: Array) -> Array:
        """Return the log-likelihoods (n,) of ranges (n,) that fit the expected edges exactly."""
        wide = self.sd * (1 + self.slope * ranges**2) * math.sqrt(2 * math.pi)
        peaks: Array = np.log(SEEN / wide + STRAY / self.range_max)
        return peaks

    def background_log_likelihood(self, rays: Array) -> float:
        """Return the mean log-likelihood of rays (n, 9) at a place that fits badly.

        If no ray returns, any empty part of the floor fits. Nothing on the floor is drawn there.
        """
        ranges = rays[:, column.RANGE]
        returned = ranges[np.isfinite(ranges)]
        hidden = rays[:, column.HIDDEN_FROM] < rays[:, column.HIDDEN_TO]
        things = math.log(THING) * int(hidden.sum())
        if not len(returned):
            return things / len(ranges)
        worse = BACKGROUND_LOSS * len(returned) + BACKGROUND_MISS_LOSS * (
            len(ranges) - len(returned)
        )
        return (float(self.log_peaks(returned).sum()) - worse + things) / len(ranges)

    def log_likelihood(self, pose: Pose2, rays: Array) -> float:
        """Return the mean log-likelihood of rays (n, 9) at a pose."""
        return float(self.log_likelihoods(pose.to_array()[None], rays)[0])

    def log_likelihoods(self, poses: Array, rays: Array, within: float = math.inf) -> Array:
        """Return the mean log-likelihood (m,) of rays (n, 9) at each of the poses (m, 3).

        It may be -inf at a pose where it is more than ``within`` below that at an earlier pose.
        """
        return ray_log_likelihoods(poses, rays, self, within)


@compiled()
def ray_log_likelihoods(poses: Array, rays: Array, evidence: RayEvidence, within: float) -> Array:
    """Return the mean log-likelihood (m,) of rays (n, 9) at each of the poses (m, 3).

    Rays that see nowhere do not count. It is 0 if no ray is left. It may be -inf at a pose where it
    is more than ``within`` below that at an earlier pose: a third of the rays tell that.
    """
    peaks, counted = np.zeros(len(rays)), 0
    for i in range(len(rays)):
        if not math.isnan(rays[i, column.NEAR]):
            counted += 1
            due = rays[i, column.RANGE] - rays[i, column.NEAR]
            peaks[i] = _log_hit(rays, i, due, due, 1.0, evidence) if math.isfinite(due) else 0.0
    logs, best = np.empty(len(poses)), -np.inf
    for i in range(len(poses)):
        least = (best - within) * counted - ROUNDED
        logs[i] = _log_likelihood(poses[i], rays, evidence, peaks, least) / max(counted, 1)
        best = max(best, logs[i])
    return logs


@compiled()
def ends_of_seen(pose: Array, rays: Array, evidence: RayEvidence) -> Array:
    """Return where rays (n, 9) that return from unseen floor at a pose (3,) come to it (n,) [m].

    It is infinite for the others: also for those that return from an edge that is drawn behind it.
    """
    ends, floor = np.full(len(rays), np.inf), evidence.unseen
    if floor.seen.size == 0:
        return ends
    c, s = math.cos(pose[2]), math.sin(pose[2])
    for i in range(len(rays)):
        near, past = rays[i, column.NEAR], rays[i, column.RANGE] - rays[i, column.NEAR]
        if not math.isfinite(past):
            continue
        heading = pose[2] + rays[i, column.DIRECTION]
        dx, dy = math.cos(heading), math.sin(heading)
        x = pose[0] + c * rays[i, column.X] - s * rays[i, column.Y] + near * dx
        y = pose[1] + s * rays[i, column.X] + c * rays[i, column.Y] + near * dy
        reach = min(rays[i, column.FAR], evidence.range_max) - near
        known = seen_until(x, y, dx, dy, reach, floor)
        if past > known - AT_BORDER or _is_at_border(x + past * dx, y + past * dy, floor):
            due = cast_toward(x, y, dx, dy, evidence.edge_index, reach)[0]
            # The end of tape that nobody saw is none: the drawing ends there, and the tape goes on.
            before = due - NEAR
            seen = math.isfinite(due) and is_seen(x + before * dx, y + before * dy, floor)
            if not seen or (due > min(known, past) and abs(past - due) > NEAR):
                ends[i] = near + min(known, past) - AT_BORDER
    return ends


@compiled(inline="always")
def _is_at_border(x: float, y: float, floor: UnseenFloor) -> bool:
    """Return whether floor that nobody looked at is near a point of the map [m]."""
    beside = is_seen(x - AT_BORDER, y, floor) and is_seen(x + AT_BORDER, y, floor)
    return not (beside and is_seen(x, y - AT_BORDER, floor) and is_seen(x, y + AT_BORDER, floor))


@compiled()
def _log_likelihood(
    pose: Array, rays: Array, evidence: RayEvidence, peaks: Array, least: float
) -> float:
    """Return the log-likelihood of rays (n, 9); -inf once it cannot reach ``least`` any more.

    ``peaks`` (n,) are the largest that each ray can have.
    """
    index, sight, range_max = evidence.edge_index, evidence.sight, evidence.range_max
    met, reachable = np.zeros((len(rays), 5)), peaks.sum()
    ends = ends_of_seen(pose, rays, evidence)
    c, s = math.cos(pose[2]), math.sin(pose[2])
    for i in range(len(rays)):
        near = rays[i, column.NEAR]
        if math.isnan(near):
            continue
        heading = pose[2] + rays[i, column.DIRECTION]
        dx, dy = math.cos(heading), math.sin(heading)
        x = pose[0] + c * rays[i, column.X] - s * rays[i, column.Y] + near * dx
        y = pose[1] + s * rays[i, column.X] + c * rays[i, column.Y] + near * dy
        reach = min(rays[i, column.FAR], range_max) - near
        thing = rays[i, column.HIDDEN_FROM] - near, rays[i, column.HIDDEN_TO] - near
        # What returns tells what lies between: nothing.
        returned = math.isfinite(rays[i, column.RANGE])
        known = np.inf if returned else seen_until(x, y, dx, dy, reach, evidence.unseen)
        due, behind = _look((x, y), (dx, dy), reach, known, thing, index, sight, met, i)
        if returned:
            if math.isfinite(ends[i]):
                met[i, _HIT] = peaks[i] - BACKGROUND_LOSS
            else:
                met[i, _HIT] = _log_hit(rays, i, due, behind, rays[i, column.CLEAR], evidence)
            reachable += met[i, _HIT] - peaks[i]
        if reachable < least:
            return -np.inf
    total = 0.0
    for i in range(len(rays)):
        if met[i, _THING] > 0:
            total += math.log(THING)
        if math.isfinite(rays[i, column.RANGE]):
            total += met[i, _HIT]
        elif met[i, _SEEN] > 1 and _is_supported(met, i, sight.support):
            missed = evidence.missed
            total += math.log(missed + SEEN * (1 - rays[i, column.CLEAR]) * (1 - missed))
    return total


@compiled(inline="always")
def _look(
    start: tuple[float, float],
    way: tuple[float, float],
    reach: float,
    known: float,
    thing: tuple[float, float],
    index: EdgeIndex,
    sight: Visibility,
    met: Array,
    i: int,
) -> tuple[float, float]:
    """Write what a ray meets into row ``i`` of ``met`` (n, 5), without its hit.

    It is followed as far as ``reach`` [m], but not beyond the ``known`` floor [m]; from where to
    where on it a ``thing`` was seen is in metres as well. Returns the distance of the expected edge
    [m], infinite without one; and that of the edge behind it, if the expected edge may be missed,
    else infinite.
    """
    x, y = start
    dx, dy = way
    covered = thing[0] < thing[1] and not _is_drawn(start, way, thing, index, sight.inward)
    if covered:
        met[i, _THING] = 1.0
    due, edge = cast_toward(x, y, dx, dy, index, min(reach, known))
    if edge < 0:
        return due, math.inf
    met[i, _MET_X], met[i, _MET_Y] = x + due * dx, y + due * dy
    at_end, across = _met(met[i, _MET_X], met[i, _MET_Y], dx, dy, edge, index, sight)
    covered = covered and thing[0] - NEAR < due < thing[1] + NEAR
    if NEAR < due < reach - FAR / across and not covered:
        met[i, _SEEN] = 1.0 if at_end else 2.0
    past = (max(due, thing[1]) if covered else due) + 0.005
    if past >= reach or not (at_end or covered):
        return due, math.inf
    return due, past + cast_toward(x + past * dx, y + past * dy, dx, dy, index, reach - past)[0]


@compiled()
def _is_drawn(
    start: tuple[float, float],
    way: tuple[float, float],
    thing: tuple[float, float],
    index: EdgeIndex,
    inward: EdgeIndex,
) -> bool:
    """Whether something dark is drawn that begins and ends where it does on a ray [m].

    A thing that reaches back to the ray's start, or on to infinity, has only one end to compare.
    """
    x, y = start
    dx, dy = way
    begin, end = thing
    if begin <= 0 and math.isinf(end):
        return False
    if begin > 0:
        before = max(begin - DRAWN, 0.0)
        if cast_toward(x + before * dx, y + before * dy, dx, dy, index, 2 * DRAWN)[1] < 0:
            return False
    if math.isinf(end):
        return True
    before = end - DRAWN
    return cast_toward(x + before * dx, y + before * dy, dx, dy, inward, 2 * DRAWN)[1] >= 0


@compiled()
def _is_supported(met: Array, ray: int, support: float) -> bool:
    """Whether a ray and its neighbours meet enough of an edge for the scanner to find tape.

    Only neighbours that see the whole width of the tape count.
    """
    first, last = ray, ray
    while first > 0 and _is_next(met[first - 1], met[first], support):
        first -= 1
    while last + 1 < len(met) and _is_next(met[last + 1], met[last], support):
        last += 1
    dx, dy = met[last, _MET_X] - met[first, _MET_X], met[last, _MET_Y] - met[first, _MET_Y]
    return math.hypot(dx, dy) >= support


@compiled(inline="always")
def _is_next(row: Array, beside: Array, support: float) -> bool:
    """Whether a ray meets the same edge as the ray beside it."""
    apart = math.hypot(row[_MET_X] - beside[_MET_X], row[_MET_Y] - beside[_MET_Y])
    return row[_SEEN] > 0 and apart <= GAP * support


@compiled(inline="always")
def _log_hit(
    rays: Array, i: int, due: float, behind: float, clear: float, evidence: RayEvidence
) -> float:
    """Return the log-likelihood of a ray's range where edges are at these distances, or +inf."""
    if math.isinf(due):
        return math.log(UNEXPECTED_SHARE / evidence.range_max)
    length = rays[i, column.RANGE]
    sd = evidence.sd * (1 + evidence.slope * length * length)
    peak = SEEN * clear / (sd * math.sqrt(2 * math.pi))
    past = length - rays[i, column.NEAR]
    offset = min(abs(past - due), abs(past - behind))
    return math.log(peak * math.exp(-0.5 * (offset / sd) ** 2) + STRAY / evidence.range_max)


@compiled(forceinline=True)
def _met(
    x: float, y: float, dx: float, dy: float, edge: int, index: EdgeIndex, sight: Visibility
) -> tuple[bool, float]:
    """Whether an edge may be missed at a point: near the tape's end, or where the scanner is blind.

    Also returns the sine of the angle between the edge and the ray.
    """
    edges, ends, starts = index.edges, sight.ends, sight.starts
    ex, ey = edges[edge, 2] - edges[edge, 0], edges[edge, 3] - edges[edge, 1]
    length = math.hypot(ex, ey)
    along = ((x - edges[edge, 0]) * ex + (y - edges[edge, 1]) * ey) / length
    sine, cosine = abs(dx * ey - dy * ex) / length, (dx * ex + dy * ey) / length
    # A grazing ray runs along the tape, toward the edge's end or toward its start.
    ahead = ACROSS * abs(cosine) / max(sine, 1e-9)
    to_start, to_end = (END, max(END, ahead)) if cosine > 0 else (max(END, ahead), END)
    first, last = starts[edge], starts[edge + 1]
    part = first + min(max(int(along / length * (last - first)), 0), last - first - 1)
    at_end = (ends[edge, 0] and along < to_start) or (ends[edge, 1] and length - along < to_end)
    return at_end or not sight.seen[part], sine
