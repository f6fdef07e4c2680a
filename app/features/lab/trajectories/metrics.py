"""Errors of an estimate against the truth, on pairs of poses.

After Sturm, Engelhard, Endres, Burgard, Cremers, A Benchmark for the Evaluation of RGB-D SLAM
Systems, IROS 2012. All functions take pairs, as `association.associate` makes them.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.spatial.transform import Rotation

from app.trajectories.trajectory import Trajectory, TrajectoryError
from robot.geometry import Array, wrap_angle

Unit = Literal["s", "m", "frames"]

RANK = 1e-9
"""A spread this small relative to the largest one counts as zero."""
MUCH = 0.5
"""A scale is free if it leaves no more than this part of the error ..."""
OTHER = 0.05
"""... and if its logarithm differs from 0 by more than this: a smaller difference comes from a
wheel's radius or a lens, not from a unit."""


@dataclass(frozen=True, eq=False)
class Alignment:
    """A rigid motion from the estimate's frame to the truth's frame."""

    rotation: Array
    """(3, 3); about z only if both trajectories are planar."""
    translation: Array
    """(3,) [m]."""

    def apply(self, trajectory: Trajectory) -> Trajectory:
        """Return the trajectory in the truth's frame."""
        turned = Rotation.from_matrix(self.rotation) * Rotation.from_quat(trajectory.quaternions)
        return replace(
            trajectory,
            positions=trajectory.positions @ self.rotation.T + self.translation,
            quaternions=turned.as_quat(),
            lines=None,
        )


def align(truth: Trajectory, estimate: Trajectory) -> Alignment:
    """Return the rigid motion of the estimate that minimizes the sum of squared distances.

    It has no scale (Umeyama, Least-squares estimation of transformation parameters between two
    point patterns, PAMI 1991). It is in the plane if both trajectories are planar, else in space.
    If a path in space lies on one line, the rotation about that line is free: then the smallest
    rotation is taken.

    Raises:
        TrajectoryError: not pairs, or a path stays on one spot, so that no rotation is best.
    """
    _check_pairs(truth, estimate)
    middle, from_middle = truth.positions.mean(axis=0), estimate.positions.mean(axis=0)
    spreads = _spread(truth), _spread(estimate)
    cross = (truth.positions - middle).T @ (estimate.positions - from_middle)
    find = _planar_rotation if truth.planar and estimate.planar else _rotation
    strength, rotation = find(cross)
    if strength <= RANK * spreads[0] * spreads[1]:
        raise TrajectoryError(
            f"{truth.name} and {estimate.name} cannot be aligned: they have no direction in common"
        )
    return Alignment(rotation, middle - rotation @ from_middle)


def _spread(trajectory: Trajectory) -> float:
    """Return the root of the sum of squared distances from the mean position [m].

    Raises:
        TrajectoryError: the spread is only a rounding error.
    """
    spread = float(np.linalg.norm(trajectory.positions - trajectory.positions.mean(axis=0)))
    if spread <= RANK * np.linalg.norm(trajectory.positions) or spread == 0:
        raise TrajectoryError(
            f"{trajectory.name} cannot be aligned: it stays on one spot; valid is a path that moves"
        )
    return spread


def _planar_rotation(cross: Array) -> tuple[float, Array]:
    """Return the length of the sum of products as a complex number, and the rotation about z.

    The rotation is by the angle of that sum.
    """
    along = cross[0, 0] + cross[1, 1]
    aside = cross[1, 0] - cross[0, 1]
    rotation = Rotation.from_euler("z", np.arctan2(aside, along)).as_matrix()
    return float(np.hypot(along, aside)), rotation


def _rotation(cross: Array) -> tuple[float, Array]:
    """Return the largest singular value, and the rotation in space."""
    u, values, v = np.linalg.svd(cross)
    if values[1] <= RANK * values[0]:
        least, _ = Rotation.align_vectors(u[:, :1].T, v[:1])
        return float(values[0]), least.as_matrix()
    # A reflection is not a rigid motion: flip the weakest axis instead.
    signs = np.array([1.0, 1.0, np.sign(np.linalg.det(u) * np.linalg.det(v))])
    return float(values[0]), (u * signs) @ v


def absolute_errors(truth: Trajectory, estimate: Trajectory) -> Array:
    """Return the distances (n,) [m] between the positions of each pair.

    Raises:
        TrajectoryError: not pairs.
    """
    _check_pairs(truth, estimate)
    distances: Array = np.linalg.norm(estimate.positions - truth.positions, axis=1)
    return distances


def ate_rmse(truth: Trajectory, estimate: Trajectory, aligned: bool = False) -> float:
    """Return the root mean square [m] of the absolute errors, unaligned or after `align`.

    Raises:
        TrajectoryError: not pairs, or they cannot be aligned.
    """
    if aligned:
        estimate = align(truth, estimate).apply(estimate)
    return rms(absolute_errors(truth, estimate))


def rms(errors: ArrayLike) -> float:
    """Return the root mean square."""
    return float(np.sqrt(np.mean(np.square(errors))))


def heading_errors(truth: Trajectory, estimate: Trajectory) -> Array:
    """Return the angles (n,) [rad] from the true rotation to the estimated one.

    If both trajectories are planar, angles have a sign, in [-pi, pi), anticlockwise; else they are
    the angle of the rotation between the two, in [0, pi].

    Raises:
        TrajectoryError: not pairs.
    """
    _check_pairs(truth, estimate)
    if truth.planar and estimate.planar:
        return wrap_angle(estimate.poses[:, 2] - truth.poses[:, 2])
    return _angles(_rotations(truth).inv() * _rotations(estimate))


def motion_errors(
    truth: Trajectory, estimate: Trajectory, i: NDArray[np.int64], j: NDArray[np.int64]
) -> tuple[Array, Array]:
    """Return the errors of the motion from poses i (k,) to j (k,), as `relative_pairs` finds them.

    Translation (k,) [m] and rotation (k,) [rad] of
    E = (Q_i^-1 Q_j)^-1 (P_i^-1 P_j), Q true and P estimated.
    """
    (moved, turned), (true_moved, true_turned) = _motions(estimate, i, j), _motions(truth, i, j)
    translation: Array = np.linalg.norm(moved - true_moved, axis=1)
    return translation, _angles(true_turned.inv() * turned)


def relative_pairs(
    truth: Trajectory, delta: float, unit: Unit, tolerance: float = 0.1
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Find for each pose i the later pose j whose time or path length from i is nearest to delta.

    Args:
        truth: the trajectory whose times and path lengths count.
        delta: time [s], path length [m] or number of poses.
        unit: "s", "m" or "frames".
        tolerance: i is left out if j is off by more than this part of delta; a number of poses is
            exact.

    Returns:
        Indices i and j (k,).
    """
    if not (delta > 0 and tolerance >= 0):
        raise ValueError(f"delta {delta:g}, tolerance {tolerance:g}; valid are positive ones")
    along = _ALONG[unit](truth)
    i = np.arange(len(along) - 1)
    goal = along[:-1] + delta
    # Take the earliest of equal values: the path length stays equal while the robot stands.
    after = np.minimum(np.searchsorted(along, goal, side="left"), len(along) - 1)
    before = np.searchsorted(along, along[np.maximum(after - 1, 0)], side="left")
    after, before = np.maximum(after, i + 1), np.maximum(before, i + 1)
    off_after = np.abs(along[after] - along[:-1] - delta)
    off_before = np.abs(along[before] - along[:-1] - delta)
    j = np.where(off_before <= off_after, before, after)
    most = 0.0 if unit == "frames" else tolerance * delta
    kept = np.minimum(off_before, off_after) <= most
    return i[kept], j[kept]


def _way(trajectory: Trajectory) -> Array:
    """Return the path length (n,) [m] up to each pose."""
    steps = np.linalg.norm(np.diff(trajectory.positions, axis=0), axis=1)
    return np.concatenate([[0.0], np.cumsum(steps)])


_ALONG: dict[Unit, Callable[[Trajectory], Array]] = {
    "s": lambda trajectory: trajectory.stamps - trajectory.stamps[0],
    "m": _way,
    "frames": lambda trajectory: np.arange(len(trajectory), dtype=np.float64),
}


def _motions(
    trajectory: Trajectory, i: NDArray[np.int64], j: NDArray[np.int64]
) -> tuple[Array, Rotation]:
    """Return the motions from poses i to j, seen from i: translations (k, 3) and rotations."""
    rotations = _rotations(trajectory)
    back = rotations[i].inv()
    return back.apply(trajectory.positions[j] - trajectory.positions[i]), back * rotations[j]


def _rotations(trajectory: Trajectory) -> Rotation:
    return Rotation.from_quat(trajectory.quaternions)


def _angles(rotations: Rotation) -> Array:
    """Return the angle (n,) [rad] of each rotation, in [0, pi]."""
    return np.asarray(rotations.magnitude(), dtype=np.float64)


def _check_pairs(truth: Trajectory, estimate: Trajectory) -> None:
    if len(truth) != len(estimate):
        raise TrajectoryError(
            f"{truth.name} has {len(truth)} poses and {estimate.name} {len(estimate)}; "
            "valid are pairs, as `associate` makes them"
        )


@dataclass(frozen=True, slots=True)
class ScaleFit:
    """The similarity transform, Sim(3), compared with the rigid motion."""

    scale: float
    """The factor to multiply the estimate's positions by."""
    rigid: float
    """Root mean square error [m] after the best rigid motion."""
    scaled: float
    """The same with the scale."""

    @property
    def is_free(self) -> bool:
        """Whether the estimate seems to have a scale of its own instead of metres."""
        return self.scaled <= MUCH * self.rigid and abs(math.log(self.scale)) > OTHER


def fit_scale(truth: Trajectory, estimate: Trajectory) -> ScaleFit:
    """Fit the scale by least squares, after Umeyama (PAMI 1991), equations 40 to 42.

    The best rotation is the same with and without a scale, so it is taken from `align`; then
    c = sum p_i . q_i / sum |q_i|^2, with p the true and q the aligned positions, each relative to
    its mean.

    Raises:
        TrajectoryError: not pairs, or they cannot be aligned.
    """
    aligned = align(truth, estimate).apply(estimate)
    true = truth.positions - truth.positions.mean(axis=0)
    result = aligned.positions - aligned.positions.mean(axis=0)
    scale = float(np.sum(true * result) / np.sum(result**2))
    scaled = rms(np.linalg.norm(scale * result - true, axis=1))
    return ScaleFit(scale, ate_rmse(truth, aligned), scaled)
