"""The motion model's alphas from odometry and truth, by maximum likelihood."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.optimize import brentq
from scipy.stats import norm

from app.lab.model_fits.fit_error import FitError
from app.lab.model_fits.motion.likelihood import LARGEST, SMALLEST, VarianceParts
from app.lab.model_fits.motion.windows import Windows
from robot.geometry import Array
from robot.localization.models.differential_motion import DifferentialMotion

FIT_HORIZONS = (5.0, 10.0, 20.0)
"""Windows that the alphas are fitted to [s]. In shorter ones stamps that are a little off look like
noise; and of one length alone, what grows with the way is hard to tell from what is always there.
"""

LEAST_WINDOWS = 20
"""A variance from fewer independent windows is known to less than a factor of two."""

LEAST_TURN = 0.05
"""What windows must turn by on the mean so that errors of turning can be told [rad]."""

LEAST_WAY = 0.01
"""What windows must go on the mean so that errors of going can be told [m]."""

WELL_KNOWN = 0.4
"""Up to this standard deviation of its logarithm, a factor's likelihood is taken as normal."""

Interval = tuple[float, float]


@dataclass(frozen=True)
class MotionFit:
    """Alphas of ``DifferentialMotion``, for steps of one length, with what is left at rest."""

    alphas: tuple[float, float, float, float]
    intervals: tuple[Interval, Interval, Interval, Interval]
    """95 % intervals of the alphas; from 0 on where the data would do without."""
    floor_xy: float
    """Standard deviation along and across of a pose, at both ends of a motion [m]: truth errs too,
    and encoders count in whole steps."""
    floor_theta: float
    """The same of the heading [rad]."""
    log_likelihood: float
    """Of as many windows as are independent."""
    independent: float
    """How many windows are that."""
    step: float
    """Time of a step [s]; the alphas hold for this one."""

    def model(self) -> DifferentialMotion:
        """The motion model with these alphas."""
        return DifferentialMotion(*self.alphas)

    def covariances(self, of: Windows) -> Array:
        """What windows should err by: (n, 3, 3), as twists seen from their ends.

        Raises:
            FitError: the windows' steps are not as long as those of the fit.
        """
        if abs(of.step - self.step) > 0.01 * self.step:
            raise FitError(
                f"alphas for steps of {self.step:.4f} s cannot tell of steps of {of.step:.4f} s"
            )
        floors = np.square([self.floor_xy, self.floor_theta])
        by_way = np.einsum("c,ncij->nij", np.array(self.alphas), of.by_alpha)
        whole: Array = by_way + np.einsum("c,ncij->nij", floors, of.by_floor)
        return whole


def fit_motion(of: Windows) -> MotionFit:
    """Find the alphas under which the errors of windows are likeliest.

    The covariance of a window's end is linear in the alphas, so the likelihood has exact
    derivatives. Windows that overlap count as many as would fit side by side. They tell a little
    more than those, so the intervals are about a fifth too wide (measured: they hold 98 to 99 %),
    which is left, as real errors are never quite what the model says.

    Raises:
        FitError: too few windows, or too little was turned or driven; says what is needed.
    """
    parts, value, logs = likeliest(of)
    intervals = _intervals(parts, value, logs)
    alphas = [0.0 if low == 0 and _needless(parts, value, logs, place) else math.exp(logs[place])
              for place, (low, _) in enumerate(intervals)]  # fmt: skip
    return MotionFit(
        (alphas[0], alphas[1], alphas[2], alphas[3]),
        (intervals[0], intervals[1], intervals[2], intervals[3]),
        math.exp(logs[4] / 2),
        math.exp(logs[5] / 2),
        -value,
        of.independent,
        of.step,
    )


def likeliest(of: Windows) -> tuple[VarianceParts, float, Array]:
    """The likelihood of windows, minus the logarithm of its greatest value, and where that is.

    Logarithms (6,) of the alphas and of the floors' variances, along and across and of the heading.

    Raises:
        FitError: as ``fit_motion``.
    """
    _check_enough(of)
    parts = _with_floors(of)
    value, logs = parts.least(parts.start())
    return parts, value, logs


def _check_enough(of: Windows) -> None:
    turned = float(np.mean(np.abs(of.moved[:, 2])))
    gone = float(np.mean(np.hypot(of.moved[:, 0], of.moved[:, 1])))
    if of.independent < LEAST_WINDOWS:
        raise FitError(
            f"{of.independent:.0f} windows of {of.horizon:g} s; at least {LEAST_WINDOWS} are "
            f"needed, which is {LEAST_WINDOWS * of.horizon:g} s of driving"
        )
    if turned < LEAST_TURN:
        raise FitError(
            f"windows of {of.horizon:g} s turn by {turned:.3f} rad on the mean; alpha1 and alpha4 "
            f"cannot be told below {LEAST_TURN:g} rad: drive turns too"
        )
    if gone < LEAST_WAY:
        raise FitError(
            f"windows of {of.horizon:g} s go {gone:.3f} m on the mean; alpha2 and alpha3 cannot "
            f"be told below {LEAST_WAY:g} m: drive straight on too"
        )


def _with_floors(of: Windows) -> VarianceParts:
    return VarianceParts(of.errors, np.concatenate([of.by_alpha, of.by_floor], axis=1), of.weights)


def _needless(parts: VarianceParts, value: float, logs: Array, place: int) -> bool:
    """Whether the data are as likely without one of the factors."""
    without = logs.copy()
    without[place] = SMALLEST
    return parts.least(without, place)[0] - value < 1e-3


def _intervals(parts: VarianceParts, value: float, logs: Array) -> list[Interval]:
    """95 % intervals of the four alphas."""
    deviations = _deviations(parts.information(logs))
    reach = float(norm.ppf(0.975))
    intervals = []
    for place in range(4):
        centre, deviation = float(logs[place]), deviations[place]
        if deviation <= WELL_KNOWN:
            ends = math.exp(centre - reach * deviation), math.exp(centre + reach * deviation)
        else:
            ends = _by_profile(parts, value, logs, place)
        intervals.append(ends)
    return intervals


def _deviations(information: Array) -> Array:
    """Standard deviations (c,) of the logarithms; infinite where the data say nothing."""
    values, axes = np.linalg.eigh(information)
    if values[0] <= 1e-9 * values[-1]:
        return _deviations_of_known(information)
    deviations: Array = np.sqrt(np.sum(np.square(axes) / values, axis=1))
    return deviations


def _deviations_of_known(information: Array) -> Array:
    """The same where some factors ran to zero, where nothing changes with their logarithms."""
    known = np.diag(information) > 1e-6 * np.diag(information).max()
    deviations = np.full(len(information), np.inf)
    values, axes = np.linalg.eigh(information[np.ix_(known, known)])
    if values[0] > 1e-9 * values[-1]:
        deviations[known] = np.sqrt(np.sum(np.square(axes) / values, axis=1))
    return deviations


def _by_profile(parts: VarianceParts, value: float, logs: Array, place: int) -> Interval:
    """Where the likelihood, the other factors at their best, falls by that of 1.96 deviations."""
    fall = float(norm.ppf(0.975)) ** 2 / 2
    warm = logs.copy()

    def excess(at: float) -> float:
        warm[place] = at
        least, warm[:] = parts.least(warm, place)
        return least - value - fall

    def crossing(end: float) -> float | None:
        """Towards an end, in wider and wider strides; None where it is not crossed."""
        inner, stride = float(logs[place]), math.copysign(0.5, end - logs[place])
        while inner != end:
            outer = max(inner + stride, end) if stride < 0 else min(inner + stride, end)
            if excess(outer) > 0:
                return float(brentq(excess, min(inner, outer), max(inner, outer), xtol=0.02))
            inner, stride = outer, 2 * stride
        return None

    low, high = crossing(SMALLEST), crossing(LARGEST)
    return 0.0 if low is None else math.exp(low), math.inf if high is None else math.exp(high)
