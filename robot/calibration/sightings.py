"""Where the floor is that a pixel saw, and which edge of the field it is."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace

import numpy as np
from numba import njit
from numpy.typing import NDArray

from robot.calibration.drive_log import DriveLog
from robot.calibration.tape_edges import TapeEdges
from robot.calibration.unknowns import COUNT, FOCAL, LENS, ROTATION, SHIFT, TAPE, Differences
from robot.description.spec import RobotSpec
from robot.fields.field import Field
from robot.geometry import Array

PIXEL_SD = 0.16
"""Standard deviation of an edge's place in the picture [px]: twice that of one ray in a clear
picture, as neighbouring rays see the same piece of tape, with the same error."""
FLOOR_SD = 0.00012
"""Standard deviation of the tape's edge on the floor [m]."""
NEAR_END = -2
"""Stands for an edge that is not measured so near to its end."""
GRAZING = 0.15
"""Sine of the least angle between a ray and an edge that it measures."""
PIXEL_STEP = 0.05
"""Distance over which rays change, for their derivatives [px]."""
FARTHEST = 5.0
"""Floor points farther than this are none [m]: the camera looks at the horizon."""


@dataclass(frozen=True)
class FloorPoints:
    """The floor points that the pixels of some pictures saw."""

    points: Array = field(repr=False)
    """(k, 2 r, 2) in the robot's frame at the picture's stamp [m]."""
    at_edges: Array = field(repr=False)
    """(k, 2 r, 2) the same of pixels without their errors, as far as these are known [m]. All
    derivatives are taken there. At the pixels they would be correlated with the errors, and a
    smaller world would fit better."""
    by_camera: Array = field(repr=False)
    """(k, 2 r, 2, 7) their derivatives by the camera's rotation, shift and focal length."""
    by_pixel: Array = field(repr=False)
    """(k, 2 r, 2, 2) their derivatives by the pixel [m/px]."""

    def part(self, first: int, last: int) -> FloorPoints:
        """Return the floor points of some pictures."""
        some = slice(first, last)
        return FloorPoints(
            self.points[some], self.at_edges[some], self.by_camera[some], self.by_pixel[some]
        )


@dataclass(frozen=True)
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
    near_ends: int
    """How many more lie so near to an edge's end that they do not count."""


@dataclass(frozen=True)
class Sightings:
    """The tape edges that the camera saw during a drive."""

    pixels: Array = field(repr=False)
    """(k, 2 r, 2) where rays enter tape, then where they leave it [px]; nan without tape."""
    late: Array = field(repr=False)
    """(k, 2 r) when a pixel was exposed, after the picture's stamp [s]."""
    rows: Array = field(repr=False)
    """(k, 2 r, 3) powers 0 to 2 of a pixel's row, from -1 (top) to 1."""
    spec: RobotSpec
    tape: TapeEdges
    """What the sightings are of."""

    @classmethod
    def of(cls, log: DriveLog, spec: RobotSpec, taped: Field) -> Sightings:
        """Return the sightings of a drive on a field."""
        return cls.of_edges(log, spec, TapeEdges.of(taped.edges))

    @classmethod
    def of_edges(cls, log: DriveLog, spec: RobotSpec, tape: TapeEdges) -> Sightings:
        """Return the sightings of a drive on some tape."""
        lens = spec.lens
        half = (lens.height - 1) / 2
        down = log.pixels[:, :, 1] - half
        late = lens.readout / max(1, lens.height - 1) * down
        rows = (down / half)[:, :, None] ** np.arange(3)
        return cls(log.pixels, late, rows, spec, tape)

    def part(self, first: int, last: int) -> Sightings:
        """Return the sightings of some pictures."""
        return self._part_of(slice(first, last))

    def every(self, step: int) -> Sightings:
        """Return the sightings of every so many pictures."""
        return self._part_of(slice(None, None, step))

    def _part_of(self, some: slice) -> Sightings:
        return replace(self, pixels=self.pixels[some], late=self.late[some], rows=self.rows[some])

    def floor_points(
        self, values: Array, twists: Array, errors: Array | None = None
    ) -> FloorPoints:
        """Return where the floor is that the pixels saw.

        Args:
            values: (15,) differences from the description.
            twists: (k, 2) the robot's velocity at each picture [m/s, rad/s].
            errors: (k, 2 r, 2) how far pixels lie off their edges in the picture, as far as that is
                known [px].
        """
        pose = Differences(values).robot_from_camera(self.spec)
        turn, place = pose[:3, :3], pose[:3, 3]
        seen = np.isfinite(self.pixels[:, :, 0])
        pixels = self.pixels[seen]
        right = pixels if errors is None else pixels - errors[seen]
        rays = self._rays(right, values[FOCAL])
        by_camera, by_pixel = self._derivatives(right, rays, values[FOCAL], turn, place[2])
        points = at_edges = _on_floor(rays @ turn.T, place)
        if errors is not None:
            points = _on_floor(self._rays(pixels, values[FOCAL]) @ turn.T, place)
        # In the frame at the stamp, a row exposed later saw the floor from where the robot was.
        v, omega = np.broadcast_to(twists[:, None], (*seen.shape, 2))[seen].T
        late = self.late[seen]
        moved = np.zeros((len(pixels), 2, 2))
        moved[:, 0, 0] = moved[:, 1, 1] = 1
        moved[:, 0, 1], moved[:, 1, 0] = -late * omega, late * omega
        shift = np.column_stack([late * v, 0 * late])
        points, at_edges = (
            np.einsum("nij,nj->ni", moved, some) + shift for some in (points, at_edges)
        )
        return FloorPoints(
            _spread(points, seen),
            _spread(at_edges, seen),
            _spread(moved @ by_camera, seen),
            _spread(moved @ by_pixel, seen),
        )

    def _derivatives(
        self, pixels: Array, rays: Array, focal: float, turn: Array, height: float
    ) -> tuple[Array, Array]:
        """Return derivatives of floor points: (n, 2, 7) by the camera, (n, 2, 2) by the pixel."""
        beside = (self._rays(pixels + step, focal) for step in PIXEL_STEP * np.eye(2))
        by_column, by_row = ((moved - rays) / PIXEL_STEP for moved in beside)
        # A longer lens sees what is nearer to the centre.
        right, down = (-(pixels - self.spec.lens.matrix[:2, 2]) / (1 + focal)).T[:, :, None]
        changes = np.stack([right * by_column + down * by_row, by_column, by_row])
        down = rays @ turn.T
        about_axes = np.cross(np.eye(3)[:, None, :], down)
        turned = np.concatenate([about_axes, changes @ turn.T])
        q, depth = down[:, :2], down[:, 2:]
        slopes = -height * (turned[..., :2] / depth - q * turned[..., 2:] / depth**2)
        by_camera = np.empty((len(pixels), 2, 7))
        by_camera[:, :, ROTATION] = slopes[:3].transpose(1, 2, 0)
        by_camera[:, :, 3:5] = np.eye(2)
        by_camera[:, :, 5] = -q / depth
        by_camera[:, :, 6] = slopes[3]
        return by_camera, slopes[4:].transpose(1, 2, 0)

    def _rays(self, pixels: Array, focal: float) -> Array:
        """Return the viewing directions (n, 3) of pixels with a longer lens."""
        # It sees at a pixel what the described one sees nearer to the centre.
        centre = self.spec.lens.matrix[:2, 2]
        return self.spec.lens.unproject(centre + (pixels - centre) / (1 + focal))


def _on_floor(down: Array, place: Array) -> Array:
    """Return where rays (n, 3) from a place (3,) meet the floor (n, 2); nan beyond FARTHEST."""
    points: Array = place[:2] - place[2] * down[:, :2] / down[:, 2:]
    good = (down[:, 2] < -1e-6) & (np.abs(points).max(axis=1) < FARTHEST)
    points[~good] = np.nan
    return points


def _spread(values: Array, seen: NDArray[np.bool_]) -> Array:
    full = np.full((*seen.shape, *values.shape[1:]), np.nan)
    full[seen] = values
    return full


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
    matched, near_ends = np.flatnonzero(edge >= 0), int((edge == NEAR_END).sum())
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
    )


@njit(cache=True, nogil=True)
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
