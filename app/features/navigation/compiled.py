"""The compiled functions of navigation, with their arguments' types."""

from numba import float32, int64

from app.engine.compiling.functions import Compiled

_COSTS = float32[:, ::1]

COMPILED = (
    Compiled("robot.navigation.grid_search._search", (_COSTS, int64, int64, int64, int64)),
    Compiled("robot.navigation.grid_search._corners", (_COSTS, int64[:, ::1])),
)
