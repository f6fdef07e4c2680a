"""Files of occupancy grids as ROS has them: map_server's YAML with a picture.

A pixel means the same as in nav2's map_server (nav2_map_server, ``map_io``), mode by mode. So a map
is the same here as on the robot that it was made for.
"""

from __future__ import annotations

import logging
import math
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path, PureWindowsPath

import cv2
import numpy as np
import yaml
from numpy.typing import NDArray

from robot.fields.map_files import Picture, read_map_yaml, read_picture
from robot.fields.occupancy_grid import FREE, OCCUPIED, UNKNOWN, Cells, MapError, OccupancyGrid
from robot.file_names import as_written
from robot.geometry import Array, Pose2

MODES = ("trinary", "scale", "raw")

COARSEST_M = 1.0
"""Largest cell in a file [m]: a robot on a floor finds nothing in larger ones."""
MOST_TURN = 2 * math.pi + 1e-3
"""Largest yaw in a file [rad]."""

LOG = logging.getLogger("brickpose")


@dataclass(frozen=True, slots=True)
class Meaning:
    """How the brightness of a pixel is converted to a cell."""

    mode: str = "trinary"
    """trinary: occupied, free or unknown; scale: also values between; raw: the value itself."""
    negate: bool = False
    """Whether white is occupied, instead of black."""
    occupied_thresh: float = 0.65
    """A pixel is occupied above this share of darkness, 0 to 1."""
    free_thresh: float = 0.196
    """A pixel is free below this share of darkness, 0 to 1; grey 205 (0.1961) is just not free."""

    def __post_init__(self) -> None:
        if self.mode not in MODES:
            raise MapError(f"mode is {self.mode!r:.60}; valid are {', '.join(MODES)}")
        for name, value in (
            ("occupied_thresh", self.occupied_thresh),
            ("free_thresh", self.free_thresh),
        ):
            if not 0 <= value <= 1:
                raise MapError(f"{name} is {value}; valid is 0 to 1")

    def cells(self, shade: Array) -> Cells:
        """Return the cells (n,) of opaque pixels with shades (n,) from 0 (black) to 1 (white)."""
        if self.mode == "raw":
            value = np.floor(shade * 255 + 0.5)
            return np.where(value <= OCCUPIED, value, UNKNOWN).astype(np.int8)
        dark = shade if self.negate else 1.0 - shade
        between = np.full(len(shade), float(UNKNOWN))
        if self.mode == "scale" and self.occupied_thresh != self.free_thresh:
            span = self.occupied_thresh - self.free_thresh
            between = np.rint((dark - self.free_thresh) / span * 100)
        free = np.where(dark < self.free_thresh, FREE, between)
        return np.where(dark > self.occupied_thresh, OCCUPIED, free).astype(np.int8)


def load_map_yaml(path: Path) -> OccupancyGrid:
    """Read a map from map_server's YAML and the picture that it names.

    Raises:
        MapError: a file is missing, broken or absurd; one line names the file and what is valid.
    """
    try:
        content = read_map_yaml(path)
        image = content.text("image")
        resolution = content.number("resolution")
        x, y, yaw = content.numbers("origin", 3)
        meaning = Meaning(
            mode=content.text("mode", "trinary").lower(),
            negate=content.flag("negate"),
            occupied_thresh=content.number("occupied_thresh"),
            free_thresh=content.number("free_thresh"),
        )
        _check_units(resolution, yaw)
        if meaning.free_thresh > meaning.occupied_thresh:
            raise MapError(
                f"free_thresh is {meaning.free_thresh:g}, above occupied_thresh "
                f"{meaning.occupied_thresh:g}: are they the wrong way round? usual are 0.196 and "
                "0.65"
            )
        cells = _cells(read_picture(_image_of(path, image)), meaning)
        return OccupancyGrid(cells[::-1].copy(), resolution, Pose2(x, y, yaw))
    except MapError as error:
        raise MapError(f"{path}: {error}") from error


def _check_units(resolution: float, yaw: float) -> None:
    """Refuse millimetres and degrees: with them the map would be of another place."""
    if resolution > COARSEST_M:
        raise MapError(
            f"resolution is {resolution} m a pixel; valid is 0.0001 to {COARSEST_M:g}: was it "
            f"given in mm or cm? 50 mm are 0.05"
        )
    if abs(yaw) > MOST_TURN:
        raise MapError(
            f"the third number of origin, the yaw, is {yaw:g} rad; valid is up to 2 pi either way: "
            f"was it given in degrees? those are {math.radians(yaw):.4f}"
        )


def _image_of(path: Path, image: str) -> Path:
    """Return the picture that a map's YAML names, or that of the same name beside the YAML.

    A map that was copied names a path of the computer on which it was made, maybe of Windows.
    """
    named = as_written(path.parent / image)
    beside = as_written(path.parent / PureWindowsPath(image).name)
    with suppress(OSError):  # the name may be too long; reading tells that
        if not named.is_file() and beside.is_file():
            LOG.warning("%s: there is no %s; %s beside it is read", path, image, beside.name)
            return beside
    return named


def save_map_yaml(
    grid: OccupancyGrid, path: Path, meaning: Meaning | None = None, picture: str = ""
) -> None:
    """Write a map as map_server does: a YAML file, and a picture with the same name beside it.

    The picture's kind is pgm or png. The default is png for the mode scale, which needs
    transparency for unknown cells, and otherwise pgm. Only raw keeps every value; trinary keeps -1,
    0 and 100.

    Raises:
        MapError: the kind of picture is unknown, unfit for the mode, or cannot be written; or the
            meaning has ``negate`` or thresholds in the wrong order.
    """
    meaning = meaning or Meaning()
    picture = picture or ("png" if meaning.mode == "scale" else "pgm")
    if picture not in ("pgm", "png") or (picture, meaning.mode) == ("pgm", "scale"):
        raise MapError(f"picture is {picture!r}; valid are pgm and png, and png for scale")
    if meaning.negate or meaning.free_thresh >= meaning.occupied_thresh:
        raise MapError("only maps with negate 0 and free_thresh below occupied_thresh are written")
    image = path.with_suffix(f".{picture}")
    written, encoded = cv2.imencode(image.suffix, _pixels(grid, meaning))
    if not written:
        raise MapError(f"{image}: the picture cannot be encoded")
    content = {
        "image": image.name,
        "mode": meaning.mode,
        "resolution": grid.resolution,
        "origin": [grid.origin.x, grid.origin.y, grid.origin.theta],
        "negate": 0,
        "occupied_thresh": meaning.occupied_thresh,
        "free_thresh": meaning.free_thresh,
    }
    image.write_bytes(encoded.tobytes())
    path.write_text(yaml.safe_dump(content, sort_keys=False, default_flow_style=None), "utf-8")


def _cells(picture: Picture, meaning: Meaning) -> Cells:
    """Return the cells (h, w) of a picture, row 0 at its top.

    A pixel's shade is the mean of its channels; in the mode trinary, alpha is one of them. The sum
    of channels has few possible values, so each value is converted only once.
    """
    channels = (
        [picture.colour] if picture.colour.ndim == 2 else list(np.moveaxis(picture.colour, 2, 0))
    )
    if meaning.mode == "trinary" and picture.alpha is not None:
        channels.append(picture.alpha)
    total = channels[0].astype(np.uint32)
    for channel in channels[1:]:
        total += channel
    count = len(channels)
    possible = np.arange(count * picture.white + 1) / count / picture.white
    cells = meaning.cells(possible)[total]
    if meaning.mode == "scale" and picture.alpha is not None:
        cells[picture.alpha != picture.white] = UNKNOWN
    return cells


def _unknown_tone(meaning: Meaning) -> int:
    """Return the grey level of unknown cells: the usual 205, unless it would be read otherwise."""
    customary = 205
    if meaning.free_thresh <= 1 - customary / 255 <= meaning.occupied_thresh:
        return customary
    return round(255 * (1 - (meaning.free_thresh + meaning.occupied_thresh) / 2))


def _pixels(grid: OccupancyGrid, meaning: Meaning) -> NDArray[np.uint8]:
    """Return the picture of a grid: grey (h, w), or with transparency (h, w, 4) for scale."""
    value = np.arange(UNKNOWN, OCCUPIED + 1)
    if meaning.mode == "raw":
        tone = np.where(value == UNKNOWN, 255, value)
    elif meaning.mode == "scale":
        tone = np.where(value == UNKNOWN, 128, np.rint((100 - value) / 100 * 255))
    else:
        tone = np.full(len(value), _unknown_tone(meaning))
        tone[value >= np.rint(meaning.occupied_thresh * 100)] = 0
        tone[(value != UNKNOWN) & (value <= np.rint(meaning.free_thresh * 100))] = 254
    grey: NDArray[np.uint8] = tone.astype(np.uint8)[grid.data[::-1].astype(np.int16) + 1]
    if meaning.mode != "scale":
        return grey
    alpha = np.where(grid.data[::-1] == UNKNOWN, 0, 255).astype(np.uint8)
    return np.dstack([grey, grey, grey, alpha])
