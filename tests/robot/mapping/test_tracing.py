"""Centre lines of tape in clouds of middles that pictures saw."""

import math

import numpy as np

from robot.geometry import Array
from robot.mapping.tracing import MiddleCells, Middles, trace


def middles_of(*lines: Array) -> Middles:
    points = np.vstack(lines)
    along = np.concatenate([np.arctan2(*np.gradient(line, axis=0).T[::-1]) for line in lines])
    # Three pictures saw each.
    again = np.tile(points, (3, 1)) + np.repeat([[0, 0], [3e-4, 0], [0, 3e-4]], len(points), axis=0)
    pictures = np.repeat(np.arange(3), len(points))
    return Middles(again, np.mod(np.tile(along, 3), math.pi), pictures)


def test_lines_that_cross_are_two_and_a_ring_is_closed() -> None:
    s = np.linspace(-0.4, 0.4, 100)
    cross = [np.column_stack([s, 0 * s]), np.column_stack([0.02 + 0 * s, s])]
    turns = np.linspace(0, 2 * math.pi, 120)
    ring = np.column_stack([1.0 + 0.15 * np.cos(turns), 0.15 * np.sin(turns)])
    lines = trace(MiddleCells.of(middles_of(*cross, ring), 2, sparse=False))
    assert len(lines) == 3
    closed = [line for line in lines if np.array_equal(line[0], line[-1])]
    assert len(closed) == 1
    assert np.abs(np.hypot(*(closed[0] - (1.0, 0.0)).T) - 0.15).max() < 0.003
    assert sorted(np.ptp(line, axis=0).max() > 0.75 for line in lines) == [False, True, True]


def test_tape_that_is_seen_sparsely_is_one_line_as_well() -> None:
    """Rays meet tape beside the robot each 70 mm, and it drives 30 mm from picture to picture."""
    pictures, rays = np.meshgrid(np.arange(40), np.arange(7), indexing="ij")
    x = (0.03 * pictures + 0.061 * rays).ravel()
    middles = Middles(np.column_stack([x, 0 * x]), 0 * x, pictures.ravel())
    (line,) = trace(MiddleCells.of(middles, 3, sparse=True))
    # At its ends fewer rays meet it.
    assert line[:, 0].min() < 0.2
    assert line[:, 0].max() > x.max() - 0.2
    assert np.abs(line[:, 1]).max() < 1e-9
