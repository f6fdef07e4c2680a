"""Distances to floor tape out of a camera picture, as if a laser had measured them.

Rays are drawn around a point on the floor and looked up in the picture; a one-dimensional kernel
finds where it gets darker and brighter along each; what is as wide as the tape and lies on a line
is reported by its entry edge.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import cv2
import numpy as np
from numpy.typing import NDArray

from robot.camera import FloorView
from robot.geometry import Array, Pose2, Twist2, heading_vectors
from robot.interface import Frame
from robot.scan import Scan
from robot.scanning.ray_table import RayTable
from robot.scanning.tape_edges import Verdict, find_pairs, judge_pairs
from robot.settings import check_settings, setting


@dataclass(frozen=True)
class LineScannerSettings:
    """How the picture is searched for tape."""

    rays: int = setting(91, "Number of rays", low=1, high=720)
    field_of_view: float = setting(
        math.radians(62), "Angle between the outermost rays", unit="rad", low=0, high=2 * math.pi
    )
    centre_x: float = setting(
        0.0, "Where the rays start, ahead of the robot's origin", unit="m", low=-1, high=1
    )
    range_max: float = setting(1.0, "How far rays are followed", unit="m", low=0.05, high=10)
    step: float = setting(
        0.75, "Distance of the samples along a ray in the picture", unit="px", low=0.25, high=4
    )
    kernel: int = setting(
        3, "Half width of the edge kernel; wider is calmer, narrower is finer", unit="samples",
        low=1, high=20,
    )  # fmt: skip
    threshold: float = setting(
        25.0, "Weakest edge that counts, of 255 grey levels", low=1, high=255
    )
    tape_width: float = setting(0.050, "Width of the tape", unit="m", low=0.005, high=0.5)
    width_tolerance: float = setting(
        0.012, "How far the measured width may be off", unit="m", low=0, high=0.5
    )
    support: float = setting(
        0.040, "Length of straight edge that must be seen around a hit", unit="m", low=0, high=1
    )
    straightness: float = setting(
        0.0020, "How far an edge's points may lie off their line", unit="m", low=0, high=0.1
    )

    def __post_init__(self) -> None:
        check_settings(self)


@dataclass(frozen=True, slots=True)
class LineScan:
    """What was found in one picture: the scan, and everything needed to show why."""

    scan: Scan
    verdicts: NDArray[np.int8] = field(repr=False)
    """(k,) a ``Verdict`` a ray."""
    edges: Array = field(repr=False)
    """(k, 2) entry and exit of the judged pair [samples along the ray]; nan without a pair."""
    widths: Array = field(repr=False)
    """(k,) measured across the line [m]; nan where no line was found."""
    grey: NDArray[np.uint8] = field(repr=False)
    """(k, m) brightness along the rays."""
    response: NDArray[np.float32] = field(repr=False)
    """(k, m) the edge kernel's answer."""


class LineScanner:
    """Finds tape in the pictures of one camera."""

    def __init__(self, view: FloorView, settings: LineScannerSettings) -> None:
        half = settings.field_of_view / 2
        self.settings = settings
        self.table = RayTable.build(
            view,
            np.linspace(-half, half, settings.rays) if settings.rays > 1 else np.zeros(1),
            centre_x=settings.centre_x,
            range_max=settings.range_max,
            step_px=settings.step,
        )
        self._readout = view.lens.readout
        self._height = view.lens.height
        self._size = (view.lens.height, view.lens.width)
        self._directions = heading_vectors(self.table.bearings)
        self._places = _planes(self.table.pixels)
        self._kernel = _edge_kernel(settings.kernel)
        self._samples = np.arange(self.table.distances.shape[1], dtype=np.float64)

    def scan(self, frame: Frame, twist: Twist2 = Twist2()) -> LineScan:
        """Search one picture.

        Args:
            frame: the picture, of the size that the lens was described for.
            twist: the robot's velocity, which undoes the rolling shutter's skew.

        Raises:
            ValueError: the picture has another size, or neither one colour nor three.
        """
        image = self._checked(frame.image)
        looked_up = cv2.remap(image, *self._places, cv2.INTER_LINEAR)
        grey = np.asarray(looked_up, dtype=np.uint8)
        answer = cv2.filter2D(grey, cv2.CV_32F, self._kernel)
        response = np.asarray(answer, dtype=np.float32)
        border = self.settings.kernel + 1
        pairs, found = find_pairs(response, self.table.counts, self.settings.threshold, border)
        distances = self._distances(pairs)
        points = self._directions[:, None, None] * distances[..., None]
        chosen, verdicts, widths, normals = judge_pairs(
            points[:, :, 0],
            points[:, :, 1],
            self.settings.tape_width,
            self.settings.width_tolerance,
            self.settings.support,
            self.settings.straightness,
        )
        rays = np.arange(len(chosen))
        verdicts[(found % 2 == 1) & (verdicts == Verdict.NO_EDGE)] = Verdict.NO_EXIT
        verdicts[self.table.counts == 0] = Verdict.OUT_OF_SIGHT
        edges = pairs[rays, chosen]
        ranges = np.where(verdicts == Verdict.COUNTED, distances[rays, chosen, 0], np.inf)
        ranges = self._unskewed(ranges, edges[:, 0], normals, twist)
        scan = Scan(frame.stamp, self.table.bearings, ranges, Pose2(self.settings.centre_x))
        return LineScan(scan, verdicts, edges, widths, grey, response)

    def pixels(self, positions: Array) -> Array:
        """Pixels (k, 2) of one place on each ray, given in samples (k,); nan stays nan."""
        low = np.clip(np.nan_to_num(positions), 0, len(self._samples) - 2).astype(int)
        part = (positions - low)[:, None]
        rays = np.arange(len(positions))
        start, end = self.table.pixels[rays, low], self.table.pixels[rays, low + 1]
        between: Array = start + part * (end - start)
        return between

    def distance(self, ray: int, position: float) -> float:
        """Distance [m] from the centre of a place on a ray, given in samples."""
        return float(np.interp(position, self._samples, self.table.distances[ray]))

    def _checked(self, image: NDArray[np.uint8]) -> NDArray[np.uint8]:
        height, width = self._size
        if image.shape not in (self._size, (*self._size, 3)):
            raise ValueError(
                f"the picture has the shape {image.shape}; the lens is described for "
                f"{width} x {height} pixels, grey ({height}, {width}) or BGR ({height}, {width}, 3)"
            )
        if image.ndim == 3:
            return np.asarray(cv2.cvtColor(image, cv2.COLOR_BGR2GRAY), dtype=np.uint8)
        return image

    def _distances(self, pairs: Array) -> Array:
        """Samples (k, p, 2) along rays to distances [m]."""
        low = np.clip(np.nan_to_num(pairs), 0, len(self._samples) - 2).astype(int)
        flat = low.reshape(len(low), -1)
        start = np.take_along_axis(self.table.distances, flat, axis=1).reshape(pairs.shape)
        end = np.take_along_axis(self.table.distances, flat + 1, axis=1).reshape(pairs.shape)
        between: Array = start + (pairs - low) * (end - start)
        return between

    def _unskewed(self, ranges: Array, entries: Array, normals: Array, twist: Twist2) -> Array:
        """Ranges as if all rows had been exposed at the frame's stamp.

        A row exposed dt after the stamp saw the floor from a robot that had moved on by v dt; in
        the frame at the stamp the edge lies that much farther along. The edge is a line, so along
        the same bearing the range changes by (n . moved) / (n . direction).
        """
        if self._readout == 0:
            return ranges
        rows = self.pixels(entries)[:, 1]
        late = self._readout * (rows / (self._height - 1) - 0.5)
        points = self._directions * np.where(np.isfinite(ranges), ranges, 0.0)[:, None]
        x, y = points[:, 0] + self.settings.centre_x, points[:, 1]
        moved = np.column_stack([twist.v - twist.omega * y, twist.omega * x]) * late[:, None]
        along = (normals * moved).sum(axis=1) / (normals * self._directions).sum(axis=1)
        return np.where(np.isfinite(ranges), ranges + along, np.inf)


def _planes(pixels: NDArray[np.float32]) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """Places (k, m, 2) as OpenCV's remap is quickest with: columns and rows apart."""
    return np.ascontiguousarray(pixels[..., 0]), np.ascontiguousarray(pixels[..., 1])


def _edge_kernel(half: int) -> NDArray[np.float32]:
    """Mean of the samples ahead less mean of those behind (1, 2 half + 1)."""
    ahead = np.full(half, 1.0 / half)
    return np.concatenate([-ahead, [0.0], ahead])[None].astype(np.float32)
