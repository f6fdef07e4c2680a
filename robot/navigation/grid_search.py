"""``search``: A* over cells with costs, and ``straighten``, which leaves out needless corners.

Hart, Nilsson and Raphael 1968; eight neighbours, and the octile distance as the estimate of what is
left, which never exceeds it, because no cell costs less than 1.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from robot.compiling import compiled

Costs = NDArray[np.float32]
Cells = NDArray[np.int64]

DIAGONAL = math.sqrt(2.0)
"""The way to a neighbour at a corner, in cells."""
SLACK = 1.01
"""A straight line takes the place of a path if it costs at most this times as much."""
NO_PATH = np.empty((0, 2), np.int64)
"""Of no cell."""


def search(costs: Costs, start: tuple[int, int], goal: tuple[int, int]) -> Cells:
    """Return the cheapest path over cells (n, 2) as rows and columns; (0, 2) if there is none.

    Args:
        costs: (h, w) of a way through a cell of one cell's length, 1 or more; inf is a wall.
        start: row and column.
        goal: row and column.
    """
    height, width = costs.shape
    for row, column in (start, goal):
        if not (0 <= row < height and 0 <= column < width):
            return NO_PATH
    return _search(costs, start[0], start[1], goal[0], goal[1])


def straighten(costs: Costs, path: Cells) -> Cells:
    """Return the corners (m, 2) of a path of straight lines that costs hardly more."""
    return path[_corners(costs, path)]


@compiled()
def _search(costs: Costs, row: int, column: int, goal_row: int, goal_column: int) -> Cells:
    height, width = costs.shape
    begin, end = row * width + column, goal_row * width + goal_column
    flat = costs.ravel()
    if not (math.isfinite(flat[begin]) and math.isfinite(flat[end])):
        return np.empty((0, 2), np.int64)
    way = np.full(height * width, np.inf, np.float32)
    before = np.full(height * width, -1, np.int32)
    done = np.zeros(height * width, np.bool_)
    keys = np.empty(8 * height * width + 8, np.float32)
    cells = np.empty(8 * height * width + 8, np.int32)
    keys[0], cells[0], size = 0.0, begin, 1
    way[begin] = 0.0
    while size > 0 and not done[end]:
        cell = cells[0]
        size -= 1
        _sift_down(keys, cells, size)
        if done[cell]:
            continue
        done[cell] = True
        for place in range(9):
            next_row, next_column = cell // width + place // 3 - 1, cell % width + place % 3 - 1
            if not (0 <= next_row < height and 0 <= next_column < width):
                continue
            neighbour = next_row * width + next_column
            step = 1.0 if place % 2 == 1 else DIAGONAL
            new = way[cell] + np.float32(step * 0.5) * (flat[cell] + flat[neighbour])
            if new < way[neighbour] and math.isfinite(new):
                way[neighbour] = new
                before[neighbour] = cell
                dy, dx = abs(next_row - goal_row), abs(next_column - goal_column)
                left = max(dy, dx) + (DIAGONAL - 1.0) * min(dy, dx)
                _sift_up(keys, cells, size, new + np.float32(left), neighbour)
                size += 1
    return _traced(before, begin, end, width, done[end])


@compiled()
def _traced(before: NDArray[np.int32], begin: int, end: int, width: int, reached: bool) -> Cells:
    """Return the path that ends in a cell, by what comes before each cell."""
    count, cell = 1 if reached else 0, end
    while reached and cell != begin:
        cell = before[cell]
        count += 1
    path = np.empty((count, 2), np.int64)
    cell = end
    for index in range(count - 1, -1, -1):
        path[index, 0], path[index, 1] = cell // width, cell % width
        cell = before[cell]
    return path


@compiled()
def _sift_up(
    keys: NDArray[np.float32], cells: NDArray[np.int32], place: int, key: float, cell: int
) -> None:
    while place > 0:
        parent = (place - 1) // 2
        if keys[parent] <= key:
            break
        keys[place], cells[place] = keys[parent], cells[parent]
        place = parent
    keys[place], cells[place] = key, cell


@compiled()
def _sift_down(keys: NDArray[np.float32], cells: NDArray[np.int32], size: int) -> None:
    """Put the last entry at the top, and let it sink."""
    key, cell, place = keys[size], cells[size], 0
    while True:
        child = 2 * place + 1
        if child >= size:
            break
        if child + 1 < size and keys[child + 1] < keys[child]:
            child += 1
        if keys[child] >= key:
            break
        keys[place], cells[place] = keys[child], cells[child]
        place = child
    keys[place], cells[place] = key, cell


@compiled()
def _line_cost(costs: Costs, row: int, column: int, to_row: int, to_column: int) -> float:
    """Return what a straight line costs, in cells; inf through a wall."""
    length = math.hypot(to_row - row, to_column - column)
    parts = max(1, math.ceil(2.0 * length))
    total = 0.0
    for part in range(parts):
        share = (part + 0.5) / parts
        y, x = row + share * (to_row - row), column + share * (to_column - column)
        total += costs[int(math.floor(y + 0.5)), int(math.floor(x + 0.5))]
    return total * length / parts


@compiled()
def _corners(costs: Costs, path: Cells) -> NDArray[np.int64]:
    count = len(path)
    along = np.zeros(count)
    for index in range(1, count):
        along[index] = along[index - 1] + _line_cost(
            costs, path[index - 1, 0], path[index - 1, 1], path[index, 0], path[index, 1]
        )
    kept = np.empty(count, np.int64)
    kept[0], number, corner = 0, 1, 0
    while corner < count - 1:
        reach = count - 1
        while reach > corner + 1:
            cost = _line_cost(
                costs, path[corner, 0], path[corner, 1], path[reach, 0], path[reach, 1]
            )
            if cost <= SLACK * (along[reach] - along[corner]):
                break
            reach = corner + (reach - corner) // 2
        further = reach + 1
        misses = 0
        while further < count and misses < 8:
            cost = _line_cost(
                costs, path[corner, 0], path[corner, 1], path[further, 0], path[further, 1]
            )
            if cost <= SLACK * (along[further] - along[corner]):
                reach, misses = further, 0
            else:
                misses += 1
            further += 1
        corner = reach
        kept[number] = corner
        number += 1
    return kept[:number]
