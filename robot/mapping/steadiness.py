"""How well tape determines the place of a robot, in all directions."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from robot.mapping.strokes import Stroke


def steadiness(strokes: Sequence[Stroke]) -> float:
    """Return how well tape determines the motion that it determines worst, 0 to 1.

    It is the ratio of the smallest to the largest eigenvalue of the information that centre lines
    give about a small motion; a turn counts by how far it moves the tape. It is 0 if some motion
    leaves all tape in place, such as a turn of a circle about its centre.
    """
    lines = [stroke.points for stroke in strokes]
    along = np.vstack([np.diff(line, axis=0) for line in lines])
    middle = np.vstack([(line[1:] + line[:-1]) / 2 for line in lines])
    length = np.hypot(*along.T)
    left = np.column_stack([-along[:, 1], along[:, 0]]) / length[:, None]
    # The ends of a long line determine a turn, too.
    points = np.vstack([middle - along / 3, middle, middle + along / 3])
    normals, weights = np.tile(left, (3, 1)), np.tile(length, 3)
    away = points - np.average(points, axis=0, weights=weights)
    size = np.sqrt(np.average((away**2).sum(axis=1), weights=weights))
    turn = (away[:, 0] * normals[:, 1] - away[:, 1] * normals[:, 0]) / size
    by_motion = np.column_stack([normals, turn]) * np.sqrt(weights)[:, None]
    values = np.linalg.eigvalsh(by_motion.T @ by_motion)
    return float(max(0.0, values[0]) / values[-1])
