"""A map of tape that was drawn by driving, and how well it fits the drive."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from robot.calibration.adjustment import Solution, residual_sd
from robot.calibration.unknowns import COUNT
from robot.errors import BrickPoseError
from robot.geometry import Array, Pose2
from robot.mapping.drawing import drawing
from robot.mapping.strokes import Strokes
from robot.mapping.tidying import TidyStrokes

LEAST_SHARE = 0.7
"""A map fits if this share of the edges that were seen lies on its strokes."""
MOST_RESIDUAL = 2.5
"""... and if they lie at most so many times as far off as expected."""
MOST_SLIP, MOST_STEP = 0.3, 6.0
"""... and if no wheel had to slip more than this share, seven standard deviations, and no step was
more than so many deviations from what the wheels tell."""


class MappingError(BrickPoseError, ValueError):
    """The drive does not tell what the floor is like; the message says why."""


@dataclass(frozen=True)
class TapeMap:
    """A map, and the drive that it was drawn by."""

    tidy: TidyStrokes
    """The tape."""
    measured: Strokes
    """What was measured of it, in the adjustment."""
    solution: Solution = field(repr=False)
    """The drive."""
    stamps: Array = field(repr=False)
    """(k,) of the pictures that were used [s]."""
    step_errors: Array = field(repr=False)
    """(k - 1, 3) how far steps are from what the wheels tell, in deviations."""

    @property
    def length(self) -> float:
        """Of all tape [m]."""
        return sum(stroke.length for stroke in self.tidy.strokes)

    @property
    def node_sd(self) -> Array:
        """(n,) how uncertain each node of ``measured`` is across its stroke [m].

        The map begins where the robot did, so what is far from there is less certain.
        """
        sd: Array = np.sqrt(np.diag(self.solution.covariance)[COUNT:])
        return sd

    @property
    def residual(self) -> float:
        """How many times as far as expected edges lie off the strokes."""
        return residual_sd(self.solution.misses)

    @property
    def moved_at(self) -> float:
        """When the robot first moved otherwise than its wheels tell [s]; nan if it never did."""
        jumps = np.abs(self.step_errors).max(axis=1, initial=0.0) > MOST_STEP
        jumps |= np.abs(self.solution.state.slip[1:]).max(axis=1, initial=0.0) > MOST_SLIP
        if not jumps.any():
            return math.nan
        return float(self.stamps[1 + np.argmax(jumps)] - self.stamps[0])

    @property
    def _edges_lie_on_it(self) -> bool:
        return self.solution.share >= LEAST_SHARE and self.residual <= MOST_RESIDUAL

    @property
    def fits(self) -> bool:
        """Whether the map explains what was seen."""
        return self._edges_lie_on_it and math.isnan(self.moved_at)

    @property
    def remarks(self) -> tuple[str, ...]:
        """What is wrong with the map, or may be."""
        remarks = []
        if not self._edges_lie_on_it:
            remarks.append(
                f"the map does not fit: {100 * self.solution.share:.0f} % of the edges that were "
                f"seen lie on it, {self.residual:.1f} times as far off as expected"
            )
        if not math.isnan(self.moved_at):
            remarks.append(
                f"after {self.moved_at:.0f} s the robot moved otherwise than its wheels tell: it "
                "was pushed, or it slipped; the map may be bent"
            )
        unseen = sum(np.isinf(end.sd) for end in self.tidy.ends.values())
        if unseen:
            remarks.append(
                f"{unseen} ends of tape were not seen: drive toward them, and where the tape goes "
                "on"
            )
        return tuple(remarks)

    def drawing(self, title: str) -> str:
        """Return the map as an SVG, for ``load_field``."""
        start = Pose2.from_array(self.solution.state.poses[0])
        return drawing(self.tidy, self.measured.width, start, title)
