"""Compiled fits of a line or an arc through the entries of neighbouring rays.

A curve is an array (6,): the unit normal n toward the rays' side (2); n . p of its middle p [m];
the worst distance of an entry from it [m]; t . p of its middle [m], with the tangent
t = (n_y, -n_x); and its curvature [1/m], positive where the curve bulges toward the rays, 0 for a
line.
"""

from __future__ import annotations

import math

import numpy as np

from robot.compiling import compiled
from robot.geometry import Array

ROUNDS = 4
"""Gauss-Newton steps of an arc; from a line of 80 mm along a bend of 70 mm, three are enough."""
GRAZING = 0.03
"""A ray that meets an arc at a flatter angle than this keeps its measured range."""
FEWEST = 6
"""Smallest number of entries for an arc or a parabola."""


@compiled()
def fit_line(chain: Array, first: int, last: int, curve: Array) -> None:
    """Fit a line through the entries first..last of a chain (n, 4), by total least squares."""
    count = last - first + 1
    mean_x = mean_y = xx = xy = yy = 0.0
    for i in range(first, last + 1):
        mean_x += chain[i, 0] / count
        mean_y += chain[i, 1] / count
    for i in range(first, last + 1):
        dx, dy = chain[i, 0] - mean_x, chain[i, 1] - mean_y
        xx += dx * dx
        xy += dx * dy
        yy += dy * dy
    along = 0.5 * math.atan2(2 * xy, xx - yy)
    nx, ny = -math.sin(along), math.cos(along)
    if nx * mean_x + ny * mean_y > 0:
        nx, ny = -nx, -ny
    curve[0], curve[1], curve[2] = nx, ny, nx * mean_x + ny * mean_y
    curve[4], curve[5] = ny * mean_x - nx * mean_y, 0.0
    curve[3] = _worst(chain, first, last, curve)


@compiled()
def fit_arc(chain: Array, first: int, last: int, curve: Array) -> None:
    """Bend the line that ``fit_line`` wrote to the curve, by Gauss-Newton on true distances.

    The distance is Karimaeki's (Effective circle fitting for particle trajectories, 1991), which
    is as good for a line as for an arc. With too few entries, the worst distance becomes infinite.
    """
    if last - first + 1 < FEWEST:
        curve[3] = np.inf
        return
    for _ in range(ROUNDS):
        a, b, c = _step(chain, first, last, curve)
        nx, ny = curve[0], curve[1]
        x = (curve[2] + a) * nx + curve[4] * ny
        y = (curve[2] + a) * ny - curve[4] * nx
        cosine, sine = math.cos(b), math.sin(b)
        curve[0], curve[1] = cosine * nx + sine * ny, cosine * ny - sine * nx
        curve[2], curve[4] = curve[0] * x + curve[1] * y, curve[1] * x - curve[0] * y
        curve[5] += c
    curve[3] = _worst(chain, first, last, curve)


@compiled()
def _step(chain: Array, first: int, last: int, curve: Array) -> tuple[float, float, float]:
    """Return how far to shift the curve [m], turn it [rad] and bend it [1/m] for a better fit."""
    n = last - first + 1
    s1 = s2 = s3 = s4 = r0 = r1 = r2 = 0.0
    for i in range(first, last + 1):
        v = place(chain[i, 0], chain[i, 1], curve)
        d = distance(chain[i, 0], chain[i, 1], curve)
        v2 = v * v
        s1 += v
        s2 += v2
        s3 += v2 * v
        s4 += v2 * v2
        r0 += d
        r1 += d * v
        r2 += d * v2
    # d - a + b v + c v^2 / 2 = 0 by Cramer's rule.
    det = n * (s2 * s4 - s3 * s3) - s1 * (s1 * s4 - s3 * s2) + s2 * (s1 * s3 - s2 * s2)
    if abs(det) < 1e-24:
        return 0.0, 0.0, 0.0
    level = (r0 * (s2 * s4 - s3 * s3) - s1 * (r1 * s4 - s3 * r2) + s2 * (r1 * s3 - s2 * r2)) / det
    slope = (n * (r1 * s4 - s3 * r2) - r0 * (s1 * s4 - s3 * s2) + s2 * (s1 * r2 - r1 * s2)) / det
    bend = (n * (s2 * r2 - r1 * s3) - s1 * (s1 * r2 - r1 * s2) + r0 * (s1 * s3 - s2 * s2)) / det
    return level, -slope, -2 * bend


@compiled()
def _worst(chain: Array, first: int, last: int, curve: Array) -> float:
    worst = 0.0
    for i in range(first, last + 1):
        worst = max(worst, abs(distance(chain[i, 0], chain[i, 1], curve)))
    return worst


@compiled()
def taper(chain: Array, first: int, last: int, curve: Array) -> float:
    """Return how much the width changes from end to end of an edge, by its linear trend [m]."""
    squares = product = mean = 0.0
    for i in range(first, last + 1):
        mean += place(chain[i, 0], chain[i, 1], curve) / (last - first + 1)
    for i in range(first, last + 1):
        t = place(chain[i, 0], chain[i, 1], curve) - mean
        squares += t * t
        product += t * width(chain, i, curve)
    return abs(product / squares) * math.sqrt(squared(chain[first], chain[last]))


@compiled()
def bow(chain: Array, first: int, last: int, curve: Array, middle: int) -> float:
    """Return how far a curved edge is off its line at an entry [m]; 0 if it is straight.

    The result is from the parabola through the entries first..last, if it exceeds their noise.
    """
    count = last - first + 1
    if count < FEWEST:
        return 0.0
    squares = cubes = 0.0
    for i in range(first, last + 1):
        t = place(chain[i, 0], chain[i, 1], curve)
        squares += t * t
        cubes += t * t * t
    # The shape is the square minus its own fitted line: what a parabola adds to the existing line.
    tilt, level = cubes / squares, squares / count
    product = total = rest = 0.0
    for i in range(first, last + 1):
        t = place(chain[i, 0], chain[i, 1], curve)
        offset = distance(chain[i, 0], chain[i, 1], curve)
        shape = t * t - tilt * t - level
        product += shape * offset
        total += shape * shape
        rest += offset * offset
    explained = product * product / total
    # The parabola counts from three standard errors on.
    if explained * (count - 3) < 9 * (rest - explained):
        return 0.0
    t = place(chain[middle, 0], chain[middle, 1], curve)
    return float(product / total * (t * t - tilt * t - level))


@compiled()
def meet(x: float, y: float, curve: Array, line: Array) -> None:
    """Write to ``line`` (3,) the tangent of a curve where the ray to a point (x, y) meets it.

    The ray starts at (0, 0). A line is its own tangent.
    """
    line[0], line[1], line[2] = curve[0], curve[1], curve[2]
    if curve[5] == 0.0:
        return
    reach = math.hypot(x, y)
    dx, dy = x / reach, y / reach
    for _ in range(3):
        _normal(reach * dx, reach * dy, curve, line)
        facing = line[0] * dx + line[1] * dy
        if abs(facing) < GRAZING:
            break
        reach -= distance(reach * dx, reach * dy, curve) / facing
    _normal(reach * dx, reach * dy, curve, line)
    line[2] = reach * (line[0] * dx + line[1] * dy)


@compiled(inline="always")
def _normal(x: float, y: float, curve: Array, normal: Array) -> None:
    """Compute the unit normal of a curve at the curve's point nearest to (x, y)."""
    k = curve[5]
    u, v = curve[0] * x + curve[1] * y - curve[2], place(x, y, curve)
    nx = curve[0] + k * (u * curve[0] + v * curve[1])
    ny = curve[1] + k * (u * curve[1] - v * curve[0])
    size = math.hypot(nx, ny)
    normal[0], normal[1] = nx / size, ny / size


@compiled(inline="always")
def distance(x: float, y: float, curve: Array) -> float:
    """Return the signed distance of a point from a curve, positive on the rays' side [m]."""
    u = curve[0] * x + curve[1] * y - curve[2]
    k = curve[5]
    if k == 0.0:
        return float(u)
    v = place(x, y, curve)
    double = 2 * u + k * (u * u + v * v)
    return float(double / (1 + math.sqrt(max(1 + k * double, 0.0))))


@compiled(inline="always")
def place(x: float, y: float, curve: Array) -> float:
    """Return a point's coordinate along a curve's tangent, from the curve's middle [m]."""
    return float(curve[1] * x - curve[0] * y - curve[4])


@compiled(inline="always")
def width(chain: Array, i: int, curve: Array) -> float:
    """Return the distance from an entry to its exit across a curve [m]."""
    leaving = distance(chain[i, 2], chain[i, 3], curve)
    return float(abs(leaving - distance(chain[i, 0], chain[i, 1], curve)))


@compiled(inline="always")
def squared(a: Array, b: Array) -> float:
    """Return the squared distance of two entries [m²]."""
    return float((a[0] - b[0]) * (a[0] - b[0]) + (a[1] - b[1]) * (a[1] - b[1]))
