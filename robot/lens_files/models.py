"""What other programs call the models of lenses, and how many coefficients they write."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from robot.camera import CameraError, Lens
from robot.geometry import Array

NAMES = {
    "plumb_bob": ("plumb_bob", "pinhole", "radtan", "radial-tangential", "brown", "brown_conrady"),
    "rational_polynomial": ("rational_polynomial", "rational"),
    "equidistant": ("equidistant", "equi", "fisheye", "kannala_brandt", "kannala_brandt4"),
}
"""The models, and their names in files."""
FOREIGN = {
    "ds": "Kalibr's double sphere",
    "double_sphere": "the double sphere",
    "eucm": "Kalibr's extended unified camera",
    "omni": "Kalibr's unified camera (Mei)",
    "mei": "the unified camera (Mei)",
    "fov": "the field of view (Devernay and Faugeras)",
    "inverse_brown_conrady": "RealSense's inverse of Brown's formula",
    "modified_brown_conrady": "RealSense's variety of Brown's formula",
    "thin_prism_fisheye": "a fisheye with a thin prism",
    "ftheta": "NVIDIA's polynomial of the angle",
    "scaramuzza": "OCamCalib's polynomial",
    "rad_tan_thin_prism_fisheye": "a fisheye with a thin prism",
    "division": "the division model",
    "simple_division": "the division model",
    "radial_division": "the division model",
    "equirectangular": "a picture unrolled from a sphere",
    "spherical": "a picture unrolled from a sphere",
    "cylindrical": "a picture unrolled from a cylinder",
    "equisolid_fisheye": "a fisheye that keeps areas",
    "splined_stereographic": "mrcal's splines",
    "stereographic": "a fisheye that keeps angles",
    "cahvor": "CAHVOR",
    "cahvore": "CAHVOR of a fisheye",
}
"""Models that are not here, and what they are."""
COUNTS = (0, 4, 5, 8, 12, 14)
"""How many coefficients OpenCV's pinhole has: 4 are k1, k2, p1, p2, and no k3."""
VALID = "plumb_bob (radtan), rational_polynomial, equidistant (fisheye)"


@dataclass(frozen=True, eq=False)
class Described:
    """A lens as a file describes it."""

    form: str
    """What kind of file it is, for people."""
    width: int
    height: int
    matrix: Array = field(repr=False)
    """(3, 3)"""
    coefficients: Array = field(repr=False)
    """(n,) as the file has them."""
    model: str | None = None
    """Its name in the file; None if the file names none."""
    cure: str = "calibrate it with one of them, or by brickpose calibrate lens"
    """What to do if the model is not one of ours."""


def lens_of(described: Described, readout: float = 0.0) -> tuple[Lens, tuple[str, ...]]:
    """Return the lens, and what people should know of how it was read.

    Raises:
        CameraError: the model is not one of ours, or a value is impossible; says what is valid.
    """
    model, remarks = _model(described)
    if model == "equidistant":
        used = _fisheye(described.coefficients)
    else:
        used = _pinhole(described.coefficients)
        if model == "plumb_bob" and used[5:].any():
            model = "rational_polynomial"
            if described.model != "pinhole":
                remarks.append(
                    "8 coefficients are more than plumb_bob has: it is read as "
                    "rational_polynomial, as OpenCV does"
                )
        used = used[:5] if model == "plumb_bob" else used
    size = described.width, described.height
    lens = Lens(*size, described.matrix, used, readout=readout, model=model)
    return lens, tuple(remarks)


def _model(described: Described) -> tuple[str, list[str]]:
    """Return which of the models a lens has, and remarks."""
    if described.model is None or described.model.strip().lower() in ("", "none"):
        if described.model is None and len(described.coefficients) == 4:
            return "plumb_bob", [
                "it has 4 coefficients and names no model: they are read as k1, k2, p1, p2 of "
                "plumb_bob; for a fisheye lens, add the line distortion_model: equidistant"
            ]
        return "plumb_bob", []
    name = described.model.strip().lower().replace(" ", "_")
    for model, names in NAMES.items():
        if name in names:
            return model, []
    words = f" ({FOREIGN[name]})" if name in FOREIGN else ""
    raise CameraError(
        f"its lens has the model {described.model[:40]!r}{words}, which is not among ours; valid "
        f"are {VALID}: {described.cure}"
    )


def _fisheye(given: Array) -> Array:
    if len(given) < 4 or given[4:].any():
        raise CameraError(
            f"{len(given)} coefficients of an equidistant (fisheye) lens; valid are 4: k1 to k4"
        )
    return given[:4]


def _pinhole(given: Array) -> Array:
    """Return the eight coefficients of Brown's formula."""
    if len(given) not in COUNTS:
        raise CameraError(
            f"{len(given)} coefficients of distortion; valid are 4 or 5 of plumb_bob, 8 of "
            "rational_polynomial, 4 of equidistant"
        )
    if given[8:].any():
        raise CameraError(
            "its coefficients have a thin prism or a tilted sensor (OpenCV's numbers 9 to 14), "
            f"which no lens has here; valid are {VALID}: calibrate without those flags"
        )
    result = np.zeros(8)
    result[: min(len(given), 8)] = given[:8]
    return result
