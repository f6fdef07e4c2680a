"""The compiled functions of the picture's odometer, with their arguments' types."""

from numba import float32, float64, int64

from app.engine.compiling.functions import Compiled

_PATCH, _GREY = float32[:, :, ::1], float32[:, ::1]
_ALIKE = (_PATCH, _PATCH, float64[::1], float64[::1], float64, int64)
_SUMS = (float64[::1], *[float64[:, ::1]] * 3, float64[::1])
_ROOM = "robot.picture_odometry.alignment"

COMPILED = (
    Compiled(f"{_ROOM}.slopes", (_GREY, _GREY, _PATCH)),
    Compiled(f"{_ROOM}.similarity", _ALIKE),
    Compiled(f"{_ROOM}.step_sums", (*_ALIKE, float64[::1])),
    Compiled(f"{_ROOM}.accumulate", (*_ALIKE, *_SUMS)),
)
