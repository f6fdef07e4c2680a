"""Textures of simulated floors: wood, lino, carpet and concrete, light or dark, by a seed.

A texture multiplies the brightness of the bare floor; tape covers it. Each is a sum of noises
whose sizes and contrasts were set beside photographs of such floors, seen from 0.2 m above.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache

import cv2
import numpy as np
from numpy.typing import NDArray

from robot.fields.floor_picture import MAX_PIXELS, FloorPicture
from sim.floor_camera import TEXTURES, TONES

BRIGHTNESS = {
    "wood": (0.80, 0.42),
    "lino": (0.86, 0.40),
    "carpet": (0.72, 0.36),
    "concrete": (0.76, 0.46),
}
"""Mean share of the drawing's brightness that is left, light and dark."""
AROUND_M = 0.5
"""How far the texture goes on outside the drawing [m]: as far as the camera looks."""
FINE_M = 0.0005
"""Size of a pixel [m] if the floor is not too large: the camera's nearest pixels see 0.3 mm."""
BARE = 0.5
"""What differs from the bare floor by more than this share of its brightness is covered."""

Grey = NDArray[np.float32]


def add_texture(
    floor: FloorPicture, kind: str, tone: str, rng: np.random.Generator
) -> FloorPicture:
    """Return a floor whose bare parts are of a material.

    Args:
        floor: the drawing of the floor; it is not changed.
        kind: one of ``TEXTURES``.
        tone: one of ``TONES``.
        rng: draws the material.

    Raises:
        ValueError: kind or tone are unknown.
    """
    if kind not in TEXTURES or tone not in TONES:
        raise ValueError(
            f"no floor {tone!r} {kind!r}; valid are {', '.join(TEXTURES)}, {' and '.join(TONES)}"
        )
    if kind == "none":
        return floor
    return _textured(floor, kind, tone, int(rng.integers(2**32)))


@lru_cache(maxsize=1)  # a camera is made anew when a fault is set, and a floor takes a second
def _textured(floor: FloorPicture, kind: str, tone: str, seed: int) -> FloorPicture:
    wider = _enlarged(floor)
    share = BRIGHTNESS[kind][TONES.index(tone)]
    made = _MAKE[kind](wider.image.shape, wider.resolution, np.random.default_rng(seed))
    bare = max(1, floor.border)
    # Where the drawing is not bare, tape hides the material; edges between are mixed.
    covered = np.abs(wider.image.astype(np.float32) - bare) / (BARE * bare)
    np.minimum(covered, 1, out=covered)
    factor = 1 + (1 - covered) * (share * made - 1)
    image = np.clip(np.rint(wider.image * factor), 0, 255).astype(np.uint8)
    return FloorPicture(image, wider.resolution, wider.extent)


def _enlarged(floor: FloorPicture) -> FloorPicture:
    """Return a floor with finer pixels, and bare floor around it."""
    around = round(AROUND_M / floor.resolution)
    image = np.pad(floor.image, around, constant_values=floor.border)
    room = 2 * MAX_PIXELS / image.size
    finer = max(1, min(round(floor.resolution / FINE_M), int(np.sqrt(room))))
    size = (image.shape[1] * finer, image.shape[0] * finer)
    image = np.asarray(cv2.resize(image, size, interpolation=cv2.INTER_LINEAR), dtype=np.uint8)
    margin = around * floor.resolution
    xmin, ymin, xmax, ymax = floor.extent
    extent = (xmin - margin, ymin - margin, xmax + margin, ymax + margin)
    return FloorPicture(image, floor.resolution / finer, extent)


def _noise(
    shape: tuple[int, ...],
    across: tuple[float, float],
    rng: np.random.Generator,
) -> Grey:
    """Return smooth noise (h, w) of mean 0 and sd 1, with a size along x and along y [px]."""
    # Noise of a size is drawn coarsely and enlarged: a blur of 100 px would take long.
    steps = [max(1.0, size / 2) for size in across]
    small = [int(np.ceil(side / step)) + 4 for side, step in zip(shape[::-1], steps, strict=True)]
    drawn = rng.standard_normal((small[1], small[0]), dtype=np.float32)
    sigmas = [size / step for size, step in zip(across, steps, strict=True)]
    if max(sigmas) > 0.3:
        drawn = np.asarray(
            cv2.GaussianBlur(drawn, (0, 0), max(sigmas[0], 0.1), sigmaY=max(sigmas[1], 0.1))
        )
    drawn = (drawn - drawn.mean()) / drawn.std()
    large = cv2.resize(
        drawn,
        (round(small[0] * steps[0]), round(small[1] * steps[1])),
        interpolation=cv2.INTER_CUBIC,
    )
    return np.asarray(large[: shape[0], : shape[1]], dtype=np.float32)


def _wood(shape: tuple[int, ...], resolution: float, rng: np.random.Generator) -> Grey:
    """Return parquet (h, w): staves along x with grain, pores, rings, and joints between."""
    mm = 0.001 / resolution
    height, width = shape
    grain = 0.045 * _noise(shape, (22 * mm, 0.5 * mm), rng)
    grain += 0.035 * _noise(shape, (70 * mm, 2.5 * mm), rng)
    grain += 0.015 * _noise(shape, (1.2 * mm, 0.4 * mm), rng)
    pores = _noise(shape, (3 * mm, 0.35 * mm), rng)
    wood: Grey = 1 + grain - 0.10 * np.clip(pores - 1.7, 0, 1)
    stave = round(70 * mm)
    for top in range(-int(rng.integers(stave)), height, stave):
        rows = slice(max(0, top), min(height, top + stave))
        left = -int(rng.uniform(0, 400 * mm))
        while left < width:
            length = int(rng.uniform(300, 600) * mm)
            columns = slice(max(0, left), min(width, max(0, left + length)))
            wood[rows, columns] *= 1 + 0.07 * np.clip(rng.standard_normal(), -2, 2)
            joint = slice(max(0, left), max(0, left + max(1, round(0.6 * mm))))
            wood[rows, joint] *= 0.72
            left += length
        wood[rows.start : rows.start + max(1, round(0.6 * mm))] *= 0.75
    return wood


def _lino(shape: tuple[int, ...], resolution: float, rng: np.random.Generator) -> Grey:
    """Return linoleum (h, w): marbled along x, with fine specks of cork and dirt."""
    mm = 0.001 / resolution
    marble = 0.030 * _noise(shape, (18 * mm, 5 * mm), rng)
    marble += 0.025 * _noise(shape, (5 * mm, 1.6 * mm), rng)
    marble += 0.018 * _noise(shape, (0.8 * mm, 0.6 * mm), rng)
    specks = _noise(shape, (0.7 * mm, 0.7 * mm), rng)
    lino: Grey = 1 + marble - 0.16 * np.clip(specks - 2.3, 0, 1)
    return lino


def _carpet(shape: tuple[int, ...], resolution: float, rng: np.random.Generator) -> Grey:
    """Return a looped carpet (h, w): loops of 3 mm in rough rows, and where feet went."""
    mm = 0.001 / resolution
    loops = 0.13 * _noise(shape, (1.1 * mm, 0.9 * mm), rng)
    loops += 0.06 * _noise(shape, (0.4 * mm, 0.4 * mm), rng)
    x = np.arange(shape[1], dtype=np.float32) / (3.0 * mm)
    y = np.arange(shape[0], dtype=np.float32)[:, None] / (2.6 * mm)
    # Yarn is not laid to the millimetre: rows wander by a loop within some centimetres.
    wander = 0.6 * _noise(shape, (15 * mm, 15 * mm), rng)
    rows = np.cos(2 * np.pi * (x + wander)) * np.cos(2 * np.pi * (y + wander))
    trodden = 0.03 * _noise(shape, (60 * mm, 60 * mm), rng)
    carpet: Grey = 1 + loops + 0.07 * rows + trodden
    return carpet


def _concrete(shape: tuple[int, ...], resolution: float, rng: np.random.Generator) -> Grey:
    """Return smoothed concrete (h, w): clouds of all sizes, sand, and pores."""
    mm = 0.001 / resolution
    cloud = np.ones(shape, dtype=np.float32)
    for size, contrast in ((90, 0.04), (30, 0.03), (10, 0.022), (3, 0.02), (1, 0.02), (0.5, 0.025)):
        cloud += contrast * _noise(shape, (size * mm, size * mm), rng)
    pores = _noise(shape, (1.0 * mm, 1.0 * mm), rng)
    concrete: Grey = cloud - 0.22 * np.clip((pores - 2.9) * 2, 0, 1)
    return concrete


_MAKE: dict[str, Callable[[tuple[int, ...], float, np.random.Generator], Grey]] = {
    "wood": _wood,
    "lino": _lino,
    "carpet": _carpet,
    "concrete": _concrete,
}
"""Each kind's material (h, w) of mean 1, for a size [px] and a pixel's side [m]."""
