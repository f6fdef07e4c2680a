"""Line scanner: distances to floor tape from a camera picture, as if a laser had measured them.

Rays around a point on the floor are looked up in the picture. A one-dimensional kernel finds where
the picture gets darker and brighter along each ray. A dark stripe (a light one, if the tape is
light) counts if it is as wide as the tape and lies on a line. The range is where the ray meets the
line of the stripe's entry edge.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from zlib import crc32

import cv2
import numpy as np
from numpy.typing import NDArray

from robot.camera import FloorView
from robot.geometry import Array, Pose2, Twist2, heading_vectors
from robot.interface import Frame
from robot.scan import Scan
from robot.scanning.along_rays import hidden_of, points_of, ranges_of, unskew
from robot.scanning.dashed_edges import judge_dashes
from robot.scanning.edge_search import find_edges
from robot.scanning.ray_table import RayTable
from robot.scanning.settings import LineScannerSettings
from robot.scanning.tape import BLACK_TAPE, FoundTape, Look, Tape, looks, nearest_widths
from robot.scanning.tape_edges import Verdict, judge_pairs

__all__ = ["LineScan", "LineScanner", "LineScannerSettings"]

ROWS_APART = 16
"""Pictures are compared by every so many rows."""


@dataclass(frozen=True, slots=True, eq=False)
class LineScan:
    """Result of one picture: the scan, and everything needed to explain it."""

    scan: Scan
    verdicts: NDArray[np.int8] = field(repr=False)
    """(k,) the ``Verdict`` of each ray."""
    edges: Array = field(repr=False)
    """(k, 2) entry and exit of the judged pair [samples along the ray]; nan without a pair."""
    widths: Array = field(repr=False)
    """(k,) width of the stripe across its line [m]; nan where no line was tape."""
    noise: float
    """Measured standard deviation of the picture's noise, or the floor's grain [grey levels]."""
    kernel: int
    """Half width of the edge kernel, chosen for the noise [samples]."""
    picture: NDArray[np.uint8] = field(repr=False)
    """(h, w) the picture in grey, read-only."""
    table: RayTable = field(repr=False)
    """Where the rays run."""
    main_width: float
    """Width of the first kind of tape [m]."""
    known_widths: Array = field(repr=False)
    """(n,) widths of all kinds of tape that were searched for [m]."""

    @property
    def tape_widths(self) -> Array:
        """(k,) width of the kind of tape that each reading is of [m]; nan where none counts."""
        return nearest_widths(self.widths, self.verdicts == Verdict.COUNTED, self.known_widths)

    @property
    def tape_width(self) -> float:
        """Median of the widths that counted [m]; nan if none did.

        On a field of several widths, those of its first kind of tape count. It shows the camera's
        health: a pitch error of half a degree changes 50 mm by 2 mm.
        """
        counted = self.widths[self.tape_widths == self.main_width]
        return float(np.median(counted)) if len(counted) else math.nan


class LineScanner:
    """Finds tape in the pictures of one camera."""

    def __init__(
        self,
        view: FloorView,
        settings: LineScannerSettings,
        tape: tuple[Tape, ...] = (BLACK_TAPE,),
    ) -> None:
        """Make a scanner.

        Args:
            settings: how pictures are searched; they may overrule what the tape looks like.
            tape: the kinds of tape on the field (``Field.tape``), the main one first.
        """
        self._tape = tape
        self.looks = looks(settings.tape_brightness, settings.tape_width, tape)
        """What is searched for."""
        self.main_width = settings.tape_width or (tape or (BLACK_TAPE,))[0].width
        """Width of the main kind of tape [m]."""
        self._known_widths = np.unique([w for look in self.looks for w in look.all_widths])
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
        self._size = (view.lens.height, view.lens.width)
        rows = self.table.pixels[:, :, 1].astype(np.float64)
        self._late = view.lens.readout * (rows / max(1, view.lens.height - 1) - 0.5)
        self._directions = heading_vectors(self.table.bearings)
        self._start = Pose2(settings.centre_x)
        self._apart = math.ceil(1.5 / settings.step)

    def seen_through(self, view: FloorView) -> LineScanner:
        """Return a scanner with the same settings for another view of the floor."""
        return LineScanner(view, self.settings, self._tape)

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
        tape = self._tape_in(picture)
        ranges, edges, lines = tape.ranges, tape.edges, tape.lines
        sight = table.limits
        if self.view.lens.readout > 0:
            sight = sight.copy()
            unskew(
                ranges,
                sight,
                lines,
                edges,
                self._late,
                directions,
                wanted.centre_x,
                twist.v,
                twist.omega,
            )
            tape.verdicts[(tape.verdicts == Verdict.COUNTED) & np.isinf(ranges)] = (
                Verdict.NOT_STRAIGHT
            )
        return LineScan(
            Scan(
                frame.stamp,
                table.bearings,
                ranges,
                self._start,
                sight,
                clear=tape.clear,
                hidden=tape.hidden,
                picture=crc32(picture[::ROWS_APART].tobytes()) if tape.noise > 0 else 0,
            ),
            tape.verdicts,
            edges,
            tape.widths,
            tape.noise,
            tape.kernel,
            picture,
            table,
            self.main_width,
            self._known_widths,
        )

    def tape_and_first_edges(self, image: NDArray[np.uint8]) -> tuple[Array, Array]:
        """Return where rays enter and leave tape, and where they first meet anything (k, 2).

        In samples; nan for rays that do not count or meet nothing, and where one leaves what
        reaches farther than it sees. They are as measured: ``scan`` moves entries onto the line of
        their edge, which is only right if the camera is as described.

        Raises:
            ValueError: as ``scan``.
        """
        tape = self._tape_in(self._checked(image), moved=False)
        counted = (tape.verdicts == Verdict.COUNTED)[:, None]
        return np.where(counted, tape.edges, np.nan), tape.first

    def _tape_in(self, picture: NDArray[np.uint8], *, moved: bool = True) -> FoundTape:
        """Return what is found; entries that count are moved to the line of their edge, or not."""
        first, *others = [self._search(picture, look, moved) for look in self.looks]
        for other in others:
            first = first.nearer(other)
        return first

    def _search(self, picture: NDArray[np.uint8], look: Look, moved: bool) -> FoundTape:
        table, wanted = self.table, self.settings
        pairs, met, single, noise, kernel, clear = find_edges(
            picture,
            table.pixel_indices,
            table.counts,
            table.pixels,
            self._apart,
            wanted.kernel,
            wanted.threshold,
            look.light,
        )
        points = points_of(pairs, table.distances, self._directions)
        chosen, verdicts, widths, lines = judge_pairs(
            points,
            met,
            look.widths,
            wanted.width_tolerance,
            wanted.support,
            wanted.straightness,
            wanted.taper,
            wanted.bend_radius,
        )
        if len(look.dashes):
            limits = (wanted.width_tolerance, wanted.straightness, wanted.taper)
            judge_dashes(points, met, look.dashes, limits, chosen, verdicts, widths, lines)
        ranges, edges = ranges_of(lines, pairs, chosen, verdicts, table.distances, self._directions)
        hidden = hidden_of(pairs, single, met, chosen, verdicts, table.distances)
        first = np.where(met[:, None] > 1, pairs[:, 0], single[:, 1:] * (1.0, np.nan))
        begins_inside = ~np.isnan(single[:, 0])
        first[begins_inside, 0], first[begins_inside, 1] = 0.0, single[begins_inside, 0]
        if not moved:
            edges = pairs[np.arange(len(chosen)), chosen]
        return FoundTape(
            edges, verdicts, widths, lines, ranges, hidden, first, noise, kernel, clear
        )

    def pixels(self, positions: Array) -> Array:
        """Return the pixels (k, 2) of one position on each ray (k,) [samples]; nan stays nan."""
        low = np.clip(np.nan_to_num(positions), 0, self.table.pixels.shape[1] - 2).astype(int)
        part = (positions - low)[:, None]
        rays = np.arange(len(positions))
        start, end = self.table.pixels[rays, low], self.table.pixels[rays, low + 1]
        on_chord: Array = start + part * (end - start)
        return on_chord

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
