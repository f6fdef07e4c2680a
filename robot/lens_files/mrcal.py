"""Lenses as mrcal has them: a ``.cameramodel``, which is a dictionary in Python's notation."""

from __future__ import annotations

from typing import Any

import numpy as np

from robot.lens_files.entries import numbers, shown
from robot.lens_files.models import Described
from robot.yaml_file import parse_yaml

FORM = "mrcal's cameramodel"
BENDS = {"PINHOLE": 0, "OPENCV4": 4, "OPENCV5": 5, "OPENCV8": 8, "OPENCV12": 12}
"""Models that are OpenCV's, and how many coefficients they have."""
CURE = "`mrcal-convert-lensmodel LENSMODEL_OPENCV8` writes one that is"
PREFIX = "LENSMODEL_"

_REST = "'optimization_inputs'"
"""The last key: all pictures of the calibration, often of megabytes."""


def without_pictures(data: bytes) -> bytes:
    """Return a file without the inputs of its calibration; other files as they are."""
    begin, rest, _ = data.partition(_REST.encode())
    return begin + b"}" if rest and PREFIX.encode() in begin else data


def is_mrcal(text: str) -> bool:
    """Return whether a text is a ``.cameramodel``."""
    return "'lensmodel'" in text and PREFIX in text


def mrcal_lens(text: str) -> Described:
    """Return the lens of a ``.cameramodel``.

    Raises:
        KeyError, ValueError: a key is missing, or has no valid value.
    """
    # Its notation of numbers, texts and lists is that of YAML, too.
    content: Any = parse_yaml(text)
    if not isinstance(content, dict):
        raise ValueError(f"it is {FORM}, of which no key can be read")
    name = content["lensmodel"]
    if not (isinstance(name, str) and name.startswith(PREFIX)):
        raise ValueError(f"lensmodel is {shown(name)}; valid is as LENSMODEL_OPENCV8")
    size = numbers(content["imagersize"])
    if size is None or len(size) != 2 or (size != np.round(size)).any() or (size < 1).any():
        raise ValueError("imagersize needs two whole numbers: width and height")
    width, height = (int(min(side, 1e9)) for side in size)
    model = name.removeprefix(PREFIX).partition("_order=")[0].partition("_linearity=")[0]
    if model not in BENDS:
        return Described(FORM, width, height, np.eye(3), np.zeros(0), model, CURE)
    values = numbers(content["intrinsics"])
    if values is None or len(values) != 4 + BENDS[model]:
        raise ValueError(f"intrinsics needs {4 + BENDS[model]} finite numbers for {name}")
    fx, fy, cx, cy = values[:4]
    k = np.array([[fx, 0, cx], [0, fy, cy], [0, 0, 1]])
    return Described(FORM, width, height, k, values[4:], "pinhole")
