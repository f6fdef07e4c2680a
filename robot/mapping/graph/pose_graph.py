"""A graph of poses and of what was measured between them, adjusted by least squares.

Gauss-Newton on sparse normal equations (Grisetti, Kümmerle, Stachniss and Burgard 2010). A direct
solution also has the covariance, which says where loops have to be looked for.
"""

from __future__ import annotations

import math
from collections.abc import Iterable

import numpy as np
from scipy.sparse import csc_matrix, csr_matrix
from scipy.sparse.linalg import SuperLU, splu

from robot.estimation.fit_quality import FitQuality
from robot.geometry import Array, Pose2, wrap_angle
from robot.mapping.graph.constraints import TAIL, Constraint, ConstraintArrays

STEPS = 30
"""Most Gauss-Newton steps."""
HALVINGS = 6
"""Times that a step is halved at most."""
MEDIAN_OF_SQUARES = 2.366
"""Median of the sum of the squares of three standard normal numbers."""
CONVERGED = 1e-5
"""Largest change [m, rad] of a last step."""


class PoseGraph:
    """Poses, the first of which is held, and constraints between them."""

    def __init__(self, start: Pose2) -> None:
        """Begin with one pose."""
        self.poses: Array = start.to_array()[None]
        """(n, 3) [m, m, rad]"""
        self.constraints: list[Constraint] = []
        self.converged = True
        """Whether a further step of the last adjustment would have changed nothing."""
        self._solved: SuperLU | None = None

    def add_pose(self, pose: Pose2) -> int:
        """Add a pose, and return its node."""
        self.poses = np.vstack([self.poses, pose.to_array()])
        self._solved = None
        return len(self.poses) - 1

    def pose(self, node: int) -> Pose2:
        """Return the pose of a node."""
        return Pose2.from_array(self.poses[node])

    def add_constraints(self, constraints: Iterable[Constraint]) -> None:
        """Add what was measured between poses."""
        self.constraints += constraints
        self._solved = None

    def keep_constraints(self, kept: list[Constraint]) -> None:
        """Drop all other constraints."""
        self.constraints = kept
        self._solved = None

    def adjust(self, tail: float = TAIL) -> None:
        """Move the poses to where they fit what was measured.

        Args:
            tail: squared residual from which on a constraint hardly counts; infinite if all count.
        """
        if not self.constraints:
            return
        parts = ConstraintArrays.of(self.constraints, tail)
        cost = parts.cost(self.poses)
        for _ in range(STEPS):
            residuals = parts.residuals(self.poses)
            jacobian = parts.jacobian(self.poses, parts.weights(residuals))
            pull = jacobian.T @ parts.weighted(residuals, parts.weights(residuals))
            step = np.zeros(self.poses.size)
            step[3:] = -_factorized(jacobian).solve(pull[3:])
            ahead, length = self.poses + step.reshape(-1, 3), 1.0
            while parts.cost(ahead) > cost + 1e-9 and length > 0.5**HALVINGS:
                length *= 0.5
                ahead = self.poses + length * step.reshape(-1, 3)
            # Where no step leads lower, there is nothing lower.
            self.converged = parts.cost(ahead) > cost + 1e-9
            if self.converged:
                break
            cost, self.poses = parts.cost(ahead), ahead
            self.converged = bool(np.abs(length * step).max() < CONVERGED)
            if self.converged:
                break
        self.poses[:, 2] = wrap_angle(self.poses[:, 2])
        self._solved = None

    @property
    def quality(self) -> FitQuality:
        """How well the poses fit what was measured between them.

        Neighbours are not compared: what a loop corrects is spread over all steps of odometry.
        """
        if not self.constraints:
            return FitQuality(math.nan)
        parts = ConstraintArrays.of(self.constraints)
        residuals = parts.residuals(self.poses)
        spread = math.sqrt(float(np.median(parts.squares(residuals))) / MEDIAN_OF_SQUARES)
        return FitQuality(spread, self.converged)

    def squares(self, constraints: list[Constraint]) -> Array:
        """Return the squared residuals (m,) of constraints, in deviations."""
        parts = ConstraintArrays.of(constraints)
        return parts.squares(parts.residuals(self.poses))

    def covariance(self, node: int, other: int, own: Array | None = None) -> Array:
        """Return the covariance (3, 3) of a node's pose in another's frame [m, m, rad].

        Args:
            node: whose pose it is.
            other: from where it is seen.
            own: (3, 3) what each of both poses is uncertain by besides, which no constraint shows.
        """
        if self._solved is None:
            parts = ConstraintArrays.of(self.constraints)
            weights = parts.weights(parts.residuals(self.poses))
            self._solved = _factorized(parts.jacobian(self.poses, weights))
        unknown = self._solved.shape[0]
        sides = np.zeros((unknown, 6))
        for column, place in ((0, other), (3, node)):
            if place:
                rows = range(3 * place - 3, 3 * place)
                sides[rows, range(column, column + 3)] = 1.0
        # The change of the end's pose with both poses, times their joint covariance.
        pair = Constraint(other, node, Pose2(), np.eye(3))
        both = ConstraintArrays.of([pair]).jacobian(self.poses, np.ones(1)).toarray()
        change = both[:, 3:]
        relative: Array = change @ self._solved.solve(np.ascontiguousarray(change.T))
        for place in (node, other) if own is not None and node != other else ():
            turn = both[:, 3 * place : 3 * place + 3]
            relative = relative + turn @ own @ turn.T
        return (relative + relative.T) / 2


def _factorized(jacobian: csr_matrix) -> SuperLU:
    """Return J^T J, factorized, without the first pose, which is held."""
    free = jacobian[:, 3:]
    normal = csc_matrix(free.T @ free)
    # Not even a node that nothing tells of may be singular.
    normal.setdiag(normal.diagonal() + 1e-6)
    return splu(normal, permc_spec="MMD_AT_PLUS_A", options={"SymmetricMode": True})
