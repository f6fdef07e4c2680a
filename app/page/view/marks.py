"""Forms and colours of what the 3D view marks: ellipses, headings, weights."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from robot.geometry import Array, Pose2, heading_vectors

ESTIMATE = (10, 72, 168)
"""As the page's map has it: --floor-estimate in style/tokens.css."""


def covariance_ellipse(pose: Pose2, covariance: Array, points: int = 40) -> Array:
    """The ellipse (points, 2, 2) [m] that holds 95 % of a normal distribution in x and y."""
    values, axes = np.linalg.eigh(covariance[:2, :2])
    circle = heading_vectors(np.linspace(0, 2 * math.pi, points + 1))
    # 5.991 is the 95 % quantile of chi-square with two degrees of freedom.
    ring = circle * np.sqrt(5.991 * np.maximum(values, 0)) @ axes.T + (pose.x, pose.y)
    return np.stack([ring[:-1], ring[1:]], axis=1)


def hypothesis_mark(pose: Pose2, covariance: Array) -> Array:
    """Lines (n, 2, 2) [m]: the ellipse, and a line from its centre along the heading."""
    ahead = pose.apply(np.array([[0.0, 0.0], [0.08, 0.0]]))
    return np.concatenate([covariance_ellipse(pose, covariance), ahead[None]])


def quaternions(headings: Array) -> Array:
    """Quaternions (n, 4) of turns about z, in the order w, x, y, z."""
    half = heading_vectors(headings / 2)
    nothing = np.zeros(len(headings))
    return np.column_stack([half[:, 0], nothing, nothing, half[:, 1]])


def by_weight(weights: Array) -> NDArray[np.uint8]:
    """Colours (n, 3): from pale for small weights to the estimate's blue."""
    part = (weights / weights.max())[:, None]
    pale = np.array([190, 205, 220])
    colours: NDArray[np.uint8] = (pale + part * (np.array(ESTIMATE) - pale)).astype(np.uint8)
    return colours


def arrow() -> tuple[Array, NDArray[np.uint32]]:
    """A thin triangle along +x, 15 mm long."""
    vertices = np.array([[0.015, 0.0, 0.0], [0.0, 0.0025, 0.0], [0.0, -0.0025, 0.0]])
    return vertices, np.array([[0, 1, 2]], dtype=np.uint32)


def lifted(points: Array, height: float) -> Array:
    """Return floor points (..., 2) as points in space (..., 3)."""
    return np.concatenate([points, np.full((*points.shape[:-1], 1), height)], axis=-1)
