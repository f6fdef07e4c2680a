"""Compiled sums over the rays of a scan: what a pose cannot explain, and what a mounting could.

At a pose each ray's end lies off the edge that it met by a distance d. The pose moves d by J (3), a
camera that is mounted askew by A (2): by a pitch error the floor point (X, Y) ahead of the camera
moves by ((X^2 + h^2) / h, X Y / h), by a roll error by (X Y / h, (Y^2 + h^2) / h), h being the
camera's height. A floor that is laid out larger than it is drawn moves an edge away from the map's
origin, by the scale times its place; a map that a laser made is its own measure, and only the way
from the robot to the edge counts.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from robot.fields.edge_index import EdgeIndex
from robot.fields.ray_casting import cast_toward, tangent_at
from robot.geometry import Array

COLUMNS = 7
"""Of a ray's row: derivatives by x, y, theta, pitch, roll and scale; and the distance itself."""
GATE = 0.03
"""Ends farther off than this are of another edge [m]."""
SPREAD, SLOPE = 0.0001, 25.0
"""Of an end from its edge where the floor is near [m], and how it grows with a range's square."""
TAIL = 9.0
"""Squares of the spread from which on an end counts less."""


@njit(cache=True, nogil=True)
def residual_sums(
    pose: Array,
    rays: Array,
    index: EdgeIndex,
    range_max: float,
    camera_x: float,
    camera_height: float,
    pitch: float,
    roll: float,
    exactness: float,
) -> tuple[Array, int, int]:
    """Sums of products (7, 7) over the rays of a scan, each weighed by its spread.

    Args:
        pose: of the robot in the map (3,).
        rays: (n, 7) as ``rays_of`` makes them.
        index: the field's edges.
        range_max: how far rays reach [m].
        camera_x: the camera ahead of the robot's origin [m].
        camera_height: above the floor [m]; infinite for a laser, which has neither pitch nor roll.
        pitch: by which the rays were corrected already [rad].
        roll: the same.
        exactness: of the ends, in usual spreads: far off by this measure, a ray counts no more.

    Returns:
        The sums, how many rays lie on an edge, and how many returned something.
    """
    sums = np.zeros((COLUMNS, COLUMNS))
    row = np.empty(COLUMNS)
    c, s = math.cos(pose[2]), math.sin(pose[2])
    used = returned = 0
    for i in range(len(rays)):
        near, length = rays[i, 4], rays[i, 3]
        if math.isnan(near) or not math.isfinite(length):
            continue
        returned += 1
        turn = rays[i, 2]
        ahead = c * rays[i, 0] - s * rays[i, 1]
        aside = s * rays[i, 0] + c * rays[i, 1]
        dx, dy = math.cos(pose[2] + turn), math.sin(pose[2] + turn)
        x, y = pose[0] + ahead + near * dx, pose[1] + aside + near * dy
        expected, edge = cast_toward(x, y, dx, dy, index, range_max - near)
        if edge < 0:
            continue
        ex, ey = tangent_at(x + expected * dx, y + expected * dy, edge, index)
        size = math.hypot(ex, ey)
        nx, ny = ey / size, -ex / size
        offset = (length - near - expected) * (nx * dx + ny * dy)
        if abs(offset) > GATE:
            continue
        used += 1
        # Where the end is due, from the robot: along the map's axes, and along the robot's from the
        # camera. By the end that was measured, noise of rays that graze would look like a tilt.
        reach = near + expected
        ux, uy = ahead + reach * dx, aside + reach * dy
        X = rays[i, 0] + reach * math.cos(turn) - camera_x
        Y = rays[i, 1] + reach * math.sin(turn)
        ahead_n, aside_n = nx * c + ny * s, ny * c - nx * s
        row[0], row[1], row[2] = nx, ny, ny * ux - nx * uy
        row[3] = row[4] = 0.0
        row[5] = nx * ux + ny * uy
        if math.isfinite(camera_height):
            row[5] += nx * pose[0] + ny * pose[1]
            h = camera_height
            row[3] = ((X * X + h * h) * ahead_n + X * Y * aside_n) / h
            row[4] = (X * Y * ahead_n + (Y * Y + h * h) * aside_n) / h
        row[6] = offset + row[3] * pitch + row[4] * roll
        spread = exactness * SPREAD * (1 + SLOPE * length * length)
        weight = 1 / (spread * spread + offset * offset / TAIL)
        for a in range(COLUMNS):
            for b in range(COLUMNS):
                sums[a, b] += weight * row[a] * row[b]
    return sums, used, returned
