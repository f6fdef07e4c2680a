"""Where exactly is the robot, if it is about here? Rays laid on the edges of the map."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
from numba import njit

from robot.fields.edge_index import EdgeIndex
from robot.fields.ray_casting import cast_toward, tangent_at
from robot.geometry import Array, Pose2

STEPS = 6
"""Gauss-Newton steps, at most; from a few centimetres off four are enough."""
TAIL = 9.0
"""Square of the standard deviations from which on residuals pull less (Cauchy's weights)."""
LENGTHS = 3
"""Lengths of a step that are tried, each half of the one before."""
WORTH = 1e-6
"""A step by which the cost should fall by less is not taken: it is a thousandth of what the
rays know, as a standard deviation."""


@dataclass(frozen=True, slots=True)
class Match:
    """A pose at which rays fit the map best."""

    pose: Pose2
    information: Array = field(repr=False)
    """(3, 3) inverse of the covariance [m, m, rad]; singular along what is not measured."""
    used: int
    """Rays that fit."""


@dataclass(frozen=True, slots=True)
class ScanMatcher:
    """Lays rays on the edges of a field."""

    index: EdgeIndex = field(repr=False)
    range_max: float
    """How far rays reach [m]."""
    sd: float
    """Standard deviation of a range [m]."""
    gate: float
    """Ranges that are farther off than this do not measure the edge [m]."""
    slope: float = 0.0
    """How the spread grows with a range r, as 1 + slope * r^2 [1/m²]: the farther the floor, the
    more of it a pixel sees. 0 is a laser's."""

    def match(self, pose: Pose2, rays: Array, information: Array | None = None) -> Match:
        """Move a pose to where rays (n, 7) fit.

        Args:
            pose: the robot in the map, supposed.
            rays: as ``rays_of`` makes them.
            information: (3, 3) inverse covariance of the supposed pose; by default none, and the
                pose stays along what the rays say nothing of.
        """
        known = np.zeros((3, 3)) if information is None else information
        result, total, used = fit_rays(
            pose.to_array(), known, rays, self.index, self.range_max, self.sd, self.gate, self.slope
        )
        return Match(Pose2(*result.tolist()), total, used)


@njit(cache=True, nogil=True)
def fit_rays(
    start: Array,
    known: Array,
    rays: Array,
    index: EdgeIndex,
    range_max: float,
    sd: float,
    gate: float,
    slope: float,
) -> tuple[Array, Array, int]:
    """Lay rays on the edges of the map by Gauss-Newton steps.

    Each ray is cast from the pose that is supposed; what it should have measured, what it did, and
    how the difference changes with the pose give one equation of a least-squares problem. Casting
    also says which edge it met: one that faces it, and none that is hidden.

    As a ray may change over to another edge, a step counts only if the cost falls by it; it is
    shortened twice at most, and then not taken.

    Args:
        start: the supposed pose (3,).
        known: its information (3, 3), the inverse of its covariance; zeros if nothing is known.
        rays: (n, 7) as ``rays_of`` makes them.
        index: the field's edges.
        range_max: how far rays reach [m].
        sd: standard deviation of a range [m].
        gate: ranges that are farther off than this do not measure the edge [m].
        slope: how the spread grows with the square of a range [1/m²].

    Returns:
        The pose (3,) that fits, its information (3, 3), and how many rays fit.
    """
    pose = start.copy()
    total, pull = np.empty((3, 3)), np.empty(3)
    next_total, next_pull = np.empty((3, 3)), np.empty(3)
    used, cost, odd = _normal_equations(
        pose, start, known, rays, index, range_max, sd, gate, slope, np.inf, total, pull
    )
    for _ in range(STEPS):
        # Along what nothing is known of, the pose stays.
        step = np.linalg.solve(total + 1e-3 * np.eye(3), pull)
        if step @ pull < WORTH:
            break
        for _ in range(LENGTHS):
            ahead = pose + step
            ahead[2] = (ahead[2] + math.pi) % (2 * math.pi) - math.pi
            next_used, next_cost, next_odd = _normal_equations(
                ahead,
                start,
                known,
                rays,
                index,
                range_max,
                sd,
                gate,
                slope,
                np.inf,
                next_total,
                next_pull,
            )
            if next_cost < cost:
                break
            step *= 0.5
        if next_cost >= cost:
            break
        pose, used, cost, odd = ahead, next_used, next_cost, next_odd
        total[:], pull[:] = next_total, next_pull
    if odd:
        # A ray that is off by more pulls the other way than its edge would: it tells nothing for
        # sure.
        _normal_equations(
            pose, start, known, rays, index, range_max, sd, gate, slope, TAIL, total, pull
        )
    return pose, total, used


@njit(cache=True, nogil=True)
def _normal_equations(
    pose: Array,
    start: Array,
    known: Array,
    rays: Array,
    index: EdgeIndex,
    range_max: float,
    sd: float,
    gate: float,
    slope: float,
    farthest: float,
    total: Array,
    pull: Array,
) -> tuple[int, float, int]:
    """Put J^T W J and J^T W r of prior and rays into ``total`` and ``pull``.

    Rays farther off than ``farthest``, as a square of their spreads, are left out of both. Returns
    how many rays fit; the cost: Cauchy's of all residuals, where a ray that returned something and
    fits no edge costs the gate's; and how many rays are farther off than ``TAIL``.
    """
    offset = start - pose
    offset[2] = (offset[2] + math.pi) % (2 * math.pi) - math.pi
    total[:] = known
    pull[:] = known @ offset
    cost = float(offset @ pull)
    most = _cauchy((gate / sd) ** 2)
    c, s = math.cos(pose[2]), math.sin(pose[2])
    used = odd = 0
    for i in range(len(rays)):
        near = rays[i, 4]
        if math.isnan(near) or not math.isfinite(rays[i, 3]):
            continue
        # Where the ray starts, which moves when the robot turns.
        ahead = c * rays[i, 0] - s * rays[i, 1]
        aside = s * rays[i, 0] + c * rays[i, 1]
        heading = pose[2] + rays[i, 2]
        dx, dy = math.cos(heading), math.sin(heading)
        x, y = pose[0] + ahead + near * dx, pose[1] + aside + near * dy
        expected, edge = cast_toward(x, y, dx, dy, index, range_max - near)
        expected += near
        if edge < 0 or abs(rays[i, 3] - expected) > gate:
            cost += most
            continue
        met = expected - near
        ex, ey = tangent_at(x + met * dx, y + met * dy, edge, index)
        across = dx * ey - dy * ex
        # How the range to the edge's line changes with x, y and theta.
        by_x, by_y = -ey / across, ex / across
        by_theta = expected * (dx * ex + dy * ey) / across - aside * by_x + ahead * by_y
        # It is the end's distance from the edge that errs evenly: a ray that grazes says less.
        spread = sd * (1 + slope * expected * expected)
        weight = across * across / ((ex * ex + ey * ey) * spread * spread)
        square = weight * (rays[i, 3] - expected) ** 2
        cost += _cauchy(square)
        used += 1
        odd += square > TAIL
        if square > farthest:
            continue
        weight /= 1 + square / TAIL
        _add_outer(total, weight, by_x, by_y, by_theta)
        residual = weight * (rays[i, 3] - expected)
        pull[0] += residual * by_x
        pull[1] += residual * by_y
        pull[2] += residual * by_theta
    return used, cost, odd


@njit(cache=True, nogil=True, inline="always")
def _cauchy(square: float) -> float:
    """What a residual's square costs: some rays are far off, and shall not pull."""
    return TAIL * math.log1p(square / TAIL)


@njit(cache=True, nogil=True, inline="always")
def _add_outer(total: Array, weight: float, a: float, b: float, c: float) -> None:
    total[0, 0] += weight * a * a
    total[1, 1] += weight * b * b
    total[2, 2] += weight * c * c
    total[0, 1] += weight * a * b
    total[1, 0] += weight * a * b
    total[0, 2] += weight * a * c
    total[2, 0] += weight * a * c
    total[1, 2] += weight * b * c
    total[2, 1] += weight * b * c
