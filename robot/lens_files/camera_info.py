"""Writes a lens as ROS's ``camera_info`` YAML, which ``read_lens_file`` reads."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from robot.camera import Lens
from robot.geometry import Array


def camera_info(lens: Lens, sd: Array | None = None, title: str = "") -> str:
    """Return the content of the file.

    Args:
        lens: the lens.
        sd: (p,) standard deviations of what ``Lens.parameters`` lists; BrickPose's own key.
        title: lines of comment.
    """
    projection = np.column_stack([lens.matrix, np.zeros(3)])
    lines = [
        *(f"# {line}" for line in title.splitlines()),
        f"image_width: {lens.width}",
        f"image_height: {lens.height}",
        "camera_name: camera",
        *_matrix("camera_matrix", lens.matrix),
        f"distortion_model: {lens.model}",
        *_matrix("distortion_coefficients", lens.distortion[None]),
        *_matrix("rectification_matrix", np.eye(3)),
        *_matrix("projection_matrix", projection),
    ]
    if lens.readout > 0:
        lines.append(f"rolling_shutter_readout: {lens.readout!r}")
    if sd is not None:
        lines.append("# Ours; ROS leaves it alone: standard deviations.")
        lines.append("parameter_sd:")
        named = zip(lens.parameters, sd.tolist(), strict=True)
        lines += [f"  {name}: {value!r}" for name, value in named]
    return "\n".join(lines) + "\n"


def parameter_sd(keys: Mapping[str, Any], lens: Lens) -> Array | None:
    """Return the standard deviations (p,) in a lens's file; None if they are not in it."""
    table = keys.get("parameter_sd", {})
    try:
        values = np.array([float(table[name]) for name in lens.parameters])
    except (KeyError, TypeError, ValueError):
        return None
    return values if (np.isfinite(values) & (values >= 0)).all() else None


def _matrix(key: str, values: Array) -> list[str]:
    rows, columns = values.shape
    data = ", ".join(repr(float(value)) for value in values.ravel())
    return [f"{key}:", f"  rows: {rows}", f"  cols: {columns}", f"  data: [{data}]"]
