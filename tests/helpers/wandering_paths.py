"""Paths that wander, in the plane and in space, and motions of the world."""

import numpy as np
from scipy.spatial.transform import Rotation

from app.features.lab.trajectories.metrics import motion_errors, relative_pairs
from app.trajectories.trajectory import Trajectory

KINDS = ("planar", "space")


def walk(kind, rng, n=60):
    """A wandering path with uneven stamps."""
    stamps = np.cumsum(rng.uniform(0.02, 0.05, n)) + 1e3
    positions = np.cumsum(rng.normal(0, 0.02, (n, 3)), axis=0)
    turns = np.cumsum(rng.normal(0, 0.1, (n, 3)), axis=0)
    if kind == "planar":
        return Trajectory.of_poses(stamps, np.column_stack([positions[:, :2], turns[:, 2]]))
    return Trajectory(stamps, positions, Rotation.from_rotvec(turns).as_quat())


def noisy(trajectory, rng, spread=0.005):
    kind = "planar" if trajectory.planar else "space"
    noise = walk(kind, rng, len(trajectory))
    turned = Rotation.from_quat(trajectory.quaternions) * Rotation.from_quat(noise.quaternions)
    return Trajectory(
        trajectory.stamps,
        trajectory.positions + spread * noise.positions / 0.02,
        turned.as_quat(),
    )


def rigid(kind, rng):
    """A motion of the world."""
    turn = rng.normal(0, 1, 3) * (0, 0, 1) if kind == "planar" else rng.normal(0, 1, 3)
    shift = rng.uniform(-5, 5, 3) * ((1, 1, 0) if kind == "planar" else 1)
    return Rotation.from_rotvec(turn), shift


def moved(trajectory, motion):
    rotation, shift = motion
    return Trajectory(
        trajectory.stamps,
        trajectory.positions @ rotation.as_matrix().T + shift,
        (rotation * Rotation.from_quat(trajectory.quaternions)).as_quat(),
    )


def pair(kind, seed):
    rng = np.random.default_rng(seed)
    truth = walk(kind, rng)
    return truth, noisy(truth, rng), rng


def relative_errors(truth, estimate, delta, unit):
    return motion_errors(truth, estimate, *relative_pairs(truth, delta, unit))
