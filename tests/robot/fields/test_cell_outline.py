"""The outline of dark cells: they lie on its left, and its runs are as long as they can be."""

import numpy as np
from hypothesis import given, settings
from hypothesis.extra.numpy import array_shapes, arrays

from robot.fields.cell_outline import cell_outline
from robot.fields.edges import sample


def area_to_the_left(edges):
    """By the shoelace formula."""
    return (edges[:, 0] * edges[:, 3] - edges[:, 2] * edges[:, 1]).sum() / 2


def test_nothing_dark_has_no_outline():
    assert cell_outline(np.zeros((3, 4), bool)).shape == (0, 4)


def test_a_block_of_cells_has_four_edges():
    dark = np.zeros((5, 6), bool)
    dark[1:4, 2:6] = True
    edges = cell_outline(dark)
    corners = {(2, 1), (6, 1), (6, 4), (2, 4)}
    assert len(edges) == 4
    assert {tuple(edge[:2]) for edge in edges} == corners
    assert area_to_the_left(edges) == 12


@settings(deadline=None)
@given(arrays(np.bool_, array_shapes(min_dims=2, max_dims=2, max_side=9)))
def test_cell_edges_separate_dark_cells_on_their_left_from_light_ones(dark):
    edges = cell_outline(dark)
    assert area_to_the_left(edges) == dark.sum()
    padded = np.pad(dark, 1)
    points, across = sample(edges, 1.0)
    column, row = np.floor(points - across / 2).astype(int).T + 1
    assert padded[row, column].all()
    column, row = np.floor(points + across / 2).astype(int).T + 1
    assert not padded[row, column].any()
    borders = (padded[1:] != padded[:-1]).sum() + (padded[:, 1:] != padded[:, :-1]).sum()
    assert len(points) == borders


@settings(deadline=None)
@given(arrays(np.bool_, array_shapes(min_dims=2, max_dims=2, max_side=9)))
def test_runs_of_cell_edges_are_merged(dark):
    edges = cell_outline(dark)
    ends = {tuple(edge) for edge in edges}
    for x0, y0, x1, y1 in edges:
        step = np.sign([x1 - x0, y1 - y0])
        followers = [e for e in ends if e[:2] == (x1, y1)]
        assert not any((np.sign([e[2] - e[0], e[3] - e[1]]) == step).all() for e in followers)
