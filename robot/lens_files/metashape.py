"""Lenses as Agisoft's Metashape (before: PhotoScan) saves them: a calibration in XML.

Its manual has the formulas in the appendix on camera models. The centre is counted from the middle
of the picture, and a pixel from its corner. What it calls P1 is OpenCV's p2, and P2 OpenCV's p1.
"""

from __future__ import annotations

from xml.etree.ElementTree import Element

import numpy as np

from robot.camera import CameraError
from robot.lens_files.entries import coefficients, whole
from robot.lens_files.models import Described

FORM = "Metashape's calibration"
FISHEYES = ("fisheye", "equidistant_fisheye")
PROJECT = (
    "it is what Metashape exports of all cameras; valid is the calibration alone: Tools, Camera "
    "Calibration, Adjusted, Save"
)
CURE = "save it by Tools, Camera Calibration, Adjusted as OpenCV's, or calibrate without it"


def is_metashape(root: Element) -> bool:
    """Return whether XML is a calibration of Metashape."""
    return root.tag == "calibration" and root.find("projection") is not None


def is_metashape_project(root: Element) -> bool:
    """Return whether XML is an export of Metashape's cameras, or its project."""
    return root.tag == "document" and root.find("chunk") is not None


def metashape_lens(root: Element) -> Described:
    """Return the lens of a calibration.

    Raises:
        CameraError: it has terms that no lens has here.
        KeyError, ValueError: an entry is missing, or has no valid value.
    """
    entries = {element.tag: (element.text or "").strip() for element in root}
    width, height = whole(entries, "width"), whole(entries, "height")
    projection = entries["projection"]
    if projection != "frame" and projection not in FISHEYES:
        return Described(FORM, width, height, np.eye(3), np.zeros(0), projection)
    if "f" not in entries and "fx" in entries:
        raise CameraError("it is of an old PhotoScan (fx, not f): open it in Metashape and save it")

    def values(*keys: str) -> list[float]:
        # What was not fitted is left out.
        return [float(coefficients([entries.get(key, "0")], key)[0]) for key in keys]

    foreign = ["skew", "p3", "p4", *(("p1", "p2") if projection in FISHEYES else ("k4",))]
    used = [key for key, value in zip(foreign, values(*foreign), strict=True) if value]
    if used:
        raise CameraError(f"its lens has {', '.join(used)}, which no lens has here: {CURE}")
    f = float(coefficients([entries["f"]], "f")[0])
    b1, skew, cx, cy = values("b1", "b2", "cx", "cy")
    centre = width / 2 + cx - 0.5, height / 2 + cy - 0.5
    k = np.array([[f + b1, skew, centre[0]], [0, f, centre[1]], [0, 0, 1]])
    if projection in FISHEYES:
        return Described(
            FORM, width, height, k, np.array(values("k1", "k2", "k3", "k4")), "fisheye"
        )
    return Described(
        FORM, width, height, k, np.array(values("k1", "k2", "p2", "p1", "k3")), "pinhole"
    )
