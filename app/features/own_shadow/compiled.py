"""The compiled function that follows returns, with its arguments' types."""

from numba import boolean, float64, int64
from numba.core.types import NamedTuple, UniTuple

from app.engine.compiling.functions import Compiled
from robot.scan_checks.still_returns import FollowedRays

_F1, _I1, _POSE = float64[::1], int64[::1], UniTuple(float64, 3)
_FOLLOWED = NamedTuple((_F1, boolean[::1], _I1, _I1, _F1, _F1, _F1), FollowedRays)

COMPILED = (
    Compiled(
        "robot.scan_checks.still_returns._follow",
        (_FOLLOWED, float64[:, ::1], _POSE, _POSE, int64),
    ),
)
