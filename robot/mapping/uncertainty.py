"""How uncertain the nodes of a map's strokes are."""

from __future__ import annotations

import numpy as np

from robot.calibration.adjustment import Solution, residual_sd
from robot.description.unknowns import COUNT
from robot.geometry import Array
from robot.mapping.strokes import Strokes

LEAST_FACTOR = 0.5
"""Errors of the camera do not shrink with the picture's noise: the deviations that were expected
are lowered to this share at most."""
CURVE_SD = 0.0004
"""Standard deviation of an edge that bends, beside the noise [m]: it is found as if it were
straight over some centimetres, in all pictures alike."""


def node_sd(strokes: Strokes, solution: Solution) -> Array:
    """Return how uncertain each node (n,) is across its stroke [m], in the robot's first frame.

    The covariance of the adjustment, by the variance factor of what was seen.
    """
    factor = max(LEAST_FACTOR, residual_sd(solution.misses))
    variances = factor**2 * np.diag(solution.covariance)[COUNT:]
    curved = np.repeat(
        [stroke.curved for stroke in strokes.traced],
        [len(stroke.nodes) for stroke in strokes.traced],
    )
    sd: Array = np.sqrt(variances + np.where(curved, CURVE_SD**2, 0.0))
    return sd
