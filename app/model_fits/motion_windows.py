"""Drives cut into windows: where odometry says they end, and by how much truth differs."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from app.model_fits.drive_correction import DriveCorrection
from app.model_fits.motion_run import FitError, MotionRun
from app.model_fits.motion_steps import ErringPath
from app.model_fits.motion_twists import relative, twists_of
from robot.geometry import Array

AS_IT_IS = DriveCorrection()


@dataclass(frozen=True, eq=False)
class Windows:
    """Windows of drives, all as long; they may overlap."""

    horizon: float
    """How long each is [s]; shorter where a whole drive is."""
    step: float
    """Time of a step of the motion model [s]."""
    independent: float
    """How many of them there could be without overlap."""
    moved: Array
    """(n, 3) [m, m, rad]: the window's end by odometry, seen from its start."""
    errors: Array
    """(n, 3) [m, m, rad]: the true end seen from that by odometry, as a twist.

    Turning errors bend the cloud of ends like a banana; as twists, the logarithm of SE(2), it is
    normal (Long, Wolfe, Mashner and Chirikjian 2012).
    """
    by_alpha: Array
    """(n, 4, 3, 3): covariance of the errors for each alpha at one."""

    def __len__(self) -> int:
        return len(self.errors)


def windows(
    runs: Iterable[MotionRun],
    horizon: float,
    correction: DriveCorrection = AS_IT_IS,
    *,
    stride: float | None = None,
    keep_short: bool = False,
) -> Windows:
    """Cut drives into windows.

    Args:
        runs: drives at even stamps, all with the same step.
        horizon: length of a window [s].
        correction: what odometry errs by on the mean.
        stride: time from one window to the next [s]; a quarter of the horizon unless told.
        keep_short: whether a drive that is shorter than the horizon is a window as it is.

    Raises:
        FitError: no drive is as long, or their steps are not all as long.
    """
    drives = list(runs)
    step = _common_step(drives)
    length = max(round(horizon / step), 1)
    apart = max(round((horizon / 4 if stride is None else stride) / step), 1)
    long = [run for run in drives if keep_short or len(run.stamps) > length]
    if not long:
        longest = max(run.duration for run in drives)
        raise FitError(f"windows of {horizon:g} s are asked; the longest drive has {longest:.1f} s")
    parts = [_of_run(run, min(length, len(run.stamps) - 1), apart, correction) for run in long]
    moved, errors, by_alpha = (np.concatenate(column) for column in zip(*parts, strict=True))
    independent = sum(max((len(run.stamps) - 1) / length, 1.0) for run in long)
    return Windows(horizon, step, independent, moved, errors, by_alpha)


def _of_run(
    run: MotionRun, length: int, apart: int, correction: DriveCorrection
) -> tuple[Array, Array, Array]:
    path = ErringPath.along(correction.corrected(run.steps))
    start = np.arange(0, len(run.stamps) - length, apart)
    end = start + length
    moved = path.moved(start, end)
    truly = relative(run.truth[start], run.truth[end])
    return moved, twists_of(relative(moved, truly)), path.covariances(start, end)


def _common_step(runs: Sequence[MotionRun]) -> float:
    """Time of a step [s] of all drives."""
    if not runs:
        raise FitError("there is no drive; one or more are needed")
    step = float(np.median(np.diff(runs[0].stamps)))
    for run in runs:
        if np.abs(np.diff(run.stamps) - step).max() > 0.01 * step:
            raise FitError(
                f"the stamps of {run.name} are not {step:.4f} s apart, as they must be all along "
                "and in all drives; resample them"
            )
    return step
