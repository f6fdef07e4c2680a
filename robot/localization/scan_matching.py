"""Scan matching: lays rays on the edges of the map to find the pose near a supposed one."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from robot import ray_columns as column
from robot.compiling import compiled
from robot.fields.edge_index import EdgeIndex
from robot.fields.ray_casting import cast_toward, tangent_at
from robot.geometry import Array, Pose2

STEPS = 6
"""Most Gauss-Newton steps; from a few centimetres away, four are enough."""
TAIL = 9.0
"""Squared residual, in standard deviations, at which a ray counts half (Cauchy's weights); beyond,
it is an outlier."""
SLOPE = 25.0
"""Growth of a range's spread with its square [1/m²]: one over the square of the camera's height."""
GATE_SDS = 10.0
"""Largest residual of a range that measures the edge, in standard deviations."""
LENGTHS = 3
"""Number of step lengths that are tried, each half of the one before."""
WORTH = 1e-6
"""Least expected fall of the cost for which a step is taken. A smaller step is shorter than a
thousandth of the pose's standard deviation by the rays."""


@dataclass(frozen=True, slots=True, eq=False)
class Match:
    """A pose at which rays fit the map best."""

    pose: Pose2
    information: Array = field(repr=False)
    """(3, 3) inverse of the covariance [m, m, rad]; singular in directions without measurement."""
    used: int
    """Number of rays that fit."""


class ScanMatcher(NamedTuple):
    """Lays rays on the edges of a field; compiled functions use it directly."""

    edge_index: EdgeIndex
    range_max: float
    """How far rays reach [m]."""
    sd: float
    """Standard deviation of a range [m]."""
    gate: float
    """Largest residual of a range that measures the edge [m]."""
    slope: float = 0.0
    """Growth of the spread with a range r, as 1 + slope * r^2 [1/m²]: the farther the floor, the
    more of it a pixel sees. It is 0 for a laser."""

    def match(self, pose: Pose2, rays: Array, information: Array | None = None) -> Match:
        """Move a pose to where rays (n, 9) fit.

        Args:
            pose: the supposed pose of the robot in the map.
            rays: the rays as ``rays_of`` returns them.
            information: (3, 3) inverse covariance of the supposed pose; None is zero. Then the pose
                stays in directions that the rays do not measure.
        """
        known = np.zeros((3, 3)) if information is None else information
        result, total, used = fit_rays(pose.to_array(), known, rays, self)
        return Match(Pose2(*result.tolist()), total, used)


@compiled()
def fit_rays(
    start: Array, known: Array, rays: Array, matcher: ScanMatcher
) -> tuple[Array, Array, int]:
    """Lay rays on the edges of the map by Gauss-Newton steps.

    Each ray is cast from the current pose. The expected range, the measured range, and how their
    difference changes with the pose give one equation of a least-squares problem. Casting also says
    which edge the ray meets: one that faces the ray and is not hidden.

    A ray may change to another edge. So a step is taken only if it lowers the cost; otherwise it is
    halved, at most twice, and then dropped.

    Args:
        start: the supposed pose (3,).
        known: its information (3, 3), the inverse of its covariance; zeros if nothing is known.
        rays: (n, 9) as ``rays_of`` returns them.
        matcher: the edges, and how exact ranges are.

    Returns:
        The pose (3,) that fits, its information (3, 3), and how many rays fit.
    """
    pose = start.copy()
    total, pull = np.empty((3, 3)), np.empty(3)
    next_total, next_pull = np.empty((3, 3)), np.empty(3)
    used, cost, odd = _normal_equations(pose, start, known, rays, matcher, np.inf, total, pull)
    for _ in range(STEPS):
        # The added term keeps the pose in directions of which nothing is known.
        step = np.linalg.solve(total + 1e-3 * np.eye(3), pull)
        if step @ pull < WORTH:
            break
        for _ in range(LENGTHS):
            ahead = pose + step
            ahead[2] = (ahead[2] + math.pi) % (2 * math.pi) - math.pi
            next_used, next_cost, next_odd = _normal_equations(
                ahead, start, known, rays, matcher, np.inf, next_total, next_pull
            )
            if next_cost < cost:
                break
            step *= 0.5
        if next_cost >= cost:
            break
        pose, used, cost, odd = ahead, next_used, next_cost, next_odd
        for i in range(3):
            pull[i] = next_pull[i]
            for j in range(3):
                total[i, j] = next_total[i, j]
    if odd:
        # Beyond TAIL, Cauchy's cost is curved the other way: such a ray gives no reliable
        # information.
        _normal_equations(pose, start, known, rays, matcher, TAIL, total, pull)
    return pose, total, used


@compiled()
def _normal_equations(
    pose: Array,
    start: Array,
    known: Array,
    rays: Array,
    matcher: ScanMatcher,
    farthest: float,
    total: Array,
    pull: Array,
) -> tuple[int, float, int]:
    """Write J^T W J and J^T W r of prior and rays into ``total`` and ``pull``.

    Rays whose squared residual, in spreads, is above ``farthest`` are left out of both.

    Returns:
        How many rays fit; the cost; and for how many rays the squared residual is above ``TAIL``.
        The cost is the prior's and Cauchy's of all residuals; a ray that returned something and
        fits no edge costs as much as one at the gate.
    """
    index, range_max, sd, gate, slope = matcher
    offset = start - pose
    offset[2] = (offset[2] + math.pi) % (2 * math.pi) - math.pi
    known_pull = known @ offset
    for i in range(3):
        pull[i] = known_pull[i]
        for j in range(3):
            total[i, j] = known[i, j]
    cost = float(offset @ pull)
    most = _cauchy((gate / sd) ** 2)
    c, s = math.cos(pose[2]), math.sin(pose[2])
    used = odd = 0
    for i in range(len(rays)):
        near = rays[i, column.NEAR]
        if math.isnan(near) or not math.isfinite(rays[i, column.RANGE]):
            continue
        # The start of the ray, which moves when the robot turns.
        ahead = c * rays[i, column.X] - s * rays[i, column.Y]
        aside = s * rays[i, column.X] + c * rays[i, column.Y]
        heading = pose[2] + rays[i, column.DIRECTION]
        dx, dy = math.cos(heading), math.sin(heading)
        x, y = pose[0] + ahead + near * dx, pose[1] + aside + near * dy
        expected, edge = cast_toward(x, y, dx, dy, index, range_max - near)
        expected += near
        if edge < 0 or abs(rays[i, column.RANGE] - expected) > gate:
            cost += most
            continue
        met = expected - near
        ex, ey = tangent_at(x + met * dx, y + met * dy, edge, index)
        across = dx * ey - dy * ex
        # How the range to the edge's line changes with x, y and theta.
        by_x, by_y = -ey / across, ex / across
        by_theta = expected * (dx * ex + dy * ey) / across - aside * by_x + ahead * by_y
        # The spread is that of the end's distance from the edge, so a grazing ray says less.
        spread = sd * (1 + slope * expected * expected)
        weight = across * across / ((ex * ex + ey * ey) * spread * spread)
        square = weight * (rays[i, column.RANGE] - expected) ** 2
        cost += _cauchy(square)
        used += 1
        odd += square > TAIL
        if square > farthest:
            continue
        weight /= 1 + square / TAIL
        _add_outer(total, weight, by_x, by_y, by_theta)
        residual = weight * (rays[i, column.RANGE] - expected)
        pull[0] += residual * by_x
        pull[1] += residual * by_y
        pull[2] += residual * by_theta
    return used, cost, odd


@compiled(inline="always")
def _cauchy(square: float) -> float:
    """Return Cauchy's cost of a squared residual: it limits the influence of outliers."""
    return TAIL * math.log1p(square / TAIL)


@compiled(inline="always")
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
