"""How well an estimate fits its own measurements: ``FitQuality``, at the end of each adjustment.

Calibrations, maps, lenses, mountings and pose graphs are all adjusted by least squares, and may all
be wrong in the same ways: the adjustment did not end, it left what was known before, what it leaves
over is no noise, or nothing told of an unknown. So all of them are asked the same.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from robot.errors import BrickPoseError
from robot.geometry import Array

MOST_PRIOR_SD = 3.0
"""What was known before is overrun if an unknown ends farther from it than this many of its
standard deviations: with a wrong scale the tape's width was off by 6 to 65 of them, in right maps
by at most 0.3."""
MOST_RESIDUAL = 2.5
"""A model explains what was seen if residuals are at most this multiple of the expected ones; those
of right calibrations and maps are 0.4 to 0.5, of drives that went astray 2.8 and more."""
MOST_CORRELATION = 0.6
"""What is left over is noise if neighbouring residuals are less alike. Those of calibrations had
correlations of -0.03 to 0.14, of maps of known robots 0.03 to 0.36, and of maps of robots that
nobody calibrated 0.82 to 0.94; half of it would doubt right maps, and twice nothing."""
FEWEST = 10
"""Means of fewer residuals are of their noise, and are not compared."""
MEDIAN_OF_NORMAL = 0.6745
"""Median of the absolute value of a standard normal number."""


class ContradictionError(BrickPoseError, ValueError):
    """A result contradicts itself, so it is not written; the message says in what."""


@dataclass(frozen=True)
class FitQuality:
    """What an adjustment says for and against its own result."""

    residual: float
    """Robust standard deviation of what is left over, as a multiple of the expected; nan without
    any."""
    converged: bool = True
    """Whether a further step would have changed nothing."""
    correlation: float = 0.0
    """Of neighbouring residuals: 0 if what is left over is white noise, up to 1."""
    overrun: Mapping[str, float] = field(default_factory=dict)
    """Unknowns, by name, that ended far from what was known of them before, as multiples of the
    standard deviations of that (``overruns``)."""
    unobservable: tuple[str, ...] = ()
    """Unknowns, by name, of which the measurements say little or nothing."""

    @property
    def is_noise(self) -> bool:
        """Whether what is left over is noise, and not what a wrong model leaves."""
        return self.correlation <= MOST_CORRELATION

    @property
    def interval_factor(self) -> float:
        """By how much intervals are wider for what is left over, 1 or more.

        Residuals larger than expected widen them as much (the variance factor). Of residuals that
        are alike, a smaller number counts (a first-order process). Smaller ones narrow nothing:
        where the pixels' deviations were halved, as the residuals of twelve calibrations are,
        intervals of 95 % held 80 % of the true values, and 98 % as they are.
        """
        spread = self.residual if math.isfinite(self.residual) else 1.0
        return max(1.0, spread) * (1.0 if self.is_noise else self.alike_factor)

    @property
    def alike_factor(self) -> float:
        """By how much fewer residuals count that are alike (a first-order process), 1 or more."""
        alike = max(0.0, self.correlation)
        return math.sqrt((1 + alike) / max(1 - alike, 0.01))

    @property
    def facts(self) -> tuple[str, ...]:
        """The same for each kind of result, in words for people."""
        facts = [
            "the adjustment converged" if self.converged else "the adjustment did not converge",
            f"what is left over is {self.residual:.2f} times as large as expected; neighbours are "
            f"alike by {self.correlation:.2f}",
        ]
        if self.overrun:
            facts.append(f"overrun of what was known before: {', '.join(self.overrun)}")
        if self.unobservable:
            facts.append(f"hardly observed: {', '.join(self.unobservable)}")
        return tuple(facts)

    @property
    def contradictions(self) -> tuple[str, ...]:
        """In what the result contradicts itself, in words for people; nothing if it does not."""
        words = []
        if not self.converged:
            words.append(
                "the adjustment did not come to an end, so its result is less certain than it "
                "says: measure once more, from other sides"
            )
        if self.overrun:
            much = ", ".join(f"{name} {times:+.0f}" for name, times in self.overrun.items())
            words.append(
                "it leaves what was known before, so all of it, its scale too, may be wrong "
                f"({much} times what is usual)"
            )
        if self.residual > MOST_RESIDUAL:
            words.append(
                f"what was seen lies {self.residual:.1f} times as far off as expected, so the "
                "model does not explain it"
            )
        return tuple(words)

    @property
    def remarks(self) -> tuple[str, ...]:
        """What is to be known of the result, contradictions first."""
        words = self.contradictions
        if not self.is_noise:
            words += (
                "what is left over is no noise: the robot, its lens or the floor is not as it is "
                f"thought to be; intervals are {self.interval_factor:.1f} times as wide for it",
            )
        return words

    def require_consistent(self, *, force: bool = False) -> None:
        """Refuse a result that contradicts itself, unless somebody insists.

        Raises:
            ContradictionError: says in what.
        """
        if self.contradictions and not force:
            words = "; ".join(self.contradictions)
            raise ContradictionError(
                f"the result contradicts itself, so it is not kept: {words}; valid is another "
                "measurement, or a command's --force"
            )

    def table(self) -> dict[str, Any]:
        """Return it as a table for a file, of numbers, booleans and lists of texts."""
        return {
            "converged": self.converged,
            "residual": round(self.residual, 4) if math.isfinite(self.residual) else -1.0,
            "correlation": round(self.correlation, 4),
            "overrun": [f"{name} {times:+.1f}" for name, times in self.overrun.items()],
            "unobservable": list(self.unobservable),
        }

    @classmethod
    def of_table(cls, table: Mapping[str, Any]) -> FitQuality:
        """Return it from a table of a file; what is not there is as if nothing were wrong.

        A table that no adjustment wrote says nothing of its result.
        """
        try:
            overrun = [str(entry).rpartition(" ") for entry in table.get("overrun", ())]
            residual = float(table.get("residual", -1.0))
            return cls(
                residual if residual >= 0 else math.nan,
                bool(table.get("converged", True)),
                float(table.get("correlation", 0.0)),
                {name: float(times) for name, _, times in overrun},
                tuple(map(str, table.get("unobservable", ()))),
            )
        except (AttributeError, TypeError, ValueError):
            return cls(math.nan)


def robust_sd(residuals: ArrayLike) -> float:
    """Return the robust standard deviation of residuals (n,), in their unit; nan without any."""
    sizes = np.abs(np.asarray(residuals, np.float64))
    return float(np.median(sizes) / MEDIAN_OF_NORMAL) if sizes.size else math.nan


def correlation_of(residuals: Array, groups: NDArray[np.int64] | None = None) -> float:
    """Return how alike neighbouring residuals (n,) are, -1 to 1.

    Args:
        residuals: in the order in which they are neighbours.
        groups: (n,) which of them are taken together, rising; their means are compared then.
    """
    if groups is not None and len(residuals):
        counts, enough = np.bincount(groups), np.bincount(groups) >= FEWEST
        residuals = np.bincount(groups, residuals)[enough] / counts[enough]
    total = float(residuals @ residuals)
    return float(residuals[1:] @ residuals[:-1]) / total if total > 0 else 0.0


def overruns(values: ArrayLike, prior_sd: ArrayLike, names: Sequence[str]) -> dict[str, float]:
    """Return which unknowns (n,) ended far from zero, by what was known of them before.

    Args:
        values: as differences from what was expected.
        prior_sd: (n,) how uncertain that was.
        names: of the unknowns.

    Returns:
        How many of these standard deviations they are off, by name.
    """
    shares = (np.asarray(values) / np.asarray(prior_sd)).tolist()
    return {
        name: share for name, share in zip(names, shares, strict=True) if abs(share) > MOST_PRIOR_SD
    }
