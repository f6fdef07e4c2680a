"""The compiled functions of navigation, with their arguments' types."""

from numba import boolean, float32, float64, int64
from numba.core.types import NamedTuple as Named

from app.engine.compiling.functions import Compiled
from robot.navigation.lattice import Ground

_COSTS, _ROW = float32[:, ::1], float64[::1]
_TABLE = float64[:, ::1]
_GROUND = Named((_COSTS, *[float64] * 3, _TABLE, *[float64] * 3, _COSTS, float64), Ground)

COMPILED = (
    Compiled("robot.navigation.grid_search._search", (_COSTS, int64, int64, int64, int64)),
    Compiled("robot.navigation.grid_search._corners", (_COSTS, int64[:, ::1])),
    Compiled("robot.navigation.lattice._ways_left", (_COSTS, int64, int64)),
    Compiled("robot.navigation.lattice._hybrid", (_GROUND, _ROW, _ROW)),
    Compiled("robot.navigation.place_kernels.scores", (_TABLE, _TABLE, _TABLE, _COSTS, _ROW, _ROW)),
    Compiled("robot.navigation.place_kernels.rooms", (_TABLE, _TABLE, _COSTS, _ROW)),
    Compiled(
        "robot.navigation.place_kernels.reaches",
        (_TABLE, _TABLE, _TABLE, boolean[:, ::1], _COSTS, _ROW, float64),
    ),
    Compiled("robot.navigation.place_kernels.steps_clear", (_TABLE, _TABLE, _TABLE, float64)),
    Compiled("robot.navigation.place_kernels.ranges_from", (_TABLE, _ROW, _ROW, _COSTS, _ROW)),
)
