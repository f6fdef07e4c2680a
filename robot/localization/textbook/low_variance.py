"""Table 4.4: low variance resampling."""

from __future__ import annotations

import numpy as np

from robot.geometry import Array


def low_variance_sampler(weights: Array, count: int, rng: np.random.Generator) -> list[int]:
    """Return the indices of ``count`` particles, drawn by their weights (n,), which sum to one."""
    drawn = []
    r = rng.random() / count
    c = weights[0]
    i = 0
    for m in range(count):
        u = r + m / count
        while u > c and i < len(weights) - 1:
            i = i + 1
            c = c + weights[i]
        drawn.append(i)
    return drawn
