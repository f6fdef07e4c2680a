"""What a search for tape of one brightness found on each ray."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from robot.geometry import Array


class FoundTape(NamedTuple):
    """What was found in one picture of dark tape, or of light tape, or of both."""

    edges: Array
    """(k, 2) entry and exit of the chosen pair [samples]."""
    verdicts: NDArray[np.int8]
    """(k,) the ``Verdict`` of each ray."""
    widths: Array
    """(k,) [m]; nan without a line."""
    lines: Array
    """(k, 3) unit normal and offset [m] of the entry edges; nan without a line."""
    ranges: Array
    """(k,) by the entries' lines [m], inf for rays that do not count."""
    hidden: Array
    """(k, 2) from where to where something that is no tape lies on the ray [m], ``Scan.hidden``."""
    first: Array
    """(k, 2) where a ray first meets the edge of anything, and leaves it [samples]; nan without."""
    noise: float
    """Of the picture [grey levels]."""
    kernel: int
    """Half width of the edge kernel [samples]."""
    clear: Array
    """(k,) probability that tape on a ray is found."""

    def nearer(self, other: FoundTape) -> FoundTape:
        """Return what counts of either, on each ray the nearer one."""
        # Where neither counts, the verdict is of the one that came closest to counting.
        closer = other.verdicts > self.verdicts
        counted = np.isfinite(self.ranges) | np.isfinite(other.ranges)
        taken = np.where(counted, other.ranges < self.ranges, closer)
        # What is tape to the one is a thing to the other.
        hull = np.column_stack(
            [
                np.minimum(self.hidden[:, 0], other.hidden[:, 0]),
                np.maximum(self.hidden[:, 1], other.hidden[:, 1]),
            ]
        )
        sooner = ~(self.first[:, 0] <= other.first[:, 0]) & ~np.isnan(other.first[:, 0])
        return FoundTape(
            np.where(taken[:, None], other.edges, self.edges),
            np.where(taken, other.verdicts, self.verdicts),
            np.where(taken, other.widths, self.widths),
            np.where(taken[:, None], other.lines, self.lines),
            np.where(taken, other.ranges, self.ranges),
            np.where(counted[:, None], np.where(taken[:, None], other.hidden, self.hidden), hull),
            np.where(sooner[:, None], other.first, self.first),
            self.noise,
            self.kernel,
            np.minimum(self.clear, other.clear),
        )
