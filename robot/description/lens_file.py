"""Reads the lens file beside a robot's description: ours, or by the readers that features add."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import yaml

from robot.camera import CameraError, Lens
from robot.distortion import COEFFICIENTS
from robot.errors import one_line
from robot.geometry import Array
from robot.hooks import added
from robot.yaml_file import parse_yaml

LARGEST_BYTES = 64 << 10
"""Largest file: reading YAML takes seconds for each megabyte."""


def read_lens(path: Path) -> Lens:
    """Return the lens of a file: ROS's ``camera_info``, as we write it, or what features read.

    ``rolling_shutter_readout`` [s] is a key of BrickPose.

    Raises:
        CameraError: the file cannot be read, or nobody reads its kind; the message names it.
    """
    try:
        return _camera_info(path)
    except KeyError as error:
        reason = f"the key {error} is missing"
    except (OSError, TypeError, ValueError, RecursionError, yaml.YAMLError) as error:
        reason = one_line(str(error))
    refusals = []
    for read in added().lens_files:
        try:
            lens: Lens = read(path)
        except CameraError as error:
            refusals.append(error)
        else:
            return lens
    raise (refusals or [_refusal(path, reason)])[0]


def _refusal(path: Path, reason: str) -> CameraError:
    models = ", ".join(COEFFICIENTS)
    return CameraError(
        f"{path}: {reason}; valid is ROS's camera_info in YAML, with all coefficients of {models}"
        f"{added().without}"
    )


def _camera_info(path: Path) -> Lens:
    with path.open("rb") as file:
        data = file.read(LARGEST_BYTES + 1)
    if len(data) > LARGEST_BYTES:
        raise ValueError(f"it is too large; valid are up to {LARGEST_BYTES} bytes")
    content = parse_yaml(data.decode("utf-8-sig"))
    if not isinstance(content, dict):
        raise TypeError("expected the keys of a camera file")
    return Lens(
        _whole(content["image_width"]),
        _whole(content["image_height"]),
        _numbers(content["camera_matrix"]).reshape(3, 3),
        _numbers(content["distortion_coefficients"]),
        readout=float(content.get("rolling_shutter_readout", "0")),
        model=content["distortion_model"],
    )


def _whole(text: Any) -> int:
    if not (isinstance(text, str) and text.isdecimal()):
        raise ValueError("image_width and image_height need a whole number")
    return int(text)


def _numbers(table: Any) -> Array:
    values = table["data"]
    if not isinstance(values, list):
        raise TypeError("camera_matrix and distortion_coefficients need a list under data")
    numbers = np.array([float(value) for value in values])
    if not np.isfinite(numbers).all():
        raise ValueError("camera_matrix and distortion_coefficients need finite numbers")
    return numbers
