"""By how much a step changes the cost of a drive, whichever edges are seen near others after it.

An edge is one of the field's as long as it lies within the gate beside it, and within its length.
Steps of a tenth of a millimetre carry some edges over the end of a line, along it; there they are
as near to the line as before. If each of them cost as much as an edge that is far off, hardly any
step would seem to lower the cost, and the adjustment would stand still far from its end.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from robot.calibration.adjustment import Weights, cost_at_gate
from robot.calibration.normal_equations import CAUCHY, Equations
from robot.calibration.tape_edges import TapeEdges
from robot.geometry import Array


def cost_change(before: Equations, after: Equations, weights: Weights) -> float:
    """Return by how much the cost of a drive changed from some equations to others.

    An edge that is matched in one of both only costs, in the other, what its distance from the
    same line costs there; where that is outside the gate, as much as at its border.

    Args:
        before: those that are compared with; of the same pictures, and edges that may have moved.
        after: the others.
        weights: of both.
    """
    lost, gained = _only_in(before, after), _only_in(after, before)
    change = (after.cost - after.lost_cost) - (before.cost - before.lost_cost)
    change += _elsewhere(before, after, lost, weights)
    change -= _elsewhere(after, before, gained, weights)
    return change


def _only_in(some: Equations, other: Equations) -> NDArray[np.bool_]:
    """Return which of the first's matches (n,) the other one has not."""
    matched = np.zeros(len(some.misses.points), bool)
    matched[other.misses.sighting] = True
    only: NDArray[np.bool_] = ~matched[some.misses.sighting]
    return only


def _elsewhere(
    some: Equations, other: Equations, only_here: NDArray[np.bool_], weights: Weights
) -> float:
    """Return what some matches (n,) cost where their points and edges are in other equations."""
    seen = some.misses
    sighting, edge = seen.sighting[only_here], seen.edge[only_here]
    moved = _beside(other.misses.points[sighting], other.tape, edge)
    moved -= _beside(seen.points[sighting], some.tape, edge)
    metres = seen.metres[only_here] + moved
    costs = CAUCHY**2 * np.log1p((metres / (seen.sd[only_here] * CAUCHY * weights.doubt)) ** 2)
    costs[np.abs(metres) >= weights.gate] = cost_at_gate(weights)
    return float(costs.sum())


def _beside(points: Array, tape: TapeEdges, edge: NDArray[np.int64]) -> Array:
    """Return how far points (n, 2) lie beside edges, led on beyond their ends (n,) [m]."""
    beside: Array = (tape.normals[edge] * (points - tape.edges[edge, :2])).sum(axis=1)
    return beside
