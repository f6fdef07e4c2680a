"""What a calibration or a map needs of a drive: pixels of edges, and the turns of the wheels."""

from __future__ import annotations

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

LOOSE: Mapping[str, Any] = {"width_tolerance": 0.030, "straightness": 0.006, "taper": 0.030}
"""Of the scanner's limits [m]: with a camera that is 1.5 degrees askew, tape seems to be 20 mm
wider or narrower, and its edges bent."""


@dataclass(frozen=True)
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
    where there is bare floor."""
    rays: Array = field(default_factory=lambda: np.zeros((0, 2, 2)), repr=False)
    """(r, 2, 2) where rays begin and end [px]."""

    def some(self, pictures: slice | NDArray[np.intp]) -> DriveLog:
        """Return the drive with some of its pictures only."""
        return replace(
            self,
            stamps=self.stamps[pictures],
            pixels=self.pixels[pictures],
            first=self.first[pictures],
        )

    def until(self, count: int) -> DriveLog:
        """Return the drive with its first pictures only."""
        return self.some(slice(count))

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
        self._pictures: list[tuple[float, Array, Array]] = []
        self._wheels: list[tuple[float, Array]] = []

    def add(self, reading: Reading) -> Array | None:
        """Add a reading; a picture that follows the last one too soon is left out.

        Returns the pixels (2 r, 2) of the picture's edges; None without a picture that is used.
        """
        self._wheels.append((reading.stamp, reading.positions[self._left_right]))
        frame = reading.frame
        if frame is None:
            return None
        if self._pictures and frame.stamp - self._pictures[-1][0] < PERIOD_S - 1e-6:
            return None
        edges, first = self._edges(frame.image)
        self._pictures.append((frame.stamp, edges, first))
        return edges

    def edges(self, image: NDArray[np.uint8]) -> Array:
        """Return the pixels (2 r, 2) in which rays enter tape, then where they leave it; or nan."""
        return self._edges(image)[0]

    def _edges(self, image: NDArray[np.uint8]) -> tuple[Array, Array]:
        tape, first = self._scanner.tape_and_first_edges(image)
        both = [np.concatenate([self._pixels(side) for side in edges.T]) for edges in (tape, first)]
        return both[0], both[1]

    def _pixels(self, positions: Array) -> Array:
        return self._scanner.pixels(positions)[EVERY // 2 :: EVERY]

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
            np.array([stamp for stamp, _, _ in self._pictures]),
            np.array([pixels for _, pixels, _ in self._pictures]).reshape(-1, 2 * len(rays), 2),
            np.array([stamp for stamp, _ in self._wheels]),
            np.array([angles for _, angles in self._wheels]).reshape(-1, 2),
            np.array([first for _, _, first in self._pictures]).reshape(-1, 2 * len(rays), 2),
            rays,
        )
