"""Moves a particle to where its scan fits its own map best (improved proposal)."""

from __future__ import annotations

import numpy as np

from robot.compiling import compiled
from robot.geometry import Array
from robot.mapping.grid.cells import Grids, known_ends, measurement_model_map

NEUTRAL = -0.5
"""Log-likelihood of a beam where nobody has looked yet: as of one that fits on average."""
HALVINGS = 6
"""Times that the step is halved."""


@compiled()
def climbed(
    odds: Grids,
    ends: Grids,
    corner: Array,
    cell: float,
    pose: Array,
    met: Array,
    sd: float,
    inverse_sd: Array,
) -> tuple[Array, float]:
    """Return the pose (3,) nearby at which a scan fits best, and its log-likelihood there.

    Hill climbing, step by step along each coordinate, as GMapping does (Grisetti, Stachniss and
    Burgard 2007). So few particles are enough: without it, hardly one of them would be sampled
    where a sharp likelihood is high.

    Args:
        odds: (h, w) as for ``measurement_model_map``, as are those up to ``sd``.
        ends: (h, w, 6)
        corner: (2,) [m]
        cell: [m]
        pose: (3,) as sampled by the motion model.
        met: (n, 2) [m]
        sd: [m]
        inverse_sd: (3,) of the pose as sampled [1/m, 1/m, 1/rad].
    """
    known = known_ends(odds, corner, cell, pose, met)
    met = met[known]
    unknown = NEUTRAL * (len(known) - len(met))
    if not len(met):
        return pose, unknown
    best = pose.copy()
    fit = measurement_model_map(odds, ends, corner, cell, best, met, sd)
    score = fit
    step = np.array([cell, cell, 2 * cell / _reach(met)])
    for _ in range(HALVINGS):
        improved = True
        while improved:
            improved = False
            for axis in range(3):
                for sign in (-1.0, 1.0):
                    moved = best.copy()
                    moved[axis] += sign * step[axis]
                    likelihood = measurement_model_map(odds, ends, corner, cell, moved, met, sd)
                    away = (moved - pose) * inverse_sd
                    total = likelihood - 0.5 * float(np.sum(away * away))
                    if total > score + 1e-9:
                        best, fit, score = moved, likelihood, total
                        improved = True
        step = 0.5 * step
    return best, fit + unknown


@compiled()
def _reach(met: Array) -> float:
    """Return how far away beams typically ended [m]."""
    return max(1e-3, float(np.median(np.hypot(met[:, 0], met[:, 1]))))
