"""Clutter: things on a floor that no map has; and the light on it: shadows, lamps, reflections."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import cv2
import numpy as np
from numpy.typing import NDArray

from robot.fields.floor_picture import FloorPicture
from robot.geometry import Array
from sim.floor_camera import KINDS, CameraSettings
from sim.floor_textures import add_texture

DISCS = 25
"""Number of discs."""
RADII = (0.006, 0.040)
"""Radii of the discs: many discs have chords as long as tape is wide."""

CABLE_WIDTH = 0.007
"""[m]"""
SHADOW = 0.55
"""Share of the light that is left in the shadow."""

PENUMBRA = 0.04
"""Width of the shadow's edge, for a lamp at the ceiling."""

SHOE = (0.28, 0.10)
"""Length and width of a shoe."""

PAIRS_OF_SHOES = 3
"""Number of pairs."""
DARK = 32
"""Brightness of things on the floor: as of the tape in maps/, #202225 [grey levels]."""

_SHIFT = 4
"""Number of fractional bits in pixel coordinates for OpenCV."""
REFLECTIONS = 4
"""Number of lamps that are seen on the floor."""
REFLECTION_SD = 0.06
"""Size of a lamp's reflection on the floor: standard deviation of its brightness [m]."""


class _Painter:
    """Paints on a copy of a floor picture, in map coordinates [m]."""

    def __init__(self, floor: FloorPicture, rng: np.random.Generator) -> None:
        self.image = floor.image.copy()
        self.rng = rng
        self._floor = floor
        xmin, ymin, xmax, ymax = floor.extent
        self._middle = np.array([xmin + xmax, ymin + ymax]) / 2
        self._half = np.array([xmax - xmin, ymax - ymin]) / 2

    def places(self, shares: Array) -> Array:
        """Return points (n, 2) in the map; ``shares`` go from -1 to 1, from border to border."""
        points: Array = self._middle + shares * self._half
        return points

    def disc(self, centre: Array, radius: float) -> None:
        """Paint a round dark patch."""
        size = self._fine(np.array([radius / self._floor.resolution]))
        cv2.circle(
            self.image, self._pixels(centre[None])[0], size[0], DARK, -1, cv2.LINE_AA, _SHIFT
        )

    def line(self, points: Array, width: float) -> None:
        """Paint a dark line through points (n, 2)."""
        thick = max(1, round(width / self._floor.resolution))
        cv2.polylines(self.image, [self._pixels(points)], False, DARK, thick, cv2.LINE_AA, _SHIFT)

    def shape(self, outline: Array) -> None:
        """Paint a dark patch with an outline (n, 2)."""
        cv2.fillPoly(self.image, [self._pixels(outline)], DARK, cv2.LINE_AA, _SHIFT)

    def shade(self, point: Array, normal: Array) -> None:
        """Darken the side of a line that its normal points to."""
        height, width = self.image.shape
        pixel = self._floor.pixel_from_map
        x = (np.arange(width) - pixel[0, 2]) / pixel[0, 0] - point[0]
        y = (np.arange(height) - pixel[1, 2]) / pixel[1, 1] - point[1]
        depth = (normal[0] * x + normal[1] * y[:, None]) / PENUMBRA + 0.5
        inside = np.clip(depth, 0, 1).astype(np.float32)
        soft = inside * inside * (3 - 2 * inside)
        self.image = np.rint(self.image * (1 - (1 - SHADOW) * soft)).astype(np.uint8)

    def _pixels(self, points: Array) -> NDArray[np.int32]:
        pixel = self._floor.pixel_from_map
        return self._fine(points @ pixel[:, :2].T + pixel[:, 2])

    def _fine(self, pixels: Array) -> NDArray[np.int32]:
        return np.rint(pixels * (1 << _SHIFT)).astype(np.int32)


def _discs(painter: _Painter) -> None:
    """Paint dark discs between the tapes."""
    centres = painter.places(painter.rng.uniform(-0.56, 0.56, (DISCS, 2)))
    for centre, radius in zip(centres, painter.rng.uniform(*RADII, DISCS), strict=True):
        painter.disc(centre, radius)


def _cable(painter: _Painter) -> None:
    """Paint a thin dark line that winds from one border to the opposite one, over the tape."""
    # Imported only here: the import takes long, and most floors are clear.
    from scipy.interpolate import CubicSpline  # noqa: PLC0415

    across = np.linspace(-1, 1, 7)
    winding = painter.rng.uniform(-0.5, 0.5, 7)
    shares = CubicSpline(across, winding)(np.linspace(-1, 1, 200))
    points = np.column_stack([np.linspace(-1, 1, 200), shares])
    painter.line(
        painter.places(points if painter.rng.random() < 0.5 else points[:, ::-1]), CABLE_WIDTH
    )


def _shadow(painter: _Painter) -> None:
    """Put one side of the floor in the shade."""
    angle = painter.rng.uniform(-np.pi, np.pi)
    point = painter.places(painter.rng.uniform(-0.3, 0.3, 2))
    painter.shade(point, np.array([np.cos(angle), np.sin(angle)]))


def _shoes(painter: _Painter) -> None:
    """Paint pairs of shoes of people around the field, with the toes on or near the tape."""
    for _ in range(PAIRS_OF_SHOES):
        side = painter.rng.integers(4)
        toward = np.array([[1, 0], [0, 1], [-1, 0], [0, -1]])[side]
        beside = np.array([-toward[1], toward[0]])
        toes = -toward * painter.rng.uniform(0.6, 0.8) + beside * painter.rng.uniform(-0.5, 0.5)
        for foot in (-0.09, 0.09):
            painter.shape(painter.places(toes) + _shoe(toward, beside, foot))


def _shoe(toward: Array, beside: Array, foot: float) -> Array:
    """Return the outline (n, 2) of one shoe behind its toes [m]: an oval that is wider in front."""
    turn = np.linspace(0, 2 * np.pi, 60, endpoint=False)
    length, width = SHOE
    along = length / 2 * (np.cos(turn) - 1)
    across = width / 2 * np.sin(turn) * (1 + 0.15 * np.cos(turn)) + foot
    outline: Array = along[:, None] * toward + across[:, None] * beside
    return outline


CLUTTER: dict[str, Callable[[_Painter], None]] = {
    "discs": _discs,
    "cable": _cable,
    "shadow": _shadow,
    "shoes": _shoes,
}
"""Kinds of clutter by name, in the order in which they are painted."""


def disturbed(
    floor: FloorPicture, settings: CameraSettings, streams: Sequence[np.random.Generator]
) -> FloorPicture:
    """Return a floor as a camera's settings say: of a texture, scaled, littered, and lit.

    ``streams`` draw what is littered, and the places of the lamp and of reflections.
    """
    for_clutter, for_light, for_glare = streams
    if settings.texture != "none":
        # A child of a child: what is drawn of a texture changes no other stream.
        for_texture = for_clutter.spawn(1)[0]
        floor = add_texture(floor, settings.texture, settings.tone, for_texture)
    littered = add_clutter(floor.scaled(settings.floor_scale), settings.clutter, for_clutter)
    lit = add_uneven_light(littered, settings.uneven_light, for_light)
    return add_glare(lit, settings.glare, for_glare)


def add_clutter(floor: FloorPicture, kind: str, rng: np.random.Generator) -> FloorPicture:
    """Return a floor with clutter on it.

    Args:
        floor: the drawing of the floor; it is not changed.
        kind: one of ``KINDS``.
        rng: draws the positions of the things.

    Raises:
        ValueError: the kind is unknown.
    """
    if kind not in KINDS:
        raise ValueError(f"no clutter {kind!r}; valid are {', '.join(KINDS)}")
    if kind == "none":
        return floor
    painter = _Painter(floor, rng)
    for name, paint in CLUTTER.items():
        if kind in (name, "all"):
            paint(painter)
    return replace(floor, image=painter.image)


def add_uneven_light(floor: FloorPicture, lost: float, rng: np.random.Generator) -> FloorPicture:
    """Return a floor that is lit by one lamp above it.

    The loss of light grows with the square of the distance from the point below the lamp.

    Args:
        floor: the drawing of the floor; it is not changed.
        lost: share of the light that is lost at the farthest corner.
        rng: draws the position of the lamp.
    """
    if lost == 0:
        return floor
    height, width = floor.image.shape
    column, row = rng.uniform(0.1, 0.9, 2) * (width, height)
    x, y = np.arange(width) - column, np.arange(height)[:, None] - row
    distance2 = (x * x + y * y) / (max(column, width - column) ** 2 + max(row, height - row) ** 2)
    light = (1 - lost * distance2).astype(np.float32)
    return replace(floor, image=np.rint(floor.image * light).astype(np.uint8))


def add_glare(floor: FloorPicture, added: float, rng: np.random.Generator) -> FloorPicture:
    """Return a floor with reflections of lamps, on the tape as well.

    The reflections stay in place while the robot moves, as if the lamps were far above the camera.

    Args:
        floor: the drawing of the floor; it is not changed.
        added: grey levels that a reflection adds in its middle; the sum is limited to white.
        rng: draws the positions of the reflections.
    """
    if added == 0:
        return floor
    height, width = floor.image.shape
    glare = np.zeros((height, width), dtype=np.float32)
    sd = REFLECTION_SD / floor.resolution
    for column, row in rng.uniform(0.2, 0.8, (REFLECTIONS, 2)) * (width, height):
        across = np.exp(-0.5 * ((np.arange(width) - column) / sd) ** 2)
        down = np.exp(-0.5 * ((np.arange(height) - row) / sd) ** 2)
        glare += (added * down[:, None] * across).astype(np.float32)
    image = np.minimum(np.rint(floor.image + glare), 255).astype(np.uint8)
    return replace(floor, image=image)
