"""Compiled sums over a scan's rays: their residuals, and how pose, mounting and scale change them.

At a pose, each ray's end is at a distance d from the edge that the ray met. The pose changes d by
J (3), and a camera that is mounted askew changes it by A (2). The camera's height is h. A pitch
error moves the floor point (X, Y) ahead of the camera by ((X^2 + h^2) / h, X Y / h), and a roll
error moves it by (X Y / h, (Y^2 + h^2) / h). If a floor is laid out larger than it is drawn, an
edge moves away from the map's origin by the scale times its position. A map that a laser made is
its own measure: then only the way from the robot to the edge counts.
"""

from __future__ import annotations

import math

import numpy as np

from robot import ray_columns as column
from robot.compiling import compiled
from robot.fields.edge_index import EdgeIndex
from robot.fields.ray_casting import cast_toward, tangent_at
from robot.geometry import Array
from robot.localization.scan_matching import SLOPE, TAIL

COLUMNS = 7
"""Columns of a ray's row: the distance's derivatives by x, y, theta, pitch, roll and scale; then
the distance itself."""
GATE = 0.03
"""Ends that are farther off an edge than this belong to another edge [m]."""
SPREAD = 0.0001
"""Spread of an end's distance from its edge where the floor is near [m]."""


@compiled()
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
    """Return sums of products (7, 7) over the rays of a scan, each weighed by its spread.

    Args:
        pose: pose of the robot in the map (3,).
        rays: (n, 9) as ``rays_of`` returns them.
        range_max: how far rays reach [m].
        camera_x: how far ahead of the robot's origin the camera is [m].
        camera_height: height above the floor [m]; infinite for a laser, without pitch and roll.
        pitch: pitch by which the rays were already corrected [rad].
        roll: roll by which the rays were already corrected [rad].
        exactness: how far ends lie off, in usual spreads; ends much farther off hardly count.

    Returns:
        The sums, how many rays lie on an edge, and how many returned something.
    """
    sums = np.zeros((COLUMNS, COLUMNS))
    row = np.empty(COLUMNS)
    c, s = math.cos(pose[2]), math.sin(pose[2])
    used = returned = 0
    for i in range(len(rays)):
        near, length = rays[i, column.NEAR], rays[i, column.RANGE]
        if math.isnan(near) or not math.isfinite(length):
            continue
        returned += 1
        turn = rays[i, column.DIRECTION]
        ahead = c * rays[i, column.X] - s * rays[i, column.Y]
        aside = s * rays[i, column.X] + c * rays[i, column.Y]
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
        # The expected end: from the robot along the map's axes, and from the camera along the
        # robot's. With the measured end, the noise of grazing rays would look like a tilt.
        reach = near + expected
        ux, uy = ahead + reach * dx, aside + reach * dy
        X = rays[i, column.X] + reach * math.cos(turn) - camera_x
        Y = rays[i, column.Y] + reach * math.sin(turn)
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
