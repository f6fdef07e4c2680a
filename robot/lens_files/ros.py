"""Lenses as ROS has them: ``camera_info`` YAML, the ``.ini`` before it, and a printed message."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from robot.camera import CameraError
from robot.lens_files.entries import coefficients, matrix, number, shown, whole
from robot.lens_files.models import VALID, Described

CAMERA_INFO = "ROS's camera_info"
MESSAGE = "a printed CameraInfo message"
INI = "ROS's .ini"
BENDS, UNDER_DATA = "distortion_coefficients", " under data"


def camera_info_lens(content: dict[str, Any]) -> Described:
    """Return the lens of a ``camera_info`` file.

    Raises:
        KeyError, ValueError: a key is missing, or has no valid value.
    """
    # ROS Melodic's calibration names the model by the second key.
    model = content.get("distortion_model") or content.get("camera_model")
    if not isinstance(model, str | None):
        raise ValueError(f"distortion_model is {shown(model)}; valid are {VALID}")
    return Described(
        CAMERA_INFO,
        whole(content, "image_width"),
        whole(content, "image_height"),
        matrix(_under_data(content["camera_matrix"]), "camera_matrix", UNDER_DATA),
        coefficients(_under_data(content[BENDS]), BENDS, UNDER_DATA),
        model,
    )


def _under_data(entry: Any) -> Any:
    return entry.get("data") if isinstance(entry, dict) else None


def is_message(content: dict[str, Any]) -> bool:
    """Return whether a file holds what ``ros2 topic echo`` or ``rostopic echo`` prints."""
    return ("k" in content or "K" in content) and ("d" in content or "D" in content)


def message_lens(content: dict[str, Any]) -> Described:
    """Return the lens of a CameraInfo message, of ROS 2 (``k``, ``d``) or ROS 1 (``K``, ``D``).

    Raises:
        KeyError, ValueError: a key is missing, or has no valid value.
    """
    for key in ("binning_x", "binning_y"):
        if content.get(key, "0") not in ("0", "1"):
            raise CameraError(f"{key} is {shown(content[key])}; valid is a camera without binning")
    width, height = whole(content, "width"), whole(content, "height")
    roi = content.get("roi")
    if isinstance(roi, dict):
        whole_picture = {
            "x_offset": "0",
            "y_offset": "0",
            "width": f"{width}",
            "height": f"{height}",
        }
        if any(roi.get(key, "0") not in ("0", full) for key, full in whole_picture.items()):
            raise CameraError("its pictures are a part (roi) of the camera's; valid are whole ones")
    k = matrix(content["k" if "k" in content else "K"], "k")
    if not k.any():
        raise CameraError("the camera was not calibrated (k is zero): calibrate it first")
    d = coefficients(content["d" if "d" in content else "D"], "d")
    model = content.get("distortion_model")
    return Described(MESSAGE, width, height, k, d, model if isinstance(model, str) else None)


def is_ini(lines: list[str]) -> bool:
    """Return whether lines are of a ``.ini`` (or ``ost.txt``) of ROS's camera calibration."""
    return "[image]" in lines and "camera matrix" in lines


def ini_lens(lines: list[str]) -> Described:
    """Return the lens of a ``.ini``.

    Raises:
        KeyError, ValueError: a part is missing, or has no valid value.
    """
    if lines.count("camera matrix") > 1:
        raise CameraError("it describes several cameras; valid is one: remove the others' lines")
    parts = {name: list(_words_after(lines, name)) for name in
             ("width", "height", "camera matrix", "distortion")}  # fmt: skip
    for name, words in parts.items():
        if not words:
            raise KeyError(name)
    size = {name: parts[name][0] for name in ("width", "height")}
    bends = coefficients(parts["distortion"], "distortion")
    if len(bends) == 4:
        raise CameraError(
            "4 coefficients of distortion in a .ini, which names no model: is it a fisheye lens? "
            "valid are 5 of plumb_bob, or the .yaml of the same calibration"
        )
    k = matrix(parts["camera matrix"], "camera matrix")
    return Described(INI, whole(size, "width"), whole(size, "height"), k, bends, None)


def _words_after(lines: list[str], name: str) -> Iterator[str]:
    """Yield the words that follow a name, as far as they are numbers."""
    if name not in lines:
        return
    for line in lines[lines.index(name) + 1 :]:
        words = line.split()
        if not np.isfinite([number(word) for word in words]).all():
            return
        yield from words
