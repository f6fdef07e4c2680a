"""Drives cut into windows: where odometry says they end, and by how much truth differs."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from app.lab.model_fits.fit_error import FitError
from app.lab.model_fits.motion.drive_correction import DriveCorrection
from app.lab.model_fits.motion.run import MotionRun
from app.lab.model_fits.motion.steps import ErringPath, Places
from app.lab.model_fits.motion.twists import chained, relative, seen_from, twists_of
from robot.geometry import Array

AS_IT_IS = DriveCorrection()


@dataclass(frozen=True, eq=False)
class Windows:
    """Windows of drives; they may overlap."""

    horizon: float
    """How long each is, or the shortest [s]; a whole drive where that is shorter."""
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
    weights: Array
    """(n,): what each counts; together as many as are independent, and none more than one."""

    def __len__(self) -> int:
        return len(self.errors)

    @property
    def by_floor(self) -> Array:
        """(n, 2, 3, 3): covariance of the errors if truth errs by one at both ends.

        First along and across [m], then by heading [rad].
        """
        return floors_of(self.moved)


def together(several: Sequence[Windows]) -> Windows:
    """Windows of several lengths as one set, in which each length counts as much as another.

    In all they count as many as are independent of each length on the mean.
    """
    each = np.mean([one.weights.sum() for one in several]) / len(several)
    return Windows(
        several[0].horizon,
        several[0].step,
        several[0].independent,
        np.concatenate([one.moved for one in several]),
        np.concatenate([one.errors for one in several]),
        np.concatenate([one.by_alpha for one in several]),
        np.concatenate([one.weights * (each / one.weights.sum()) for one in several]),
    )


def floors_of(moved: Array) -> Array:
    """Covariances (n, 2, 3, 3) of motions (n, 3) whose ends are known to one metre, one radian.

    An error of the start's heading is, seen from the end, one of the place too.
    """
    at_end = np.array([np.diag([1.0, 1.0, 0.0]), np.diag([0.0, 0.0, 1.0])])
    to_end = seen_from(moved)[:, None]
    whole: Array = at_end + to_end @ at_end @ np.swapaxes(to_end, -1, -2)
    return whole


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
    cuts = cut(runs, horizon, stride=stride, keep_short=keep_short)
    moved, by_alpha = [], []
    for one in cuts:
        path = ErringPath.along(correction.corrected(one.steps))
        moved.append(path.moved(one.start, one.end))
        by_alpha.append(path.covariances(one.start, one.end))
    independent = sum(max(len(one.steps) / one.length, 1.0) for one in cuts)
    errors = Comparison.of(cuts).errors(correction)
    return Windows(
        horizon,
        common_step([one.run for one in cuts]),
        independent,
        np.concatenate(moved),
        errors,
        np.concatenate(by_alpha),
        np.full(len(errors), min(independent / len(errors), 1.0)),
    )


@dataclass(frozen=True, eq=False)
class Cut:
    """One drive and where its windows start and end."""

    run: MotionRun
    steps: Array
    """(n, 3) of odometry."""
    start: Places
    end: Places
    length: int
    """Steps of a window."""

    @classmethod
    def of(cls, run: MotionRun, length: int, apart: int) -> Cut:
        """Windows of some steps, so many apart; the whole drive where it is shorter."""
        steps = run.steps
        length = min(length, len(steps))
        start = np.arange(0, len(steps) - length + 1, apart)
        return cls(run, steps, start, start + length, length)


@dataclass(frozen=True, eq=False)
class Comparison:
    """All windows of several drives, to be compared with truth under one correction or another.

    The drives are set end to end, which changes nothing in how a window's end is seen from its
    start, and makes one long path of many short ones.
    """

    steps: Array
    """(m, 3) of odometry."""
    start: Places
    end: Places
    truly: Array
    """(n, 3) [m, m, rad]: true ends of the windows, seen from their true starts."""

    @classmethod
    def of(cls, cuts: Sequence[Cut]) -> Comparison:
        """The windows of drives, in their order."""
        firsts = np.cumsum([0, *(len(one.steps) for one in cuts)])
        starts = [one.start + first for one, first in zip(cuts, firsts[:-1], strict=True)]
        ends = [one.end + first for one, first in zip(cuts, firsts[:-1], strict=True)]
        truly = [relative(one.run.truth[one.start], one.run.truth[one.end]) for one in cuts]
        steps = np.concatenate([one.steps for one in cuts])
        return cls(steps, np.concatenate(starts), np.concatenate(ends), np.concatenate(truly))

    def errors(self, correction: DriveCorrection) -> Array:
        """(n, 3) [m, m, rad]: true ends seen from those by corrected odometry, as twists."""
        path = chained(correction.corrected(self.steps))
        return twists_of(relative(relative(path[self.start], path[self.end]), self.truly))


def cut(
    runs: Iterable[MotionRun],
    horizon: float,
    *,
    stride: float | None = None,
    keep_short: bool = False,
) -> list[Cut]:
    """Where the windows of drives are; the arguments are those of ``windows``."""
    drives = list(runs)
    step = common_step(drives)
    length = max(round(horizon / step), 1)
    apart = max(round((horizon / 4 if stride is None else stride) / step), 1)
    long = [run for run in drives if keep_short or len(run.stamps) > length]
    if not long:
        longest = max(run.duration for run in drives)
        raise FitError(f"windows of {horizon:g} s are asked; the longest drive has {longest:.1f} s")
    return [Cut.of(run, length, apart) for run in long]


def common_step(runs: Sequence[MotionRun]) -> float:
    """Time of a step [s], which all drives must share."""
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
