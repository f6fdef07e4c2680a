"""A graph of poses and of what was measured between them, adjusted by least squares.

Gauss-Newton on sparse normal equations (Grisetti, Kümmerle, Stachniss and Burgard 2010). A direct
solution also has the covariance, which says where loops have to be looked for.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csc_matrix, csr_matrix
from scipy.sparse.linalg import SuperLU, splu

from robot.geometry import Array, Pose2, wrap_angle

STEPS = 30
"""Most Gauss-Newton steps."""
HALVINGS = 6
"""Times that a step is halved at most."""
TAIL = 9.0
"""Squared residual, in deviations, from which on an edge counts as an outlier (Cauchy)."""
CONVERGED = 1e-5
"""Largest change [m, rad] of a last step."""


@dataclass(frozen=True, eq=False)
class Edge:
    """What was measured of one pose from another."""

    begin: int
    """Node in whose frame it was measured."""
    end: int
    moved: Pose2
    """Pose of the end in the begin's frame."""
    information: Array = field(repr=False)
    """(3, 3) inverse of its covariance [m, m, rad]; may be singular."""
    by_odometry: bool = False

    @cached_property
    def root(self) -> Array:
        """(3, 3) whose square is the information."""
        values, axes = np.linalg.eigh(self.information)
        rows: Array = np.sqrt(np.maximum(values, 0.0))[:, None] * axes.T
        return rows


class PoseGraph:
    """Poses, the first of which is held, and edges between them."""

    def __init__(self, start: Pose2) -> None:
        """Begin with one pose."""
        self.poses: Array = start.to_array()[None]
        """(n, 3) [m, m, rad]"""
        self.edges: list[Edge] = []
        self._solved: SuperLU | None = None

    def add_pose(self, pose: Pose2) -> int:
        """Add a pose, and return its node."""
        self.poses = np.vstack([self.poses, pose.to_array()])
        self._solved = None
        return len(self.poses) - 1

    def pose(self, node: int) -> Pose2:
        """Return the pose of a node."""
        return Pose2.from_array(self.poses[node])

    def add_edge(self, edge: Edge) -> None:
        """Add what was measured between two poses."""
        self.edges.append(edge)
        self._solved = None

    def keep_edges(self, kept: list[Edge]) -> None:
        """Drop all other edges."""
        self.edges = kept
        self._solved = None

    def adjust(self, tail: float = TAIL) -> None:
        """Move the poses to where they fit what was measured.

        Args:
            tail: squared residual from which on an edge hardly counts; infinite if all count.
        """
        if not self.edges:
            return
        parts = _Parts.of(self.edges, tail)
        cost = parts.cost(self.poses)
        for _ in range(STEPS):
            residuals = parts.residuals(self.poses)
            jacobian = parts.jacobian(self.poses, parts.weights(residuals))
            pull = jacobian.T @ parts.whitened(residuals, parts.weights(residuals))
            step = np.zeros(self.poses.size)
            step[3:] = -_factorized(jacobian).solve(pull[3:])
            ahead, length = self.poses + step.reshape(-1, 3), 1.0
            while parts.cost(ahead) > cost + 1e-9 and length > 0.5**HALVINGS:
                length *= 0.5
                ahead = self.poses + length * step.reshape(-1, 3)
            if parts.cost(ahead) > cost + 1e-9:
                break
            cost, self.poses = parts.cost(ahead), ahead
            if np.abs(length * step).max() < CONVERGED:
                break
        self.poses[:, 2] = wrap_angle(self.poses[:, 2])
        self._solved = None

    def squares(self) -> Array:
        """Return the squared residual (m,) of each edge, in deviations."""
        parts = _Parts.of(self.edges)
        return parts.squares(parts.residuals(self.poses))

    def covariance(self, node: int, other: int) -> Array:
        """Return the covariance (3, 3) of a node's pose in another's frame [m, m, rad]."""
        if self._solved is None:
            parts = _Parts.of(self.edges)
            weights = parts.weights(parts.residuals(self.poses))
            self._solved = _factorized(parts.jacobian(self.poses, weights))
        unknown = self._solved.shape[0]
        sides = np.zeros((unknown, 6))
        for column, place in ((0, other), (3, node)):
            if place:
                rows = range(3 * place - 3, 3 * place)
                sides[rows, range(column, column + 3)] = 1.0
        # The change of the end's pose with both poses, times their joint covariance.
        pair = Edge(other, node, Pose2(), np.eye(3))
        change = _Parts.of([pair]).jacobian(self.poses, np.ones(1)).toarray()[:, 3:]
        relative: Array = change @ self._solved.solve(np.ascontiguousarray(change.T))
        return (relative + relative.T) / 2


def _factorized(jacobian: csr_matrix) -> SuperLU:
    """Return J^T J, factorized, without the first pose, which is held."""
    free = jacobian[:, 3:]
    normal = csc_matrix(free.T @ free)
    # Not even a node that nothing tells of may be singular.
    normal.setdiag(normal.diagonal() + 1e-6)
    return splu(normal, permc_spec="MMD_AT_PLUS_A", options={"SymmetricMode": True})


@dataclass(frozen=True)
class _Parts:
    """All edges as arrays."""

    begin: NDArray[np.intp]
    end: NDArray[np.intp]
    moved: Array
    """(m, 3)"""
    root: Array
    """(m, 3, 3); its square is the information."""
    tail: float

    @classmethod
    def of(cls, edges: list[Edge], tail: float = TAIL) -> _Parts:
        return cls(
            np.array([edge.begin for edge in edges]),
            np.array([edge.end for edge in edges]),
            np.array([edge.moved.to_array() for edge in edges]),
            np.array([edge.root for edge in edges]),
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
        return np.asarray((residuals**2).sum(axis=1))

    def weights(self, residuals: Array) -> Array:
        """Return Cauchy's weights (m,)."""
        return np.asarray(1 / (1 + self.squares(residuals) / self.tail))

    def whitened(self, residuals: Array, weights: Array) -> Array:
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
