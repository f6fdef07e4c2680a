"""The particle filter by hand: predict, weigh and resample, one at a time.

The steps are those of ``Localizer.update``, and draw the same numbers.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from robot.errors import BrickPoseError
from robot.geometry import Array, Pose2, compose
from robot.localization.estimate import Estimate
from robot.localization.filter import Cloud
from robot.localization.localizer import Localizer
from robot.localization.particles.particle_filter import ParticleFilter
from robot.scan import Scan

Step = Literal["predict", "weigh", "resample"]


class StepError(BrickPoseError, ValueError):
    """A step cannot be taken now; the message says which one can."""


@dataclass(frozen=True, slots=True, eq=False)
class HandStep:
    """A step that was taken, and what it did to the particles."""

    step: Step
    before: Cloud = field(repr=False)
    after: Cloud = field(repr=False)
    newest: tuple[Scan, Pose2] | None = field(default=None, repr=False)
    """The scan up to which a prediction went, as it was measured, and odometry at its stamp."""
    moved: Pose2 = Pose2()
    """By odometry, of a prediction."""
    noiseless: Array | None = field(default=None, repr=False)
    """(n, 3) where odometry alone had moved each particle; the rest of the way is noise."""
    parents: NDArray[np.int64] | None = field(default=None, repr=False)
    """(m,) of which particle before each is a copy; -1 is of none."""


class FilterByHand:
    """Steps the particle filter of a localizer."""

    def __init__(self, localizer: Localizer) -> None:
        """Begin where the filter is.

        Raises:
            StepError: the filter is another one.
        """
        if not isinstance(localizer.filter, ParticleFilter):
            raise StepError(
                f"the filter {localizer.parameters.filter} has no steps by hand; choose particles"
            )
        self.localizer = localizer
        self._filter = localizer.filter
        self.last: HandStep | None = None
        """The last step; None before the first."""
        self.seen: tuple[Scan, Pose2] | None = None
        """The scan to weigh by, and odometry at its stamp, since a prediction."""

    @property
    def particles(self) -> Cloud:
        """The particles as they stand."""
        return self._filter.particles

    def predict(self, scan: Scan, odometry: Pose2) -> None:
        """Move the particles by all of the odometry up to a scan, and by chance."""
        before = self.particles
        self.seen = self.localizer.trusted(scan), odometry
        moved = self.localizer.advance(odometry)
        noiseless = compose(before.poses, moved.to_array())
        self.last = HandStep("predict", before, self.particles, (scan, odometry), moved, noiseless)

    def weigh(self) -> Estimate | None:
        """Weigh the particles by the scan that they were moved to; return the estimate.

        Raises:
            StepError: they were not moved since the last time.
        """
        if self.seen is None or self.last is None or self.last.step != "predict":
            raise StepError("there is no new scan to weigh by; predict first")
        before = self.particles
        scan, odometry = self.seen
        self._filter.weigh(scan)
        self.last = HandStep("weigh", before, self.particles)
        return self.localizer.conclude(odometry, scan)

    def resample(self) -> None:
        """Draw the particles that go on.

        Raises:
            StepError: they were not weighed since the last time.
        """
        if self.last is None or self.last.step != "weigh":
            raise StepError("the weights are not new; weigh first")
        before = self.particles
        parents = self._filter.resample().parents
        self.last = HandStep("resample", before, self.particles, parents=parents)
