"""Where repeated motions end, beside where the motion model says that they do."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from app.lab.model_fits.fit_error import FitError
from app.lab.model_fits.motion.drive_correction import DriveCorrection
from app.lab.model_fits.motion.run import MotionRun
from app.lab.model_fits.motion.steps import ErringPath
from app.lab.model_fits.motion.twists import relative, twists_of
from app.lab.model_fits.motion.windows import floors_of
from robot.geometry import Array
from robot.localization.models.differential_motion import DifferentialMotion


@dataclass(frozen=True, eq=False)
class EndSpread:
    """Errors at the end of a motion, driven several times."""

    motion: str
    errors: Array
    """(n, 3) [m, m, rad]: the true end seen from that by odometry, as a twist: along, across,
    heading."""
    predicted: Array
    """(3, 3): their covariance by the motion model, the mean over the runs."""
    distances: Array
    """(n,): squared Mahalanobis distances of the errors by the model's covariance of each run; 3
    on the mean where the model is right."""

    @property
    def mean(self) -> Array:
        """(3,) [m, m, rad]"""
        mean: Array = self.errors.mean(axis=0)
        return mean

    @property
    def covariance(self) -> Array:
        """(3, 3) of the errors about their mean."""
        return np.cov(self.errors.T)


def end_spreads(
    runs: Sequence[MotionRun],
    model: DifferentialMotion,
    correction: DriveCorrection,
    floors: tuple[float, float] = (0.0, 0.0),
) -> list[EndSpread]:
    """The ends of runs, one entry for each motion in the order in which they come.

    Args:
        runs: at the even stamps that the model's alphas are for.
        model: the motion model.
        correction: what odometry errs by on the mean.
        floors: standard deviations of poses at both ends, [m] along and across and [rad].

    Raises:
        FitError: a motion was driven only once.
    """
    spreads = []
    for name in dict.fromkeys(run.name for run in runs):
        of = [run for run in runs if run.name == name]
        if len(of) < 2:
            raise FitError(f"{name} was driven {len(of)} time; a spread needs 2 or more")
        spreads.append(_spread(name, of, model, correction, floors))
    return spreads


def _spread(
    name: str,
    runs: Sequence[MotionRun],
    model: DifferentialMotion,
    correction: DriveCorrection,
    floors: tuple[float, float],
) -> EndSpread:
    ends = [_end(run, model, correction, floors) for run in runs]
    errors = np.array([error for error, _ in ends])
    covariances = np.array([covariance for _, covariance in ends])
    # A run that stood still has no spread, and no error either.
    inverses = np.linalg.pinv(covariances, hermitian=True)
    distances = np.einsum("ni,nij,nj->n", errors, inverses, errors)
    return EndSpread(name, errors, covariances.mean(axis=0), distances)


def _end(
    run: MotionRun,
    model: DifferentialMotion,
    correction: DriveCorrection,
    floors: tuple[float, float],
) -> tuple[Array, Array]:
    """Error (3,) at the end of a run, and its covariance (3, 3) by the model."""
    path = ErringPath.along(correction.corrected(run.steps))
    first, last = np.array([0]), np.array([len(run.stamps) - 1])
    moved, truly = path.moved(first, last), relative(run.truth[first], run.truth[last])
    alphas = np.array([model.alpha1, model.alpha2, model.alpha3, model.alpha4])
    covariance = np.einsum("c,cij->ij", alphas, path.covariances(first, last)[0])
    covariance += np.einsum("c,cij->ij", np.square(floors), floors_of(moved)[0])
    return twists_of(relative(moved, truly))[0], covariance
