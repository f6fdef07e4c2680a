"""Quaternions of the rotation matrices in a file."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.spatial.transform import Rotation

from app.trajectories.trajectory import TrajectoryError
from robot.geometry import Array

SKEWED = 0.05
"""The rows of a rotation matrix are of length 1 and at right angles within this."""


def quaternions_of(turns: Array, lines: Sequence[int], source: str, valid: str) -> Array:
    """Return the quaternions (n, 4) x y z w of matrices (n, 3, 3).

    Args:
        lines: of the file, one for each matrix.
        valid: what a line should hold, for messages.

    Raises:
        TrajectoryError: one is no rotation; names file and line.
    """
    with np.errstate(over="ignore", invalid="ignore"):  # absurd numbers are no rotation either
        skew = np.abs(turns @ turns.transpose(0, 2, 1) - np.eye(3)).max(axis=(1, 2), initial=0)
        wrong = ~(skew <= SKEWED) | ~(np.linalg.det(np.nan_to_num(turns)) > 0)
    if wrong.any():
        line = lines[int(np.argmax(wrong))]
        raise TrajectoryError(f"{source}, line {line}: no rotation; valid are {valid}")
    quaternions: Array = Rotation.from_matrix(turns).as_quat() if len(turns) else np.zeros((0, 4))
    return quaternions
