"""Odometry's steady errors at a first look: by least squares that outliers do not spoil."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.optimize import least_squares

from app.lab.model_fits.fit_error import FitError
from app.lab.model_fits.motion.drive_correction import DriveCorrection
from app.lab.model_fits.motion.run import MotionRun
from app.lab.model_fits.motion.windows import Comparison, cut
from robot.geometry import Array

HORIZONS = (1.0, 5.0, 20.0)
"""Relative poses are compared over these times [s]."""

LEAST_WAY, LEAST_TURN = 1.0, 3.0
"""What must be driven [m] and turned [rad] in all."""

TYPICAL = 0.01
"""How large errors of distance, turn and curvature are."""


def robust_correction(
    runs: Sequence[MotionRun], *, horizons: Sequence[float] = HORIZONS, track: float = 0.0
) -> DriveCorrection:
    """Find distance and turn multiplier and curvature with which odometry comes nearest to truth.

    Residuals are relative poses over each horizon, seen from the end by odometry, by their typical
    size there (from the median); large ones count less (soft L1).

    Args:
        runs: drives at even stamps.
        horizons: [s]; a drive that is shorter is compared as a whole.
        track: distance between the wheels that odometry believes in [m], if it is known.

    Raises:
        FitError: too little was driven or turned.
    """
    _check_enough(runs)
    compared = [
        Comparison.of(cut(runs, horizon, stride=horizon / 2, keep_short=True))
        for horizon in horizons
    ]
    found = np.array([1.0, 1.0, 0.0])
    for _ in range(2):  # sizes are of the errors that are left, which the first round finds
        sizes = [_sizes(of, _correction(found, track)) for of in compared]

        def residuals(trial: Array, sizes: Sequence[Array] = sizes) -> Array:
            errors = [
                of.errors(_correction(trial, track)) / size
                for of, size in zip(compared, sizes, strict=True)
            ]
            return np.concatenate(errors).ravel()

        found = least_squares(residuals, found, x_scale=TYPICAL, loss="soft_l1").x
    return _correction(found, track)


def _correction(found: Array, track: float) -> DriveCorrection:
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


def _sizes(of: Comparison, correction: DriveCorrection) -> Array:
    """Typical size (3,) of errors: their standard deviation, if they were normal."""
    medians = np.median(np.abs(of.errors(correction)), axis=0)
    sizes: Array = np.maximum(1.4826 * medians, 1e-6)
    return sizes
