"""Where along a line rays saw bare floor instead of tape."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from robot.geometry import Array

BIN = 0.01
"""Length of the parts in which lines are examined [m]."""
FEWEST = 3
"""A part is bare if at least this many rays saw bare floor there, and hardly any saw tape: ..."""
HARDLY = 0.2
"""... at most this share of them."""
SHORTEST_GAP = 0.02
"""Shorter gaps do not count [m]: rays beside the end of other tape miss it."""


def gaps(tape: Array, bare: Array, first: float, last: float) -> Iterator[tuple[float, float]]:
    """Yield the gaps in tape along a line, from where to where each.

    Args:
        tape: (n,) where on the line rays crossed tape [m].
        bare: (m,) where they saw bare floor [m].
        first: where the line begins [m].
        last: where it ends [m].
    """
    cuts = np.linspace(first, last, max(2, 1 + round((last - first) / BIN)))
    taped, empty = np.histogram(tape, cuts)[0], np.histogram(bare, cuts)[0]
    is_bare = (empty >= FEWEST) & (taped <= HARDLY * empty)
    # Between bare parts, where nobody looked, there is no tape either.
    known = np.flatnonzero(is_bare | (taped > 0))
    borders = np.flatnonzero(np.diff(is_bare[known])) + 1
    for run in np.split(known, borders):
        if len(run) and is_bare[run[0]] and cuts[run[-1] + 1] - cuts[run[0]] >= SHORTEST_GAP:
            yield float(cuts[run[0]]), float(cuts[run[-1] + 1])
