"""Trials of scans: rendered floors with tape, beside what should have been found."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import shapely
from floor_looks import cast_ray
from numpy.typing import NDArray
from places import MAPS

from robot.description.spec import RobotSpec
from robot.fields.edge_index import index_edges
from robot.fields.field import Field
from robot.fields.field_loading import load_field
from robot.geometry import Array, Pose2, Twist2, heading_vectors
from robot.interface import Frame
from robot.scanning.line_scanner import LineScanner, LineScannerSettings
from sim.floor_camera import CameraSettings, FloorCamera

VIEW = RobotSpec.load().floor_view
SQUARE = load_field("square", MAPS)
SCANNER = LineScanner(VIEW, LineScannerSettings())
STILL = Twist2()


def camera_of(field: Field, settings: CameraSettings = CameraSettings()) -> FloorCamera:
    return FloorCamera(VIEW, field.floor, settings, np.random.default_rng(1))


def drawn(folder: Path, name: str, marks: str, *, tape: str = "") -> Field:
    """The square of ``maps/`` with more marks on it."""
    square = (
        tape
        or '<rect x="-500" y="-500" width="1000" height="1000" fill="none" '
        'stroke="#202225" stroke-width="50"/>'
    )
    path = folder / f"{name}.svg"
    path.write_text(
        '<svg xmlns="http://www.w3.org/2000/svg" width="1500mm" height="1500mm" '
        'viewBox="-750 -750 1500 1500"><rect x="-750" y="-750" width="1500" height="1500" '
        f'fill="#d7d5cf"/>{square}{marks}</svg>'
    )
    return load_field(str(path), folder)


def expected(field: Field, robot: Pose2, scanner: LineScanner = SCANNER) -> tuple[Array, Array]:
    """Exact distances (k,) along each ray, within sight, to where tape begins and ends."""
    start = robot @ Pose2(float(scanner.table.centre[0]))
    begins = np.full(len(scanner.table.bearings), np.inf)
    ends = begins.copy()
    leaving = index_edges(field.edges[:, [2, 3, 0, 1]])
    for ray, (near, _) in enumerate(scanner.table.limits):
        if np.isnan(near):
            continue
        heading = start.theta + scanner.table.bearings[ray]
        c, s = math.cos(heading), math.sin(heading)
        x, y = start.x + near * c, start.y + near * s
        begins[ray] = near + cast_ray(x, y, heading, field.edge_index, 2.0)[0]
        if np.isfinite(begins[ray]):
            at = begins[ray] + 1e-6
            x, y = start.x + at * c, start.y + at * s
            ends[ray] = at + cast_ray(x, y, heading, leaving, 2.0)[0]
    return begins, ends


@dataclass
class Trial:
    """What came of scans from many poses; each array has one entry a ray."""

    ranges: Array
    begins: Array
    ends: Array
    widths: Array
    to_tape: Array
    """Distance [m] of a return from the nearest edge of tape."""
    clear: NDArray[np.bool_]
    """Which rays cross one tape, in full view, a little away from its corners."""

    @property
    def errors(self) -> Array:
        off = self.ranges[self.hit] - self.begins[self.hit]
        return off[np.abs(off) < 0.03]

    @property
    def hit(self) -> NDArray[np.bool_]:
        return np.isfinite(self.ranges)

    @property
    def missed(self) -> float:
        return 1 - float(self.hit[self.clear].mean())

    @property
    def false(self) -> float:
        """Share of the returns that are not on an edge of tape."""
        return float((self.to_tape[self.hit] > 0.01).mean())


def trial(
    field: Field,
    camera: FloorCamera,
    scanner: LineScanner = SCANNER,
    *,
    count: int = 60,
    twist: Twist2 = STILL,
    told: Twist2 | None = None,
    light: Array | None = None,
    seed: int = 0,
) -> Trial:
    rng = np.random.default_rng(seed)
    tape = shapely.multilinestrings(field.edges.reshape(-1, 2, 2))
    parts = []
    for values in field.free_poses(rng, count):
        robot = Pose2.from_array(values)
        picture = camera.picture(robot, twist)
        if light is not None:
            picture = np.clip(picture * light, 0, 255).astype(np.uint8)
        found = scanner.scan(Frame(0.0, picture), twist if told is None else told)
        begins, ends = expected(field, robot, scanner)
        start = robot @ Pose2(float(scanner.table.centre[0]))
        ranges = found.scan.ranges
        points = start.apply(
            heading_vectors(scanner.table.bearings) * np.nan_to_num(ranges, posinf=0)[:, None]
        )
        to_tape = shapely.distance(tape, shapely.points(points))
        near, far = scanner.table.limits.T
        with np.errstate(invalid="ignore"):
            in_view = (begins > near + 0.01) & (ends < far - 0.02)
        crossing = start.apply(
            heading_vectors(scanner.table.bearings)
            * np.nan_to_num((begins + ends) / 2, posinf=9.0)[:, None]
        )
        # In the middle of one side: across a corner there is no width to be measured.
        straight = (np.abs(crossing).min(axis=1) < 0.42) & (np.abs(crossing).max(axis=1) < 0.54)
        parts.append((ranges, begins, ends, found.widths, to_tape, in_view & straight))
    return Trial(*(np.concatenate(part) for part in zip(*parts, strict=True)))
