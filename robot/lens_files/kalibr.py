"""Lenses as Kalibr has them: a camchain."""

from __future__ import annotations

from typing import Any

import numpy as np

from robot.lens_files.choosing import OneCamera, chosen
from robot.lens_files.entries import coefficients, numbers, shown
from robot.lens_files.models import Described

FORM = "Kalibr's camchain"


def cameras_of(content: dict[str, Any]) -> dict[str, dict[str, Any]]:
    """Return the cameras of a camchain by their names; none if it is no camchain."""
    return {
        name: table
        for name, table in content.items()
        if isinstance(table, dict) and "intrinsics" in table and "camera_model" in table
    }


def kalibr_lens(content: dict[str, Any], name: str = "") -> Described:
    """Return the lens of a camchain.

    Args:
        name: of the camera or its topic; needed if there are several.

    Raises:
        SeveralCamerasError: there are several, and none is named, or another one.
        KeyError, ValueError: a key is missing, or has no valid value.
    """
    cameras = {
        key: OneCamera(table, _about(table), (str(table.get("rostopic", "")).strip("/"),))
        for key, table in cameras_of(content).items()
    }
    table = chosen(FORM, cameras, name)
    kind = table["camera_model"]
    if kind != "pinhole":
        # The camera model is what is foreign; its distortion may have a name of ours.
        kind = kind if isinstance(kind, str) else shown(kind)
        return Described(FORM, 1, 1, np.eye(3), np.zeros(0), kind)
    size = numbers(table["resolution"])
    if size is None or len(size) != 2 or (size != np.round(size)).any() or (size < 1).any():
        raise ValueError("resolution needs two whole numbers: width and height")
    place = numbers(table["intrinsics"])
    if place is None or len(place) != 4:
        raise ValueError("intrinsics needs four finite numbers: fu, fv, pu, pv")
    fx, fy, cx, cy = place
    model = table["distortion_model"]
    if not isinstance(model, str):
        raise ValueError(f"distortion_model is {shown(model)}; valid are radtan and equidistant")
    return Described(
        FORM,
        int(min(size[0], 1e9)),
        int(min(size[1], 1e9)),
        np.array([[fx, 0, cx], [0, fy, cy], [0, 0, 1]]),
        coefficients(table.get("distortion_coeffs", []), "distortion_coeffs"),
        model,
    )


def _about(table: dict[str, Any]) -> str:
    """Return a camera's topic and the size of its pictures, as far as they are known."""
    size, topic = table.get("resolution"), table.get("rostopic")
    words = [topic[:60]] if isinstance(topic, str) else []
    if isinstance(size, list) and len(size) == 2:
        words.append(" x ".join(str(side)[:10] for side in size))
    return ", ".join(words)
