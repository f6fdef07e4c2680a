"""Where the floor is that a pixel saw, and which edge of the field it is."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from robot.calibration.drive_log import DriveLog
from robot.calibration.tape_edges import TapeEdges
from robot.description.spec import RobotSpec
from robot.description.unknowns import FOCAL, ROTATION, Differences
from robot.fields.field import Field
from robot.geometry import Array

PIXEL_SD = 0.16
"""Standard deviation of an edge's place in the picture [px]: twice that of one ray in a clear
picture, as neighbouring rays see the same piece of tape, with the same error."""
FLOOR_SD = 0.00012
"""Standard deviation of the tape's edge on the floor [m]. Half, with half of PIXEL_SD: unknowns of
two calibrations are off by a median of 0.5 standard deviations instead of 0.3; twice: by 0.2; maps
within 0.1 mm."""
PIXEL_STEP = 0.05
"""Distance over which rays change, for their derivatives [px]."""
FARTHEST = 5.0
"""Floor points farther than this are none [m]: the camera looks at the horizon."""


@dataclass(frozen=True, eq=False)
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


@dataclass(frozen=True, eq=False)
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
        """Return the sightings of one in so many pictures."""
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
        finite = np.asarray(np.isfinite(by_pixel).all(axis=(1, 2)))
        nowhere = np.logical_not(finite)[:, None]
        if errors is not None and np.any(nowhere):
            # An edge that was taken for one far off would lie where the lens shows nothing.
            right = np.where(nowhere, pixels, right)
            rays = self._rays(right, values[FOCAL])
            by_camera, by_pixel = self._derivatives(right, rays, values[FOCAL], turn, place[2])
        moved, shift = self._moved(seen, twists)
        at_edges = _apply(moved, shift, _on_floor(rays @ turn.T, place))
        points = at_edges
        if errors is not None:
            rays = self._rays(pixels, values[FOCAL])
            points = _apply(moved, shift, _on_floor(rays @ turn.T, place))
        return FloorPoints(
            _spread(points, seen),
            _spread(at_edges, seen),
            _spread(moved @ by_camera, seen),
            _spread(moved @ by_pixel, seen),
        )

    def points(self, values: Array, twists: Array) -> Array:
        """Return the ``FloorPoints.points`` alone (k, 2 r, 2) [m], which takes less time."""
        pose = Differences(values).robot_from_camera(self.spec)
        seen = np.isfinite(self.pixels[:, :, 0])
        rays = self._rays(self.pixels[seen], values[FOCAL])
        on_floor = _on_floor(rays @ pose[:3, :3].T, pose[:3, 3])
        return _spread(_apply(*self._moved(seen, twists), on_floor), seen)

    def _moved(self, seen: NDArray[np.bool_], twists: Array) -> tuple[Array, Array]:
        """Return how the floor turned (n, 2, 2) and shifted (n, 2) since a picture's stamp.

        In the frame at the stamp, a row exposed later saw the floor from where the robot was.
        """
        v, omega = np.broadcast_to(twists[:, None], (*seen.shape, 2))[seen].T
        late = self.late[seen]
        moved = np.zeros((len(late), 2, 2))
        moved[:, 0, 0] = moved[:, 1, 1] = 1
        moved[:, 0, 1], moved[:, 1, 0] = -late * omega, late * omega
        return moved, np.column_stack([late * v, 0 * late])

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


def _apply(moved: Array, shift: Array, points: Array) -> Array:
    result: Array = np.einsum("nij,nj->ni", moved, points) + shift
    return result


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
