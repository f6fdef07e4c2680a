"""What a calibration or a map needs of a drive: pixels of edges, and the turns of the wheels."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from robot.description.spec import RobotSpec
from robot.geometry import Array
from robot.interface import Reading
from robot.scanning.line_scanner import LineScanner, LineScannerSettings
from robot.scanning.tape import BLACK_TAPE, Tape

PERIOD_S = 0.1
"""Least time between two pictures that are used [s]: more of them tell hardly more."""

EVERY = 3
"""Every third ray is used: neighbours see the same piece of edge."""

BEFORE = 6.0
"""How far before tape the floor's brightness is read, beside the blur of its edge [samples]."""

AROUND_S = 1.0
"""Turns of the wheels so long before and after pictures belong to these: pictures come late [s]."""

LOOSE: Mapping[str, Any] = {"width_tolerance": 0.030, "straightness": 0.006, "taper": 0.030}
"""Of the scanner's limits [m]: with a camera that is 1.5 degrees askew, tape seems to be 20 mm
wider or narrower, and its edges bent."""


@dataclass(frozen=True, eq=False)
class DriveLog:
    """A drive, as far as a calibration or a map needs it."""

    stamps: Array
    """(k,) stamps of the pictures [s]."""
    pixels: Array = field(repr=False)
    """(k, 2 r, 2) where rays enter tape, then where they leave it [px]; nan without tape."""
    wheel_stamps: Array = field(repr=False)
    """(t,) [s]"""
    wheel_angles: Array = field(repr=False)
    """(t, 2) left, right, never wrapped [rad]."""
    first: Array = field(default_factory=lambda: np.zeros((0, 0, 2)), repr=False)
    """(k, 2 r, 2) where rays first meet an edge of anything, then where they leave that [px]; nan
    where there is bare floor. A ray that meets something where it begins tells nothing."""
    rays: Array = field(default_factory=lambda: np.zeros((0, 2, 2)), repr=False)
    """(r, 2, 2) where rays begin and end [px]."""
    light: NDArray[np.bool_] = field(default_factory=lambda: np.zeros((0, 0), np.bool_), repr=False)
    """(k, r) whether the tape that a ray met is lighter than the floor."""

    def some(self, pictures: slice | NDArray[np.intp]) -> DriveLog:
        """Return the drive with some of its pictures only."""
        return replace(
            self,
            stamps=self.stamps[pictures],
            pixels=self.pixels[pictures],
            first=self.first[pictures],
            light=self.light[pictures] if self.light.size else self.light,
        )

    def followed_by(self, more: DriveLog) -> DriveLog:
        """Return the drive with how it went on (``DriveRecorder.take``)."""
        return DriveLog(
            np.concatenate([self.stamps, more.stamps]),
            np.concatenate([self.pixels, more.pixels]),
            np.concatenate([self.wheel_stamps, more.wheel_stamps]),
            np.concatenate([self.wheel_angles, more.wheel_angles]),
            np.concatenate([self.first, more.first]),
            self.rays,
            np.concatenate([self.light, more.light]),
        )

    def until(self, count: int) -> DriveLog:
        """Return the drive with its first pictures only."""
        return self.some(slice(count))

    def between(self, first: int, last: int) -> DriveLog:
        """Return the drive's pictures from one to before another, with the wheels of that time."""
        begin, end = self.stamps[first] - AROUND_S, self.stamps[last - 1] + AROUND_S
        some = slice(*np.searchsorted(self.wheel_stamps, [begin, end]))
        stamps, angles = self.wheel_stamps[some], self.wheel_angles[some]
        return replace(self.some(slice(first, last)), wheel_stamps=stamps, wheel_angles=angles)

    def since(self, first: int) -> DriveLog:
        """Return the drive without its first pictures."""
        return self.some(slice(first, None))


class DriveRecorder:
    """Collects the log of a drive, reading by reading."""

    def __init__(
        self,
        spec: RobotSpec,
        settings: LineScannerSettings,
        tape: tuple[Tape, ...] = (BLACK_TAPE,),
        *,
        calibrated: bool = False,
    ) -> None:
        """Record a robot on a field with some kinds of tape (``Field.tape``).

        The scanner's limits are wider, unless the robot is calibrated.
        """
        limits = {} if calibrated else LOOSE
        self._scanner = LineScanner(spec.floor_view, replace(settings, **limits), tape)
        self._left_right = list(spec.axle)
        self._last = -math.inf
        """Stamp of the last picture [s]."""
        self._pictures: list[tuple[float, Array, Array, NDArray[np.bool_]]] = []
        self._wheels: list[tuple[float, Array]] = []

    def add(self, reading: Reading, *, look: bool = True) -> Array | None:
        """Add a reading; a picture that follows the last one too soon is left out.

        Without a look at it, a picture shows nothing, not even bare floor; but there is one, so
        that the path is followed from picture to picture.

        Returns the pixels (2 r, 2) of the picture's edges; None without a picture that is used.
        """
        self._wheels.append((reading.stamp, reading.positions[self._left_right]))
        frame = reading.frame
        if frame is None or frame.stamp - self._last < PERIOD_S - 1e-6:
            return None
        edges, first, light = self._edges(frame.image) if look else self._nothing()
        self._last = frame.stamp
        self._pictures.append((frame.stamp, edges, first, light))
        return edges

    def edges(self, image: NDArray[np.uint8]) -> Array:
        """Return the pixels (2 r, 2) in which rays enter tape, then where they leave it; or nan."""
        return self._edges(image)[0]

    def _edges(self, image: NDArray[np.uint8]) -> tuple[Array, Array, NDArray[np.bool_]]:
        tape, first = self._scanner.tape_and_first_edges(image)
        both = [np.concatenate([self._pixels(side) for side in edges.T]) for edges in (tape, first)]
        looks = self._scanner.looks
        light = np.full(len(tape), looks[0].light)
        if len(looks) > 1:
            light = self._is_lighter(image, tape)
        return both[0], both[1], light[EVERY // 2 :: EVERY]

    def _is_lighter(self, image: NDArray[np.uint8], tape: Array) -> NDArray[np.bool_]:
        """Return whether tape (k, 2) [samples] is lighter than the floor before it (k,)."""
        grey = image if image.ndim == 2 else image.mean(axis=2)
        indices = self._scanner.table.pixel_indices
        places = np.column_stack([tape.mean(axis=1), tape[:, 0] - BEFORE])
        places = np.clip(np.nan_to_num(places), 0, indices.shape[1] - 1).astype(np.intp)
        inside, before = grey.ravel()[indices[np.arange(len(tape))[:, None], places]].T
        lighter: NDArray[np.bool_] = inside > before
        return lighter

    def _nothing(self) -> tuple[Array, Array, NDArray[np.bool_]]:
        begin = self._pixels(np.zeros(len(self._scanner.table.counts)))
        nothing, dark = np.full_like(begin, np.nan), np.zeros(len(begin), np.bool_)
        return np.concatenate([nothing, nothing]), np.concatenate([begin, nothing]), dark

    def _pixels(self, positions: Array) -> Array:
        return self._scanner.pixels(positions)[EVERY // 2 :: EVERY]

    def take(self) -> DriveLog:
        """Return what was added since the last time, and forget it here."""
        taken = self.log
        self._pictures, self._wheels = [], []
        return taken

    @property
    def log(self) -> DriveLog:
        """All that was added so far."""
        table = self._scanner.table
        rays = np.stack(
            [
                self._pixels(np.zeros(len(table.counts))),
                self._pixels(table.counts.astype(np.float64) - 1),
            ],
            axis=1,
        )
        return DriveLog(
            np.array([stamp for stamp, *_ in self._pictures]),
            np.array([pixels for _, pixels, *_ in self._pictures]).reshape(-1, 2 * len(rays), 2),
            np.array([stamp for stamp, _ in self._wheels]),
            np.array([angles for _, angles in self._wheels]).reshape(-1, 2),
            np.array([first for _, _, first, _ in self._pictures]).reshape(-1, 2 * len(rays), 2),
            rays,
            np.array([light for *_, light in self._pictures], np.bool_).reshape(-1, len(rays)),
        )
