"""Reads the two files of a ROS map, the YAML and the picture, which may contain anything.

Sizes are read from headers and checked before anything is decoded.
"""

from __future__ import annotations

import re
import struct
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import yaml
from numpy.typing import NDArray

from robot.fields.occupancy_grid import MAX_CELLS, MapError
from robot.lfs_pointer import is_lfs_pointer
from robot.yaml_file import parse_yaml

MAX_YAML_BYTES = 64 << 10
MAX_PICTURE_BYTES = 256 << 20
MAX_PIXELS = MAX_CELLS
PICTURES = (".pgm", ".ppm", ".png", ".bmp", ".jpg", ".jpeg", ".tif", ".tiff")
SAVED_BY = {
    ".posegraph": "slam_toolbox",
    ".data": "slam_toolbox",
    ".pbstream": "Cartographer",
    ".db": "RTAB-Map",
    ".bt": "OctoMap",
}
"""Endings of files that are no maps of cells, with who writes them."""
MAX_SIDE = 32_000
"""Largest side [px]: OpenCV's transforms take no more."""


@dataclass(frozen=True, slots=True)
class MapYaml:
    """The keys of a map's YAML, still as text: so ``1e-2`` is a number, as in yaml-cpp."""

    content: dict[str, Any]

    def text(self, key: str, default: str | None = None) -> str:
        """Return a text that is not empty."""
        value = self.content.get(key, default)
        if value is None:
            raise MapError(f"the key {key} is missing")
        if not isinstance(value, str) or not value or "\0" in value:
            raise MapError(f"{key} is {_shown(value)}; valid is a text")
        return value

    def number(self, key: str) -> float:
        """Return a finite number."""
        return _number(key, self.text(key))

    def numbers(self, key: str, count: int) -> list[float]:
        """Return a list of ``count`` finite numbers."""
        values = self.content.get(key)
        if not isinstance(values, list) or len(values) != count:
            raise MapError(f"{key} is {_shown(values)}; valid is a list of {count} numbers")
        return [_number(key, value) for value in values]

    def flag(self, key: str) -> bool:
        """Return a truth value, which may be written as a whole number: 0 is false."""
        value = self.text(key)
        if re.fullmatch(r"[+-]?\d{1,9}", value):
            return int(value) != 0
        if value.lower() in ("true", "yes", "on", "y", "false", "no", "off", "n"):
            return value.lower() in ("true", "yes", "on", "y")
        raise MapError(f"{key} is {_shown(value)}; valid are 0, 1, false, true")


@dataclass(frozen=True, slots=True, eq=False)
class Picture:
    """A picture with its full range of brightness."""

    colour: NDArray[np.uint8 | np.uint16] = field(repr=False)
    """(h, w) grey or (h, w, 3); row 0 at the top."""
    alpha: NDArray[np.uint8 | np.uint16] | None = field(repr=False)
    """(h, w), ``white`` where opaque; None if the picture has no transparency."""
    white: int
    """The brightest possible value."""


def read_map_yaml(path: Path) -> MapYaml:
    """Read a map's YAML, without interpreting its keys.

    Raises:
        MapError: there is no such file, or it is not a mapping in YAML.
    """
    if path.is_dir():
        held = ", ".join(sorted(file.name for file in path.glob("*.yaml"))[:5]) or "none"
        raise MapError(f"it is a folder; valid is a map's YAML, of which it has {held}")
    if path.suffix.lower() in PICTURES:
        raise MapError("it is a picture; valid is the map's YAML, which names it")
    if path.suffix in SAVED_BY:
        raise MapError(
            f"it is what {SAVED_BY[path.suffix]} keeps of a map; valid is a map's YAML: ros2 run "
            "nav2_map_server map_saver_cli saves one"
        )
    try:
        content = parse_yaml(_read(path, MAX_YAML_BYTES))
    except (yaml.YAMLError, UnicodeError, RecursionError, ValueError) as error:
        if isinstance(error, MapError):
            raise
        reason = str(getattr(error, "problem", None) or type(error).__name__)
        raise MapError(f"no readable YAML: {reason}") from error
    if not isinstance(content, dict):
        raise MapError("expected the keys of a map: image, resolution, origin, ...")
    return MapYaml(content)


def read_picture(path: Path) -> Picture:
    """Read a PGM, PPM, PNG or BMP; the content decides the kind, not the name.

    Raises:
        MapError: there is no such file, or it is of another kind, too large or damaged.
    """
    try:
        data = _read(path, MAX_PICTURE_BYTES)
        if re.match(rb"P[2356]\s", data):
            return _read_netpbm(data)
        if data.startswith(b"\x89PNG\r\n\x1a\n"):
            _check_size(*_unpack(">II", data, 16))
        elif data.startswith(b"BM"):
            core = _unpack("<I", data, 14) == (12,)
            width, height = _unpack("<HH" if core else "<ii", data, 18)
            _check_size(width, abs(height))
        else:
            raise MapError("no picture of a known kind; valid are PGM, PPM, PNG and BMP")
        return _decode(data)
    except MapError as error:
        shown = str(path) if len(str(path)) <= 200 else f"...{str(path)[-200:]}"
        raise MapError(f"the image {shown}: {error}") from error


def _read(path: Path, limit: int) -> bytes:
    try:
        if not path.is_file():
            raise MapError("there is no such file")
        if path.stat().st_size > limit:
            raise MapError(f"the file has {path.stat().st_size} bytes; valid are up to {limit}")
        data = path.read_bytes()
    except OSError as error:
        raise MapError(f"the file cannot be read: {error.strerror}") from error
    if is_lfs_pointer(data):
        raise MapError("it is where Git LFS keeps the file, not the file; git lfs pull gets it")
    return data


def _number(key: str, value: object) -> float:
    # Only decimal numbers are valid here, not hexadecimal ones, underscores or inf.
    if not isinstance(value, str) or not re.fullmatch(r"[+-]?[\d.]+(?:[eE][+-]?\d{1,3})?", value):
        raise MapError(f"{key} is {_shown(value)}; valid is a finite number")
    try:
        return float(value)
    except ValueError as error:
        raise MapError(f"{key} is {_shown(value)}; valid is a finite number") from error


def _shown(value: object) -> str:
    text = repr(value)
    return text if len(text) <= 60 else f"{text[:60]}..."


def _unpack(layout: str, data: bytes, offset: int) -> tuple[Any, ...]:
    try:
        return struct.unpack_from(layout, data, offset)
    except struct.error as error:
        raise MapError("the picture ends within its header") from error


def _check_size(width: int, height: int) -> None:
    if not (1 <= width <= MAX_SIDE and 1 <= height <= MAX_SIDE and width * height <= MAX_PIXELS):
        raise MapError(
            f"the picture is {width} x {height} px; valid are 1 to {MAX_SIDE} a side "
            f"and {MAX_PIXELS} in all"
        )


def _read_netpbm(data: bytes) -> Picture:
    """Read a grey map (P5, P2) or a colour map (P6, P3), binary or in digits.

    OpenCV would lose the file's brightest value.
    """
    gap = rb"(?:\s|#[^\n\r]*[\n\r])+"
    header = re.match(rb"P([2356])" + 3 * (gap + rb"(\d{1,9})") + rb"\s", data)
    if header is None:
        raise MapError("the picture's PGM header is damaged")
    kind, width, height, white = (int(number) for number in header.groups())
    _check_size(width, height)
    if not 1 <= white <= 65535:
        raise MapError(f"the brightest value of the PGM is {white}; valid is 1 to 65535")
    in_digits, channels = kind in (2, 3), 3 if kind in (3, 6) else 1
    values = _digits(data[header.end() :]) if in_digits else data[header.end() :]
    number = np.dtype(">u2" if white > 255 or in_digits else "u1")
    count = width * height * channels
    if len(values) < count * number.itemsize:
        raise MapError(f"the picture holds too little for {width} x {height} px")
    shape = (height, width) if channels == 1 else (height, width, channels)
    colour = np.frombuffer(values, number, count).reshape(shape)
    return Picture(np.minimum(colour, white).astype(number.newbyteorder("=")), None, white)


def _digits(data: bytes) -> bytes:
    """Convert numbers in digits to big-endian 16-bit numbers."""
    try:
        return np.array(data.split(), dtype=np.int64).astype(">u2").tobytes()
    except (ValueError, OverflowError) as error:
        raise MapError("the picture's PGM digits are damaged") from error


def _decode(data: bytes) -> Picture:
    try:
        image: Any = cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_UNCHANGED)
    except cv2.error as error:
        raise MapError(f"the picture is damaged: {error.err}") from error
    if image is None or image.dtype not in (np.uint8, np.uint16):
        raise MapError("the picture is damaged")
    white = int(np.iinfo(image.dtype).max)
    if image.ndim == 2:
        return Picture(image, None, white)
    alpha = image[:, :, 3] if image.shape[2] == 4 else None
    # A BMP's fourth byte is usually unused instead of alpha, and then it is 0 throughout.
    if alpha is not None and data.startswith(b"BM") and not alpha.any():
        alpha = None
    return Picture(image[:, :, :3], alpha, white)
