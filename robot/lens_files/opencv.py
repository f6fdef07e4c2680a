"""Lenses as OpenCV's ``FileStorage`` has them, in YAML, XML or JSON."""

from __future__ import annotations

from typing import Any
from xml.etree.ElementTree import Element

from robot.camera import CameraError
from robot.lens_files.entries import coefficients, matrix, shown, whole
from robot.lens_files.models import Described

FORM = "OpenCV's FileStorage"
WIDTHS = ("image_width", "width", "imagewidth")
HEIGHTS = ("image_height", "height", "imageheight")
MATRICES = ("camera_matrix", "cameramatrix", "k", "m", "mtx", "intrinsics", "intrinsic_matrix")
BENDS = (
    "distortion_coefficients", "dist_coeffs", "dist_coeff", "distcoeffs", "d", "dist", "distortion",
)  # fmt: skip
MODELS = ("distortion_model", "camera_model", "model")
"""Names that people give these, in small letters: OpenCV itself fixes none."""


def holds_matrices(content: dict[str, Any]) -> bool:
    """Return whether a file has OpenCV's matrices: unlike ROS's, they name the numbers' type."""
    return any(isinstance(entry, dict) and "dt" in entry for entry in content.values())


def opencv_lens(content: dict[str, Any]) -> Described:
    """Return the lens of a FileStorage's entries.

    Raises:
        KeyError, ValueError: an entry is missing, or has no valid value.
    """
    entries = {key.lower(): entry for key, entry in content.items()}
    wide, high = _key(entries, WIDTHS), _key(entries, HEIGHTS)
    k, d = _key(entries, MATRICES), _key(entries, BENDS)
    if k is None and any(name in entries for name in ("k1", "m1", "cameramatrix1")):
        raise CameraError("it is OpenCV's file of two cameras; valid is one, as camera_matrix")
    for key, valid in ((k, "camera_matrix"), (d, "distortion_coefficients")):
        if key is None:
            raise KeyError(valid)
    if wide is None or high is None:
        raise CameraError(
            "it does not tell the size of the pictures: add lines image_width and image_height [px]"
        )
    return Described(
        FORM,
        whole(entries, wide),
        whole(entries, high),
        matrix(_data(entries[str(k)]), str(k)),
        coefficients(_data(entries[str(d)]), str(d)),
        _model(entries),
    )


def _key(entries: dict[str, Any], names: tuple[str, ...]) -> str | None:
    return next((name for name in names if name in entries), None)


def _data(entry: Any) -> Any:
    return entry.get("data") if isinstance(entry, dict) else None


def _model(entries: dict[str, Any]) -> str | None:
    """Return the model's name; OpenCV's own program writes ``fisheye_model`` 1 or 0."""
    if "fisheye_model" in entries:
        return "fisheye" if entries["fisheye_model"] in ("1", "true") else "pinhole"
    key = _key(entries, MODELS)
    if key is None:
        return None
    if not isinstance(entries[key], str):
        raise ValueError(f"{key} is {shown(entries[key])}; valid is the name of a model")
    return str(entries[key])


def xml_entries(root: Element) -> dict[str, Any]:
    """Return the entries of a FileStorage in XML.

    Raises:
        ValueError: it is no XML of OpenCV.
    """
    if root.tag != "opencv_storage":
        raise ValueError(f"its root is <{root.tag[:40]}>; expected <opencv_storage>")
    return {element.tag: _entry(element) for element in root}


def _entry(element: Element) -> Any:
    if not len(element):
        return (element.text or "").strip().strip('"')
    entry: dict[str, Any] = {part.tag: (part.text or "").strip() for part in element}
    if "data" in entry:
        entry["data"] = entry["data"].split()
    return entry
