"""The cheapest path over cells, compared with an exhaustive search."""

import heapq
import math
from itertools import pairwise

import numpy as np
import pytest

from robot.navigation.grid_search import search, straighten


def cheapest(costs, start, goal):
    """What the cheapest path costs, by Dijkstra's search over everything."""
    best, waiting = {start: 0.0}, [(0.0, start)]
    while waiting:
        way, cell = heapq.heappop(waiting)
        if cell == goal:
            return way
        for down in (-1, 0, 1):
            for right in (-1, 0, 1):
                to = cell[0] + down, cell[1] + right
                if not (0 <= to[0] < costs.shape[0] and 0 <= to[1] < costs.shape[1]):
                    continue
                new = way + math.hypot(down, right) * (costs[cell] + costs[to]) / 2
                if new < best.get(to, math.inf):
                    best[to] = new
                    heapq.heappush(waiting, (new, to))
    return math.inf


def cost_of(costs, path):
    return sum(math.dist(a, b) * (costs[tuple(a)] + costs[tuple(b)]) / 2 for a, b in pairwise(path))


@pytest.mark.parametrize("seed", range(12))
def test_no_path_is_cheaper(seed):
    rng = np.random.default_rng(seed)
    costs = (1 + 4 * rng.random((30, 41))).astype(np.float32)
    costs[rng.random(costs.shape) < 0.3] = np.inf
    costs[0, 0] = costs[-1, -1] = 1.0
    path = search(costs, (0, 0), (29, 40))
    least = cheapest(costs, (0, 0), (29, 40))
    if math.isinf(least):
        assert len(path) == 0
        return
    assert path[0].tolist() == [0, 0]
    assert path[-1].tolist() == [29, 40]
    assert np.abs(np.diff(path, axis=0)).max() == 1
    assert cost_of(costs, path) == pytest.approx(least, rel=1e-4)


@pytest.mark.parametrize("wrong", [(-1, 0), (0, 99), (50, 2), (5, 5)])
def test_a_cell_beyond_the_grid_or_in_a_wall_has_no_path(wrong):
    costs = np.ones((10, 10), np.float32)
    costs[5, 5] = np.inf
    assert len(search(costs, (0, 0), wrong)) == 0
    assert len(search(costs, wrong, (0, 0))) == 0


def test_a_start_that_is_the_goal_is_a_path_of_one_cell():
    assert search(np.ones((4, 4), np.float32), (2, 1), (2, 1)).tolist() == [[2, 1]]


def test_an_open_floor_needs_no_corners():
    costs = np.ones((50, 50), np.float32)
    path = search(costs, (3, 4), (40, 21))
    assert straighten(costs, path).tolist() == [[3, 4], [40, 21]]


def test_corners_stay_around_a_wall():
    costs = np.ones((50, 50), np.float32)
    costs[10:40, 25] = np.inf
    path = search(costs, (25, 5), (25, 45))
    corners = straighten(costs, path)
    assert 3 <= len(corners) <= 5
    assert corners[0].tolist() == [25, 5]
    assert corners[-1].tolist() == [25, 45]
    for a, b in pairwise(corners):
        for share in np.linspace(0, 1, 200):
            row, column = np.floor(a + share * (b - a) + 0.5).astype(int)
            assert np.isfinite(costs[row, column])
