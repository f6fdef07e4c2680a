"""What was measured between poses, and how far that is from where the poses are."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_matrix

from robot.geometry import Array, Pose2, wrap_angle

TAIL = 9.0
"""Squared residual, in deviations, from which on a constraint counts as an outlier (Cauchy)."""


@dataclass(frozen=True, eq=False)
class Constraint:
    """What was measured of one pose from another."""

    begin: int
    """Node in whose frame it was measured."""
    end: int
    moved: Pose2
    """Pose of the end in the start's frame."""
    information: Array = field(repr=False)
    """(3, 3) inverse of its covariance [m, m, rad]; may be singular."""
    by_odometry: bool = False

    @cached_property
    def root(self) -> Array:
        """(3, 3) whose square is the information."""
        values, axes = np.linalg.eigh(self.information)
        rows: Array = np.sqrt(np.maximum(values, 0.0))[:, None] * axes.T
        return rows


@dataclass(frozen=True, eq=False)
class ConstraintArrays:
    """All constraints as arrays."""

    begin: NDArray[np.intp]
    end: NDArray[np.intp]
    moved: Array
    """(m, 3)"""
    root: Array
    """(m, 3, 3); its square is the information."""
    tail: float
    """Squared residual from which on a constraint hardly counts."""

    @classmethod
    def of(cls, constraints: list[Constraint], tail: float = TAIL) -> ConstraintArrays:
        """Gather constraints, of which there has to be at least one."""
        return cls(
            np.array([constraint.begin for constraint in constraints]),
            np.array([constraint.end for constraint in constraints]),
            np.array([constraint.moved.to_array() for constraint in constraints]),
            np.array([constraint.root for constraint in constraints]),
            tail,
        )

    def residuals(self, poses: Array) -> Array:
        """Return how far ends lie from where they were measured (m, 3), in deviations."""
        begin, end = poses[self.begin], poses[self.end]
        c, s = np.cos(begin[:, 2]), np.sin(begin[:, 2])
        dx, dy = (end - begin)[:, :2].T
        away = np.column_stack([c * dx + s * dy, c * dy - s * dx, end[:, 2] - begin[:, 2]])
        away -= self.moved
        away[:, 2] = wrap_angle(away[:, 2])
        return np.asarray(np.einsum("mij,mj->mi", self.root, away))

    def squares(self, residuals: Array) -> Array:
        """Return their squared lengths (m,)."""
        return np.asarray((residuals**2).sum(axis=1))

    def weights(self, residuals: Array) -> Array:
        """Return Cauchy's weights (m,)."""
        return np.asarray(1 / (1 + self.squares(residuals) / self.tail))

    def weighted(self, residuals: Array, weights: Array) -> Array:
        """Return residuals (3 m,) as the Jacobian has them."""
        return np.asarray((residuals * np.sqrt(weights)[:, None]).ravel())

    def cost(self, poses: Array) -> float:
        """Return Cauchy's cost of all residuals."""
        squares = self.squares(self.residuals(poses))
        if np.isinf(self.tail):
            return float(squares.sum())
        return float(self.tail * np.log1p(squares / self.tail).sum())

    def jacobian(self, poses: Array, weights: Array) -> csr_matrix:
        """Return how weighted residuals (3 m, 3 n) change with the poses."""
        begin, end = poses[self.begin], poses[self.end]
        c, s = np.cos(begin[:, 2]), np.sin(begin[:, 2])
        dx, dy = (end - begin)[:, :2].T
        by_begin, by_end = np.zeros((2, len(c), 3, 3))
        by_end[:, 0, 0], by_end[:, 0, 1], by_end[:, 1, 0], by_end[:, 1, 1] = c, s, -s, c
        by_end[:, 2, 2] = 1.0
        by_begin[:, :2, :2] = -by_end[:, :2, :2]
        by_begin[:, 0, 2], by_begin[:, 1, 2] = c * dy - s * dx, -c * dx - s * dy
        by_begin[:, 2, 2] = -1.0
        scaled = np.sqrt(weights)[:, None, None] * self.root
        values = np.concatenate([scaled @ by_begin, scaled @ by_end], axis=2)
        rows = np.repeat(np.arange(3 * len(c)), 6)
        nodes = np.stack([self.begin, self.end], axis=1)
        places = (3 * nodes[:, :, None] + np.arange(3)).reshape(-1, 1, 6)
        columns = np.broadcast_to(places, values.shape).ravel()
        return csr_matrix((values.ravel(), (rows, columns)), shape=(3 * len(c), poses.size))
