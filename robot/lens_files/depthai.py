"""Lenses as DepthAI dumps them from a camera of Luxonis (OAK): ``eepromToJsonFile``."""

from __future__ import annotations

from itertools import chain
from typing import Any

from robot.camera import CameraError
from robot.lens_files.choosing import OneCamera, chosen
from robot.lens_files.entries import coefficients, matrix, shown, whole
from robot.lens_files.models import Described

FORM = "DepthAI's calibration"
MODELS = {
    "0": "pinhole",
    "1": "fisheye",
    "2": "equirectangular",
    "3": "radial_division",
    "4": "cylindrical",
}
"""Its ``cameraType`` by number; the pinhole's coefficients are in OpenCV's order."""
SOCKETS = "ABCDEFGHIJ"


def is_depthai(content: dict[str, Any]) -> bool:
    """Return whether a file is a dump of DepthAI's calibration."""
    return isinstance(content.get("cameraData"), list)


def depthai_lens(content: dict[str, Any], name: str = "") -> Described:
    """Return the lens of a camera in a dump.

    Args:
        name: of the socket, as CAM_A or its number 0; needed if several cameras are calibrated.

    Raises:
        SeveralCamerasError: there are several, and none is named, or another one.
        CameraError: no camera is calibrated.
        KeyError, ValueError: a key is missing, or has no valid value.
    """
    cameras = {
        _socket(pair[0]): OneCamera(pair[1], _about(pair[1]), (str(pair[0]),))
        for pair in content["cameraData"]
        if isinstance(pair, list) and len(pair) == 2 and _is_calibrated(pair[1])
    }
    if not cameras:
        raise CameraError(f"it is {FORM}, in which no camera is calibrated; calibrate it first")
    camera = chosen(FORM, cameras, name)
    kind = camera["cameraType"]
    if kind not in MODELS:
        raise ValueError(f"cameraType is {shown(kind)}; valid are 0 (perspective) and 1 (fisheye)")
    return Described(
        FORM,
        whole(camera, "width"),
        whole(camera, "height"),
        matrix(_flat(camera["intrinsicMatrix"]), "intrinsicMatrix"),
        coefficients(camera["distortionCoeff"], "distortionCoeff"),
        MODELS[kind],
    )


def _socket(number: Any) -> str:
    """Return what DepthAI calls a socket."""
    known = isinstance(number, str) and number.isdecimal() and len(number) == 1
    return f"CAM_{SOCKETS[int(number)]}" if known else shown(number)


def _about(camera: dict[str, Any]) -> str:
    return f"{camera.get('width')!s:.10} x {camera.get('height')!s:.10}"


def _is_calibrated(camera: Any) -> bool:
    rows = _flat(camera.get("intrinsicMatrix")) if isinstance(camera, dict) else []
    return any(value not in ("0", "0.0", "-0.0") for value in rows)


def _flat(rows: Any) -> list[Any]:
    if not isinstance(rows, list):
        return []
    return list(chain.from_iterable(row if isinstance(row, list) else [row] for row in rows))
