"""Whether tape tells where a robot is, in all directions."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from robot.mapping.strokes import Stroke


def steadiness(strokes: Sequence[Stroke]) -> float:
    """Return how well tape tells the motion that it tells least, 0 to 1.

    It is 0 if there is a motion that leaves all tape where it is, such as a turn of a circle: the
    ratio of the eigenvalues of what the centre lines tell of a small motion, in which a turn counts
    by how far it moves the tape.
    """
    lines = [stroke.points for stroke in strokes]
    along = np.vstack([np.diff(line, axis=0) for line in lines])
    middle = np.vstack([(line[1:] + line[:-1]) / 2 for line in lines])
    length = np.hypot(*along.T)
    left = np.column_stack([-along[:, 1], along[:, 0]]) / length[:, None]
    # A long line tells a turn by its ends, too.
    points = np.vstack([middle - along / 3, middle, middle + along / 3])
    normals, weights = np.tile(left, (3, 1)), np.tile(length, 3)
    away = points - np.average(points, axis=0, weights=weights)
    size = np.sqrt(np.average((away**2).sum(axis=1), weights=weights))
    turn = (away[:, 0] * normals[:, 1] - away[:, 1] * normals[:, 0]) / size
    by_motion = np.column_stack([normals, turn]) * np.sqrt(weights)[:, None]
    values = np.linalg.eigvalsh(by_motion.T @ by_motion)
    return float(max(0.0, values[0]) / values[-1])
