"""What a calibration needs of a drive: pixels of tape edges, and the turns of the wheels."""

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
    """A drive, as far as a calibration needs it."""

    stamps: Array
    """(k,) stamps of the pictures [s]."""
    pixels: Array = field(repr=False)
    """(k, 2 r, 2) where rays enter tape, then where they leave it [px]; nan without tape."""
    wheel_stamps: Array = field(repr=False)
    """(t,) [s]"""
    wheel_angles: Array = field(repr=False)
    """(t, 2) left, right, never wrapped [rad]."""

    def until(self, count: int) -> DriveLog:
        """Return the drive with its first pictures only."""
        return replace(self, stamps=self.stamps[:count], pixels=self.pixels[:count])

    def since(self, first: int) -> DriveLog:
        """Return the drive without its first pictures."""
        return replace(self, stamps=self.stamps[first:], pixels=self.pixels[first:])


class DriveRecorder:
    """Collects the log of a drive, reading by reading."""

    def __init__(
        self,
        spec: RobotSpec,
        settings: LineScannerSettings,
        tape: tuple[Tape, ...] = (BLACK_TAPE,),
    ) -> None:
        """Record a robot on a field with some kinds of tape (``Field.tape``)."""
        self._scanner = LineScanner(spec.floor_view, replace(settings, **LOOSE), tape)
        self._left_right = list(spec.axle)
        self._pictures: list[tuple[float, Array]] = []
        self._wheels: list[tuple[float, Array]] = []

    def add(self, reading: Reading) -> None:
        """Add a reading; a picture that follows the last one too soon is left out."""
        self._wheels.append((reading.stamp, reading.positions[self._left_right]))
        frame = reading.frame
        if frame is None:
            return
        if self._pictures and frame.stamp - self._pictures[-1][0] < PERIOD_S - 1e-6:
            return
        self._pictures.append((frame.stamp, self.edges(frame.image)))

    def edges(self, image: NDArray[np.uint8]) -> Array:
        """Return the pixels (2 r, 2) in which rays enter tape, then where they leave it; or nan."""
        edges = self._scanner.entries_and_exits(image)
        sides = [self._scanner.pixels(side)[EVERY // 2 :: EVERY] for side in edges.T]
        return np.concatenate(sides)

    @property
    def log(self) -> DriveLog:
        """All that was added so far."""
        rays = len(range(EVERY // 2, self._scanner.settings.rays, EVERY))
        return DriveLog(
            np.array([stamp for stamp, _ in self._pictures]),
            np.array([pixels for _, pixels in self._pictures]).reshape(-1, 2 * rays, 2),
            np.array([stamp for stamp, _ in self._wheels]),
            np.array([angles for _, angles in self._wheels]).reshape(-1, 2),
        )
