"""Lenses as COLMAP has them: a line of ``cameras.txt``.

Its pixels are counted from the corner of the picture, so that the centre of the first one is at
(0.5, 0.5).
"""

from __future__ import annotations

import re

import numpy as np

from robot.lens_files.choosing import OneCamera, chosen
from robot.lens_files.entries import coefficients
from robot.lens_files.models import Described

FORM = "COLMAP's cameras.txt"
PINHOLES = {
    "SIMPLE_PINHOLE": "f cx cy",
    "PINHOLE": "fx fy cx cy",
    "SIMPLE_RADIAL": "f cx cy k1",
    "RADIAL": "f cx cy k1 k2",
    "OPENCV": "fx fy cx cy k1 k2 p1 p2",
    "FULL_OPENCV": "fx fy cx cy k1 k2 p1 p2 k3 k4 k5 k6",
}
FISHEYES = {
    "SIMPLE_FISHEYE": "f cx cy",
    "FISHEYE": "fx fy cx cy",
    "SIMPLE_RADIAL_FISHEYE": "f cx cy k1",
    "RADIAL_FISHEYE": "f cx cy k1 k2",
    "OPENCV_FISHEYE": "fx fy cx cy k1 k2 k3 k4",
}
"""The parameters of each model; the bends are in OpenCV's order."""
CURE = "run COLMAP with --ImageReader.camera_model OPENCV, or OPENCV_FISHEYE for a wide lens"
BINARY = (
    "it is COLMAP's cameras.bin; valid is cameras.txt, which `colmap model_converter --output_type "
    "TXT` writes"
)

_ROW = re.compile(r"(\d+)\s+([A-Z][A-Z0-9_]+)\s+(\d{1,9})\s+(\d{1,9})((?:\s+\S+)+)")


def is_colmap(lines: list[str]) -> bool:
    """Return whether lines without comments are those of ``cameras.txt``."""
    return _ROW.fullmatch(next(filter(None, lines), "")) is not None


def is_colmap_binary(data: bytes) -> bool:
    """Return whether bytes are the beginning of ``cameras.bin``."""
    if len(data) < 32:
        return False
    numbers = [int.from_bytes(data[start:end], "little") for start, end in
               ((0, 8), (12, 16), (16, 24), (24, 32))]  # fmt: skip
    count, model, width, height = numbers
    return 0 < count < 1e6 and model < 32 and 0 < width < 1e5 and 0 < height < 1e5


def colmap_lens(lines: list[str], name: str = "") -> Described:
    """Return the lens of a camera in ``cameras.txt``.

    Args:
        name: the camera's number; needed if there are several.

    Raises:
        SeveralCamerasError: there are several, and none is named, or another one.
        ValueError: a line has no valid values.
    """
    cameras = {}
    for line in filter(None, lines):
        row = _ROW.fullmatch(line)
        if row is None:
            raise ValueError(
                f"{line[:60]!r} is no camera of COLMAP; valid is: number, model, width, height, "
                "parameters"
            )
        cameras[row[1]] = OneCamera(row, f"{row[2]}, {row[3]} x {row[4]}")
    row = chosen(FORM, cameras, name)
    _, model, width, height, words = row.groups()
    size = int(width), int(height)
    names = (PINHOLES | FISHEYES).get(model)
    if names is None:
        return Described(FORM, *size, np.eye(3), np.zeros(0), model, CURE)
    values = coefficients(words.split(), f"the parameters of {model}").tolist()
    if len(values) != len(names.split()):
        raise ValueError(f"{len(values)} parameters of {model}; valid are {names}")
    fx, *rest = values
    fy, cx, cy, *bends = rest if names.startswith("fx") else (fx, *rest)
    bends += [0.0] * (4 - len(bends))
    kind = "equidistant" if model in FISHEYES else "pinhole"
    k = np.array([[fx, 0, cx - 0.5], [0, fy, cy - 0.5], [0, 0, 1]])
    return Described(FORM, *size, k, np.array(bends), kind)
