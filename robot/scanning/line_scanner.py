"""Line scanner: distances to floor tape from a camera picture, as if a laser had measured them.

Rays around a point on the floor are looked up in the picture. A one-dimensional kernel finds where
the picture gets darker and brighter along each ray. A dark stripe counts if it is as wide as the
tape and lies on a line. The range is where the ray meets the line of the stripe's entry edge.
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
from robot.scanning.along_rays import between, points_of, ranges_of, unskew
from robot.scanning.edge_search import differences, find_edges
from robot.scanning.ray_table import RayTable
from robot.scanning.tape_edges import Verdict, judge_pairs
from robot.settings import check_settings, setting


@dataclass(frozen=True)
class LineScannerSettings:
    """How the picture is searched for tape."""

    rays: int = setting(91, "Number of rays; fewer than three make no line", low=3, high=720)
    field_of_view: float = setting(
        math.radians(62),
        "Angle between the outermost rays; with none, all see one point",
        unit="rad",
        low=0.01,
        high=2 * math.pi,
    )
    centre_x: float = setting(
        0.0, "Where the rays start, ahead of the robot's origin", unit="m", low=-1, high=1
    )
    range_max: float = setting(1.0, "How far rays are followed", unit="m", low=0.05, high=10)
    step: float = setting(
        1.5, "Distance of the samples along a ray in the picture", unit="px", low=0.25, high=4
    )
    kernel: int = setting(
        2,
        "Half width of the edge kernel; wider is calmer, narrower is finer; in noise it grows",
        unit="samples",
        low=1,
        high=20,
    )
    threshold: float = setting(
        25.0, "Weakest edge that counts, of 255 grey levels; more in noise", low=1, high=255
    )
    tape_width: float = setting(0.050, "Width of the tape", unit="m", low=0.005, high=0.5)
    width_tolerance: float = setting(
        0.012,
        "How far the measured width may be off; no measurement is exact",
        unit="m",
        low=0.0005,
        high=0.5,
    )
    support: float = setting(
        0.040,
        "Length of straight edge that must be seen around a hit; points farther apart than twice "
        "this are not of one edge, so that with too little none has neighbours",
        unit="m",
        low=0.005,
        high=1,
    )
    straightness: float = setting(
        0.0020,
        "How far an edge's points may lie off their line; no measurement is exact",
        unit="m",
        low=0.0002,
        high=0.1,
    )
    taper: float = setting(
        0.006,
        "How much the width may change over that length; no measurement is exact",
        unit="m",
        low=0.0001,
        high=0.5,
    )

    bend_radius: float = setting(
        0.070,
        "Tightest bend of an edge that is tape's; large, and only straight tape counts",
        unit="m",
        low=0.03,
        high=1000,
    )

    def __post_init__(self) -> None:
        check_settings(self)


@dataclass(frozen=True, slots=True)
class LineScan:
    """Result of one picture: the scan, and everything needed to explain it."""

    scan: Scan
    verdicts: NDArray[np.int8] = field(repr=False)
    """(k,) the ``Verdict`` of each ray."""
    edges: Array = field(repr=False)
    """(k, 2) entry and exit of the judged pair [samples along the ray]; nan without a pair."""
    widths: Array = field(repr=False)
    """(k,) width of the stripe across its line [m]; nan where no line was found."""
    noise: float
    """Measured standard deviation of the picture's noise [grey levels]."""
    kernel: int
    """Half width of the edge kernel, chosen for the noise [samples]."""
    picture: NDArray[np.uint8] = field(repr=False)
    """(h, w) the picture in grey, read-only."""
    table: RayTable = field(repr=False)
    """Where the rays run."""

    @property
    def tape_width(self) -> float:
        """Median of the widths that counted [m]; nan if none did.

        It shows the camera's health: a pitch error of half a degree changes 50 mm by 2 mm.
        """
        counted = self.widths[self.verdicts == Verdict.COUNTED]
        return float(np.median(counted)) if len(counted) else math.nan

    @property
    def grey(self) -> NDArray[np.uint8]:
        """(k, m) brightness along the rays, computed on request."""
        return self.picture.ravel()[self.table.places]

    @property
    def response(self) -> NDArray[np.float32]:
        """(k, m) response of the edge kernel [grey levels], computed on request."""
        answers = differences(self.grey.astype(np.int16), self.table.counts, self.kernel)
        return (answers / self.kernel).astype(np.float32)


Judged = tuple[NDArray[np.int8], NDArray[np.int8], Array, Array]
"""What ``judge_pairs`` returns."""


class LineScanner:
    """Finds tape in the pictures of one camera."""

    def __init__(self, view: FloorView, settings: LineScannerSettings) -> None:
        half = settings.field_of_view / 2
        self.settings = settings
        self.view = view
        self.table = RayTable.build(
            view,
            np.linspace(-half, half, settings.rays),
            centre_x=settings.centre_x,
            range_max=settings.range_max,
            step_px=settings.step,
        )
        self._sight = self.table.limits
        self._size = (view.lens.height, view.lens.width)
        self._middle_row = (view.lens.height - 1) / 2
        self._a_row = view.lens.readout / max(1, view.lens.height - 1)
        self._directions = heading_vectors(self.table.bearings)
        self._start = Pose2(settings.centre_x)
        self._apart = math.ceil(1.5 / settings.step)

    def scan(self, frame: Frame, twist: Twist2 = Twist2()) -> LineScan:
        """Search one picture.

        Args:
            frame: the picture, of the size in the lens description.
            twist: the robot's velocity, for the correction of the rolling shutter's skew.

        Raises:
            ValueError: the picture has another size, or neither one colour nor three.
        """
        picture = self._checked(frame.image)
        table, wanted, directions = self.table, self.settings, self._directions
        pairs, noise, kernel, clear, judged = self._search(picture)
        chosen, verdicts, widths, lines = judged
        ranges, edges = ranges_of(lines, pairs, chosen, verdicts, table.distances, directions)
        if self._a_row > 0:
            unskew(
                ranges,
                lines,
                edges,
                table.pixels,
                directions,
                wanted.centre_x,
                self._a_row,
                self._middle_row,
                twist.v,
                twist.omega,
            )
        scan = Scan(frame.stamp, table.bearings, ranges, self._start, self._sight, clear=clear)
        return LineScan(scan, verdicts, edges, widths, noise, kernel, picture, table)

    def entries_and_exits(self, image: NDArray[np.uint8]) -> Array:
        """Return where each ray that counts enters and leaves tape (k, 2) [samples]; else nan.

        They are as measured: ``scan`` moves entries onto the line of their edge, which is only
        right if the camera is as described.

        Raises:
            ValueError: as ``scan``.
        """
        pairs, _, _, _, (chosen, verdicts, _, _) = self._search(self._checked(image))
        chosen_pairs = pairs[np.arange(len(chosen)), chosen]
        chosen_pairs[verdicts != Verdict.COUNTED] = np.nan
        return chosen_pairs

    def _search(self, picture: NDArray[np.uint8]) -> tuple[Array, float, int, Array, Judged]:
        """Return pairs, noise, kernel and clearness of ``find_edges``, and what is chosen."""
        table, wanted = self.table, self.settings
        pairs, met, noise, kernel, clear = find_edges(
            picture,
            table.places,
            table.counts,
            table.pixels,
            self._apart,
            wanted.kernel,
            wanted.threshold,
        )
        judged = judge_pairs(
            points_of(pairs, table.distances, self._directions),
            met,
            wanted.tape_width,
            wanted.width_tolerance,
            wanted.support,
            wanted.straightness,
            wanted.taper,
            wanted.bend_radius,
        )
        return pairs, noise, kernel, clear, judged

    def pixels(self, positions: Array) -> Array:
        """Return the pixels (k, 2) of one position on each ray (k,) [samples]; nan stays nan."""
        low = np.clip(np.nan_to_num(positions), 0, self.table.pixels.shape[1] - 2).astype(int)
        part = (positions - low)[:, None]
        rays = np.arange(len(positions))
        start, end = self.table.pixels[rays, low], self.table.pixels[rays, low + 1]
        on_chord: Array = start + part * (end - start)
        return on_chord

    def distance(self, ray: int, position: float) -> float:
        """Return the distance [m] from the centre to a position on a ray [samples]."""
        return float(between(self.table.distances[ray], position))

    def _checked(self, image: NDArray[np.uint8]) -> NDArray[np.uint8]:
        height, width = self._size
        if image.shape not in (self._size, (*self._size, 3)):
            raise ValueError(
                f"the picture has the shape {image.shape}; the lens is described for "
                f"{width} x {height} pixels, grey ({height}, {width}) or BGR ({height}, {width}, 3)"
            )
        if image.ndim == 3:
            image = np.asarray(cv2.cvtColor(image, cv2.COLOR_BGR2GRAY), dtype=np.uint8)
        picture = np.ascontiguousarray(image)
        picture.setflags(write=False)
        return picture
