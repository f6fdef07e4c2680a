"""Odometry's steady errors from odometry and truth, by robust least squares."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import least_squares
from scipy.stats import t as student

from app.model_fits.drive_correction import DriveCorrection
from app.model_fits.motion_run import FitError, MotionRun
from app.model_fits.motion_twists import chained, relative, twists_of
from robot.geometry import Array

HORIZONS = (1.0, 5.0, 20.0)
"""Relative poses are compared over these times [s]."""

BLOCK = 2.0
"""Errors this many of the longest horizons apart are taken as independent."""

LEAST_BLOCKS = 5
"""From fewer, nothing is known of how sure the result is."""

LEAST_WAY, LEAST_TURN = 1.0, 3.0
"""What must be driven [m] and turned [rad] in all."""

TYPICAL = np.array([0.01, 0.01, 0.01])
"""How large errors of the three are."""


@dataclass(frozen=True)
class CorrectionFit:
    """What odometry errs by each time, and how well that is known."""

    correction: DriveCorrection
    intervals: tuple[tuple[float, float], tuple[float, float], tuple[float, float]]
    """95 % intervals of distance, turn and curvature."""
    blocks: int
    """Stretches of the drives that the intervals take as independent."""


def fit_correction(
    runs: Sequence[MotionRun], *, horizons: Sequence[float] = HORIZONS, track: float = 0.0
) -> CorrectionFit:
    """Find distance and turn multiplier and curvature with which odometry comes nearest to truth.

    Residuals are relative poses over each horizon, seen from the end by odometry, by their typical
    size there (the median's); large ones count less (soft L1). The intervals are those of
    clustered errors (the sandwich of Huber 1967): they allow for windows that overlap.

    Args:
        runs: drives at even stamps.
        horizons: [s]; a drive that is shorter is compared as a whole.
        track: distance between the wheels that odometry believes in [m], if it is known.

    Raises:
        FitError: too little was driven or turned, or in too few pieces.
    """
    _check_enough(runs)
    picks = [_Pick.of(run, horizons) for run in runs]
    blocks = _blocks(picks, BLOCK * max(horizons))
    found = np.array([1.0, 1.0, 0.0])
    for _ in range(2):  # sizes are of the errors that are left, which the first round finds
        residuals = _residuals(picks, track, _sizes(picks, _as_correction(found, track)))
        found = least_squares(residuals, found, x_scale=TYPICAL, loss="soft_l1").x
    deviations = _deviations(residuals, found, blocks)
    count = int(blocks.max()) + 1
    reach = float(student.ppf(0.975, count - 1)) * deviations
    low, high = (found - reach).tolist(), (found + reach).tolist()
    intervals = ((low[0], high[0]), (low[1], high[1]), (low[2], high[2]))
    return CorrectionFit(_as_correction(found, track), intervals, count)


@dataclass(frozen=True, eq=False)
class _Pick:
    """The windows of one drive: where they start and end, and which horizon they are of."""

    run: MotionRun
    steps: Array
    start: Array
    end: Array
    kind: Array

    @classmethod
    def of(cls, run: MotionRun, horizons: Sequence[float]) -> _Pick:
        step, last = run.duration / (len(run.stamps) - 1), len(run.stamps) - 1
        starts, ends, kinds = [], [], []
        for kind, horizon in enumerate(horizons):
            length = min(max(round(horizon / step), 1), last)
            start = np.arange(0, last - length + 1, max(length // 2, 1))
            starts.append(start)
            ends.append(start + length)
            kinds.append(np.full(len(start), kind))
        return cls(run, run.steps, *(np.concatenate(parts) for parts in (starts, ends, kinds)))

    def errors(self, correction: DriveCorrection) -> Array:
        """(n, 3) [m, m, rad]: truth seen from corrected odometry, at the windows' ends."""
        path = chained(correction.corrected(self.steps))
        truly = relative(self.run.truth[self.start], self.run.truth[self.end])
        return twists_of(relative(relative(path[self.start], path[self.end]), truly))


def _as_correction(found: Array, track: float) -> DriveCorrection:
    return DriveCorrection(float(found[0]), float(found[1]), float(found[2]), track)


def _check_enough(runs: Sequence[MotionRun]) -> None:
    moved = [np.abs(run.steps) for run in runs]
    way = float(sum(np.hypot(steps[:, 0], steps[:, 1]).sum() for steps in moved))
    turned = float(sum(steps[:, 2].sum() for steps in moved))
    if way < LEAST_WAY or turned < LEAST_TURN:
        raise FitError(
            f"{way:.2f} m were driven and {turned:.2f} rad turned; at least {LEAST_WAY:g} m and "
            f"{LEAST_TURN:g} rad are needed to tell what odometry errs by each time"
        )


def _blocks(picks: list[_Pick], length: float) -> Array:
    """For each window which stretch it lies in; drives are cut into stretches of a length [s]."""
    numbers, next_one = [], 0
    for pick in picks:
        middle = (pick.run.stamps[pick.start] + pick.run.stamps[pick.end]) / 2
        count = max(round(pick.run.duration / length), 1)
        part = (middle - pick.run.stamps[0]) / pick.run.duration * count
        numbers.append(next_one + np.minimum(part.astype(int), count - 1))
        next_one += count
    if next_one < LEAST_BLOCKS:
        raise FitError(
            f"the drives make {next_one} stretches of {length:g} s; at least {LEAST_BLOCKS} are "
            f"needed: {LEAST_BLOCKS * length:g} s, or {LEAST_BLOCKS} drives"
        )
    return np.concatenate(numbers)


def _sizes(picks: list[_Pick], correction: DriveCorrection) -> Array:
    """Typical size (k, 3) of the errors of each horizon."""
    errors = np.concatenate([pick.errors(correction) for pick in picks])
    kinds = np.concatenate([pick.kind for pick in picks])
    medians = [np.median(np.abs(errors[kinds == kind]), axis=0) for kind in range(kinds.max() + 1)]
    return np.maximum(1.4826 * np.array(medians), 1e-6)


def _residuals(picks: list[_Pick], track: float, sizes: Array) -> Callable[[Array], Array]:
    scale = sizes[np.concatenate([pick.kind for pick in picks])]

    def residuals(found: Array) -> Array:
        correction = _as_correction(found, track)
        flat: Array = (np.concatenate([p.errors(correction) for p in picks]) / scale).ravel()
        return flat

    return residuals


def _deviations(residuals: Callable[[Array], Array], found: Array, blocks: Array) -> Array:
    """Standard deviations (3,) of what was found, from how much each stretch pulls at it."""
    r = residuals(found)
    nudges = np.diag(1e-3 * TYPICAL)
    J = np.stack(
        [(residuals(found + d) - residuals(found - d)) / (2 * d.sum()) for d in nudges], axis=1
    )
    pulls = J * (r / np.sqrt(1 + r * r))[:, None]
    count = int(blocks.max()) + 1
    by_block = np.zeros((count, 3))
    np.add.at(by_block, np.repeat(blocks, 3), pulls)
    bread = np.linalg.inv(J.T @ (J * ((1 + r * r) ** -1.5)[:, None]))
    spread = bread @ (by_block.T @ by_block) @ bread * count / (count - 1)
    deviations: Array = np.sqrt(np.diag(spread))
    return deviations
