"""Log-likelihoods of the beam model: rays cast from each pose, several at a time.

Textbook twin: ``beam_range_finder_model`` of ``robot.localization.textbook``.
"""

from __future__ import annotations

import math

import numpy as np

from robot.compiling import compiled
from robot.fields.edge_index import EdgeIndex
from robot.fields.ray_casting import cast_toward
from robot.geometry import Array


@compiled(error_model="numpy")
def beam_log_likelihoods(
    poses: Array,
    centre: Array,
    rays: Array,
    edges: EdgeIndex,
    range_max: float,
    sd: float,
    hit: float,
    false: float,
    log_missed: float,
) -> Array:
    """Return the log-likelihood (n,) of a scan at poses (n, 3), up to a constant.

    Args:
        poses: [m, m, rad] in the map.
        centre: x, y [m] where rays start, in the robot frame.
        rays: (k, 7) as ``Beam`` makes them.
        range_max: the longest range [m].
        sd: standard deviation of a range [m].
        hit: density of a range that is exactly that of its edge [1/m].
        false: density of a range that is false [1/m].
        log_missed: log-probability that a ray misses an edge that it should have met.
    """
    result = np.empty(len(poses))
    # By rows, so that the compiler works on several rays at a time.
    rays = np.ascontiguousarray(rays.T)
    fan = np.empty((3, rays.shape[1]))
    for i in range(len(poses)):
        c, s = math.cos(poses[i, 2]), math.sin(poses[i, 2])
        x = poses[i, 0] + c * centre[0] - s * centre[1]
        y = poses[i, 1] + s * centre[0] + c * centre[1]
        _cast_fan(x, y, c, s, rays, edges, range_max, fan)
        result[i] = _log_likelihood(rays, fan[2], sd, hit, false, log_missed)
    return result


@compiled(error_model="numpy", forceinline=True)
def _cast_fan(
    x: float,
    y: float,
    c: float,
    s: float,
    rays: Array,
    index: EdgeIndex,
    range_max: float,
    fan: Array,
) -> None:
    """Fill the last row of ``fan`` (3, k) with the expected ranges [m] of rays from one place."""
    dx, dy, expected = fan[0], fan[1], fan[2]
    near = rays[4]
    for j in range(len(near)):
        dx[j], dy[j] = c * rays[0, j] - s * rays[1, j], s * rays[0, j] + c * rays[1, j]
        expected[j] = math.inf
    if index.columns * index.rows > 1:
        for j in range(len(near)):
            start_x, start_y = x + near[j] * dx[j], y + near[j] * dy[j]
            result, _ = cast_toward(start_x, start_y, dx[j], dy[j], index, range_max - near[j])
            expected[j] = near[j] + result
        return
    for edge in range(len(index.edges)):
        x0, y0 = index.edges[edge, 0] - x, index.edges[edge, 1] - y
        x1, y1 = index.edges[edge, 2] - x, index.edges[edge, 3] - y
        _meet(x0, y0, x1, y1, dx, dy, near, expected)
    for j in range(len(near)):
        if expected[j] > range_max:
            expected[j] = math.inf


@compiled(error_model="numpy")
def _meet(
    x0: float,
    y0: float,
    x1: float,
    y1: float,
    dx: Array,
    dy: Array,
    near: Array,
    expected: Array,
) -> None:
    """Shorten the rays from the origin that meet an edge, as ``cast_toward`` does.

    The loop has no branch and the function is not inlined, so that the compiler works on several
    rays at a time.
    """
    across = y0 * x1 - x0 * y1
    for j in range(len(dx)):
        side0, side1 = x0 * dy[j] - y0 * dx[j], x1 * dy[j] - y1 * dx[j]
        along = across / (side1 - side0)
        met = (side0 <= 0.0) & (side1 >= 0.0) & (side0 < side1) & (along >= near[j])
        expected[j] = along if met & (along < expected[j]) else expected[j]


@compiled(error_model="numpy", forceinline=True)
def _log_likelihood(
    rays: Array, expected: Array, sd: float, hit: float, false: float, log_missed: float
) -> float:
    """Return the log-likelihood of one pose (Table 6.1)."""
    total, product = 0.0, 1.0
    for j in range(len(expected)):
        z = rays[2, j]
        if z == math.inf:
            if rays[5, j] <= expected[j] <= rays[6, j]:
                total += log_missed
            continue
        p = false + (rays[3, j] if z <= expected[j] else 0.0)
        offset = (z - expected[j]) / sd
        # Farther out, the normal density is smaller than the rounding of ``p``.
        if -8.0 < offset < 8.0:
            p += hit * math.exp(-0.5 * offset * offset)
        # One logarithm serves many factors; it is taken before their product over- or underflows.
        product *= p
        if not 1e-100 < product < 1e100:
            total += math.log(product)
            product = 1.0
    return total + math.log(product)
