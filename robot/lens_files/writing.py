"""Writes a lens for other programs: OpenCV, Kalibr, and ROS's old ``.ini``."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from robot.camera import Lens
from robot.geometry import Array


@dataclass(frozen=True)
class Format:
    """A kind of file that a lens can be written as."""

    title: str
    models: tuple[str, ...]
    """The lens models that it can hold."""
    suffixes: tuple[str, ...]
    write: Callable[[Lens], str]
    """Makes the text of the file."""


def opencv_text(lens: Lens) -> str:
    """Return the lens as OpenCV's ``FileStorage`` in YAML, with the names of OpenCV's samples."""
    lines = [
        "%YAML:1.0",
        "---",
        f"image_width: {lens.width}",
        f"image_height: {lens.height}",
        *_opencv_matrix("camera_matrix", lens.matrix),
        *_opencv_matrix("distortion_coefficients", lens.distortion[:, None]),
        f"fisheye_model: {int(lens.model == 'equidistant')}",
    ]
    return "\n".join(lines) + "\n"


def _opencv_matrix(name: str, values: Array) -> list[str]:
    rows, columns = values.shape
    return [
        f"{name}: !!opencv-matrix",
        f"   rows: {rows}",
        f"   cols: {columns}",
        "   dt: d",
        f"   data: [ {_listed(values)} ]",
    ]


def kalibr_text(lens: Lens) -> str:
    """Return the lens as Kalibr's camchain of one camera."""
    (fx, _, cx), (_, fy, cy), _ = lens.matrix
    lines = [
        "cam0:",
        "  cam_overlaps: []",
        "  camera_model: pinhole",
        f"  distortion_coeffs: [{_listed(lens.distortion)}]",
        f"  distortion_model: {lens.model}",
        f"  intrinsics: [{_listed(np.array([fx, fy, cx, cy]))}]",
        f"  resolution: [{lens.width}, {lens.height}]",
        "  rostopic: /camera/image_raw",
    ]
    return "\n".join(lines) + "\n"


def ini_text(lens: Lens) -> str:
    """Return the lens as the ``.ini`` of ROS's camera_calibration_parsers."""
    projection = np.column_stack([lens.matrix, np.zeros(3)])
    parts = {
        "camera matrix": lens.matrix,
        "distortion": lens.distortion[None],
        "rectification": np.eye(3),
        "projection": projection,
    }
    lines = [
        "[image]",
        "",
        "width",
        f"{lens.width}",
        "",
        "height",
        f"{lens.height}",
        "",
        "[camera]",
    ]
    for name, values in parts.items():
        lines += ["", name, *(_listed(row, " ") for row in values)]
    return "\n".join(lines) + "\n"


def _listed(values: Array, between: str = ", ") -> str:
    return between.join(repr(float(value)) for value in values.ravel())


OPENCV = Format(
    "OpenCV's FileStorage",
    ("plumb_bob", "equidistant", "rational_polynomial"),
    (".yaml", ".yml"),
    opencv_text,
)
KALIBR = Format("Kalibr's camchain", ("equidistant",), (".yaml", ".yml"), kalibr_text)
"""Kalibr's radtan is plumb_bob without k3, which calibrations here always fit."""
INI = Format("ROS's .ini", ("plumb_bob",), (".ini", ".txt"), ini_text)
FORMATS = {"opencv": OPENCV, "kalibr": KALIBR, "ini": INI}
"""Formats by name, besides ROS's ``camera_info``."""
