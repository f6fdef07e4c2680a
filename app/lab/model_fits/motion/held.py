"""What regions hold of drives that they were not fitted to, and how surely that is known."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from scipy.stats import beta

from app.lab.model_fits.motion.coverage import Region, cut_for, squared_distances, windows_for
from app.lab.model_fits.motion.drive_correction import DriveCorrection
from app.lab.model_fits.motion.fit import MotionFit
from app.lab.model_fits.motion.run import MotionRun

Judgement = Literal["honest", "too sure", "too cautious"]

CONFIDENCE = 0.95
"""Of the interval of a share."""


@dataclass(frozen=True, slots=True)
class Held:
    """A region, and what it held of drives that it was not fitted to."""

    region: Region
    share: float
    """Of all windows of its length."""
    interval: tuple[float, float]
    """Of 95 %: which shares of endless drives like these this one may come from."""
    independent: float
    """How many independent windows the share is worth."""

    @property
    def judgement(self) -> Judgement:
        """Whether the share that it should hold is in the interval; else on which side it errs.

        Honest therefore means not refuted: of few windows the interval is wide. From fewer than
        72 it reaches below 95 % even if all are held.
        """
        low, high = self.interval
        if high < self.region.share:
            return "too sure"
        return "too cautious" if low > self.region.share else "honest"


def held_by(
    runs: Sequence[MotionRun], correction: DriveCorrection, fit: MotionFit, region: Region
) -> Held:
    """What a region holds of the true ends of drives.

    The windows overlap, and an error that lasts longer than a window shows in several side by
    side, so they are worth far fewer independent ones: n / (1 + 2 sum of rho_k), with rho_k the
    correlation of being held k windows apart, summed up to the first that is not positive; and no
    more than lie side by side. The interval is Clopper and Pearson's (1934) for so many, which
    holds at least what it says and is no point where all or none are held. A bootstrap over blocks
    would be: it repeats what it has seen, and twenty blocks have not seen what happens rarely.

    Raises:
        FitError: no drive is as long.
    """
    windows = windows_for(runs, region.horizon, correction)
    inside = squared_distances(windows, fit) <= region.threshold
    counts = [len(one.start) for one in cut_for(runs, region.horizon)]
    drives = np.split(inside, np.cumsum(counts)[:-1])
    independent = min(windows.independent, len(inside) / repetition(drives))
    share = float(inside.mean())
    return Held(region, share, share_interval(share, independent), independent)


def share_interval(share: float, count: float) -> tuple[float, float]:
    """Clopper and Pearson's interval of a share of ``count`` draws, which need not be whole."""
    held, tail = share * count, (1 - CONFIDENCE) / 2
    low = float(beta.ppf(tail, held, count - held + 1)) if held > 0 else 0.0
    high = float(beta.ppf(1 - tail, held + 1, count - held)) if held < count else 1.0
    return low, high


def repetition(drives: Sequence[NDArray[np.bool_]]) -> float:
    """How many windows, 1 or more, say no more than an independent one."""
    mean = np.concatenate(drives).mean()
    off = [drive - mean for drive in drives]
    variance = sum(float(one @ one) for one in off)
    if variance == 0:
        return 1.0
    total = 1.0
    for lag in range(1, max(map(len, off))):
        products = sum(float(one[lag:] @ one[:-lag]) for one in off if len(one) > lag)
        if products <= 0:
            break
        total += 2 * products / variance
    return total
