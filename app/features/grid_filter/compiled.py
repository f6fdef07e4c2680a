"""The compiled functions of the grid filter, with their arguments' types."""

from numba import float64, int64

from app.engine.compiling.functions import Compiled

_F1, _I1, _I2 = float64[::1], int64[::1], int64[:, ::1]

COMPILED = (
    Compiled("robot.localization.grid.grid_motion._share", (_I2, _F1, int64, _I1, float64[:, :])),
    Compiled("robot.localization.grid.pose_grid.sum_alike", (_I2, _F1)),
)
