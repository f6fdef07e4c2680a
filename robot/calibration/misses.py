"""Which edge of the field each seen edge is, and how far it lies off it."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from robot.calibration.sightings import FLOOR_SD, PIXEL_SD, FloorPoints, Sightings
from robot.compiling import compiled
from robot.description.unknowns import COUNT, LENS, SHIFT, TAPE
from robot.geometry import Array

NEAR_END = -2
"""Stands for an edge that is not measured there, too near to its end."""
GRAZING = 0.15
"""Sine of the least angle between a ray and an edge that it measures."""


@dataclass(frozen=True, eq=False)
class Misses:
    """How far the seen edges lie off those of the field, and the derivatives of that."""

    residuals: Array = field(repr=False)
    """(n,) signed distances in standard deviations; positive on the light side."""
    picture: NDArray[np.int64] = field(repr=False)
    """(n,) of which picture."""
    by_pose: Array = field(repr=False)
    """(n, 3) by the picture's pose."""
    by_unknowns: Array = field(repr=False)
    """(n, 15) by the robot's unknowns."""
    map_unknowns: NDArray[np.intp] = field(repr=False)
    """(n, w) those unknowns of the map that a distance depends on; none if the map is known."""
    by_map: Array = field(repr=False)
    """(n, w) by these."""
    metres: Array = field(repr=False)
    """(n,) the same distances [m]."""
    pixels: Array = field(repr=False)
    """(k, 2 r, 2) the same distances in the picture, across the edge [px]; 0 without an edge."""
    edge: NDArray[np.int64] = field(repr=False)
    """(n,) which of the field's edges it is."""
    seen_at: Array = field(repr=False)
    """(n, 2) the pixels [px]."""
    ends: Array = field(repr=False)
    """(n, 2) where they saw the floor, in the map [m]."""
    by_pixel: Array = field(repr=False)
    """(n, 2) by the pixel [1/px]."""
    near_ends: NDArray[np.int64] = field(repr=False)
    """(k,) how many more of each picture lie too near to an edge's end to count."""
    sd: Array = field(repr=False)
    """(n,) standard deviations of the distances [m]."""
    sighting: NDArray[np.int64] = field(repr=False)
    """(n,) which of all edges that were seen each is; those of a picture follow each other."""
    points: Array = field(repr=False)
    """(2 k r, 2) where all of these saw the floor, in the map [m]; nan without an edge."""


def misses(seen: Sightings, floor: FloorPoints, poses: Array, values: Array, gate: float) -> Misses:
    """Return how far the edges that were seen lie off the field's.

    Args:
        seen: the edges that were seen.
        floor: where they are in the robot's frame.
        poses: (k, 3) of the robot in the map [m, m, rad].
        values: (15,) the unknowns.
        gate: edges farther off than this do not count [m].
    """
    shape, rays = floor.points.shape[:2], floor.points.shape[1] // 2
    c, s = np.cos(poses[:, 2])[:, None], np.sin(poses[:, 2])[:, None]
    px, py = floor.points[..., 0], floor.points[..., 1]
    turned = np.stack([c * px - s * py, s * px + c * py], axis=-1)
    toward_tape = turned / np.maximum(np.hypot(px, py), 1e-9)[..., None]
    toward_tape[:, rays:] *= -1
    ends = (poses[:, None, :2] + turned).reshape(-1, 2)
    tape = seen.tape
    toward_tape = np.ascontiguousarray(toward_tape.reshape(-1, 2))
    edge = nearest_edges(ends, toward_tape, tape.edges, tape.normals, tape.margins, gate)
    matched, near_ends = np.flatnonzero(edge >= 0), (edge == NEAR_END).reshape(shape).sum(axis=1)
    edge, picture, leaves = edge[matched], matched // shape[1], matched % shape[1] >= rays
    normal = tape.normals[edge]
    c, s = c[picture, 0], s[picture, 0]
    # The normal in the robot's frame.
    across = np.column_stack(
        [c * normal[:, 0] + s * normal[:, 1], -s * normal[:, 0] + c * normal[:, 1]]
    )
    by_pixel = np.einsum("ni,nip->np", across, floor.by_pixel.reshape(-1, 2, 2)[matched])
    a_pixel = np.hypot(*by_pixel.T)
    by_unknowns = np.zeros((len(matched), COUNT))
    by_unknowns[:, : SHIFT.stop + 1] = np.einsum(
        "ni,nip->np", across, floor.by_camera.reshape(-1, 2, 7)[matched]
    )
    # Tape that is wider than drawn ends farther out; where it begins is drawn.
    by_unknowns[:, TAPE] = np.where(leaves, -1.0, 0.0)
    by_unknowns[:, LENS] = -seen.rows.reshape(-1, 3)[matched] * by_pixel[:, 1:]
    metres = (normal * (ends[matched] - tape.edges[edge, :2])).sum(axis=1)
    metres += by_unknowns[:, TAPE] * values[TAPE] + by_unknowns[:, LENS] @ values[LENS]
    around = floor.at_edges.reshape(-1, 2)[matched]
    by_pose = np.column_stack([normal, across[:, 1] * around[:, 0] - across[:, 0] * around[:, 1]])
    pixels = np.zeros((len(ends), 2))
    pixels[matched] = (metres / a_pixel**2)[:, None] * by_pixel
    map_unknowns, by_map = tape.derivatives(edge, ends[matched])
    sd = np.hypot(PIXEL_SD * a_pixel, FLOOR_SD)
    return Misses(
        metres / sd,
        picture,
        by_pose / sd[:, None],
        by_unknowns / sd[:, None],
        map_unknowns,
        by_map / sd[:, None],
        metres,
        pixels.reshape(*shape, 2),
        edge,
        seen.pixels.reshape(-1, 2)[matched],
        ends[matched],
        by_pixel / sd[:, None],
        near_ends,
        sd,
        matched,
        ends,
    )


@compiled()
def nearest_edges(
    points: Array, toward_tape: Array, edges: Array, normals: Array, margins: Array, gate: float
) -> NDArray[np.int64]:
    """Return the edge (n,) that each ray met, by where it did; -1 if none is near.

    It is ``NEAR_END`` if that is near an end of the edge.

    Args:
        points: (n, 2) where the rays met edges, in the map [m]; nan gives -1.
        toward_tape: (n, 2) directions of the rays in the map, reversed where they leave tape.
        edges: (m, 4) [m].
        normals: (m, 2) toward the light side.
        margins: (m, 2) from an edge's ends, where it does not count (``TapeEdges``) [m].
        gate: largest distance from an edge [m].
    """
    result = np.full(len(points), -1)
    for i in range(len(points)):
        x, y = points[i]
        if not math.isfinite(x):
            continue
        best = gate
        for j in range(len(edges)):
            nx, ny = normals[j]
            if nx * toward_tape[i, 0] + ny * toward_tape[i, 1] > -GRAZING:
                continue
            dx, dy = x - edges[j, 0], y - edges[j, 1]
            away = abs(nx * dx + ny * dy)
            if away >= best:
                continue
            ex, ey = edges[j, 2] - edges[j, 0], edges[j, 3] - edges[j, 1]
            length = math.hypot(ex, ey)
            along = (ex * dx + ey * dy) / length
            start, end = margins[j]
            if start <= along <= length - end:
                best, result[i] = away, j
            elif -start <= along <= length + end:
                best, result[i] = away, NEAR_END
    return result
