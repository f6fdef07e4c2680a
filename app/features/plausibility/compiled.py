"""The compiled function of the overlay of scans, with its arguments' types."""

from numba import float64

from app.engine.compiling.functions import Compiled

_POINTS = float64[:, ::1]

COMPILED = (
    Compiled("robot.scan_checks.overlay._misfit", (_POINTS, float64, float64, float64, _POINTS)),
)
