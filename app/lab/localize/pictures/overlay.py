"""Draws what was found in a picture: edges, rejected edges, and the field at the estimate."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np

from app.lab.localize.pictures.follow import LocatedPicture
from robot.cameras.camera import Picture
from robot.fields.edges import sample
from robot.fields.field import Field
from robot.geometry import Array
from robot.scanning.line_scanner import LineScan, LineScanner
from robot.scanning.tape_edges import Verdict

COLOURS = {
    Verdict.TOO_SHORT: (255, 120, 0),
    Verdict.NOT_STRAIGHT: (0, 0, 255),
    Verdict.WRONG_WIDTH: (255, 0, 255),
}
"""BGR of entries that do not count, by why: blue, red, magenta."""
ENTRY, EXIT, FIELD = (0, 255, 0), (255, 255, 0), (0, 165, 255)
"""BGR of entries that count (green), their exits (cyan), and the field's edges (orange)."""
STEP_M, FARTHEST_M = 0.004, 1.5
"""Step along the field's edges, and how far from the camera they are drawn."""


class Overlays:
    """A folder of pictures with what was found in them."""

    def __init__(self, folder: Path, field: Field) -> None:
        """Make the folder; it may exist, and pictures of the same names are replaced."""
        folder.mkdir(parents=True, exist_ok=True)
        self._folder = folder
        self._points, _ = sample(field.edges, STEP_M)

    def write(
        self, located: LocatedPicture, image: Picture, line_scan: LineScan, scanner: LineScanner
    ) -> None:
        """Draw one picture.

        Raises:
            OSError: the file cannot be written.
        """
        drawn = np.ascontiguousarray(image.copy())
        _dots(drawn, self._edges(located, scanner), FIELD, 0)
        sides = [scanner.pixels(side) for side in line_scan.edges.T]
        for verdict, colour in COLOURS.items():
            _dots(drawn, sides[0][line_scan.verdicts == verdict], colour, 2)
        counted = line_scan.scan.hit
        _dots(drawn, sides[1][counted], EXIT, 1)
        _dots(drawn, sides[0][counted], ENTRY, 2)
        done, data = cv2.imencode(".png", drawn)
        if done:
            (self._folder / f"{located.picture.path.stem}.png").write_bytes(data.tobytes())

    def _edges(self, located: LocatedPicture, scanner: LineScanner) -> Array:
        """Return the pixels (n, 2) of the field's edges, seen from the estimate."""
        seen = located.pose.inverse().apply(self._points)
        place = scanner.view.robot_from_camera[:2, 3]
        near = seen[np.hypot(*(seen - place).T) < FARTHEST_M]
        pixels = scanner.view.pixels(near)
        shown: Array = pixels[scanner.view.inside(pixels, 1.0)]
        return shown


def _dots(image: Picture, pixels: Array, colour: tuple[int, int, int], radius: int) -> None:
    for u, v in pixels[np.isfinite(pixels[:, 0])].round().astype(int).tolist():
        cv2.circle(image, (u, v), radius, colour, -1)
