"""The compiled function of expected ranges, with its arguments' types."""

from numba import float64, int64

from app.engine.compiling.functions import EDGES, Compiled

_F1, _F2 = float64[::1], float64[:, ::1]

COMPILED = (
    Compiled("robot.misplaced_tape.tracker._expect", (_F1, _F2, EDGES, float64, _F1, int64[::1])),
)
