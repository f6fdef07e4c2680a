"""``plan_in_headings``: ways of a robot that cannot turn on the spot, ahead and backwards.

Hybrid A* (Dolgov et al. 2010): A* over places and headings, whose steps are arcs of the smallest
radius and straight lines; from time to time the shortest arcs to the goal are tried, so that it
ends there exactly.
"""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from robot.compiling import compiled
from robot.geometry import Array, Pose2
from robot.navigation.dubins import along_arcs, shortest_arcs
from robot.navigation.free_space import COST_WEIGHT, FreeSpace
from robot.navigation.grid_search import _sift_down, _sift_up
from robot.navigation.legs import STEP, WayLeg, straight
from robot.navigation.planning import GATES, NoWayError, comes_no_nearer, require_joined

HEADINGS = 36
"""Headings are told apart to 10 degrees."""
CELL = 2
"""Places are told apart to so many cells of the grid."""
STRIDE_CELLS = 5
"""Length of a step in cells, so that each leads into another place or heading."""
BACKWARDS_COST, SWITCH_M, BEND_COST = 1.5, 0.15, 1.05
"""A way backwards counts so many times, a change of direction so far, and a bend so many times."""
SHOT_EVERY = 12
"""The shortest arcs to the goal are tried from every so many places."""
MOVES = 6
"""Steps from each place: ahead to the right, straight and to the left, and backwards the same."""
MOST_PLACES = 400_000
"""The search ends after so many, and says that it has found nothing."""
FRINGE = 1e-6


def plan_in_headings(free: FreeSpace, start: Pose2, goal: Pose2) -> tuple[WayLeg, ...]:
    """Return legs from a start to a goal without a turn on the spot.

    Raises:
        NoWayError: a wall is at the goal, or no way was found.
    """
    require_joined(free, start, goal)
    if start.distance_to(goal) < STEP / 5 and abs(start.turn_to(goal)) < 0.02:
        return ()
    settings = free.settings
    leaving, begin = _left_wall(free, start)
    # Where that does not help, it keeps what room it has.
    room = float(free.room(begin.to_array()[None])[0])
    clearance = min(settings.clearance, room - FRINGE)
    path = _hybrid(
        free.distance,
        np.array([free.origin[0], free.origin[1], free.side]),
        np.ascontiguousarray(free.hollow.body),
        np.array([free.radius, clearance, settings.minimum_turning_radius]),
        _ways_left(_passages(free), *free.cell(goal.x, goal.y)),
        settings.resolution,
        begin.to_array(),
        goal.to_array(),
    )
    if not len(path):
        raise NoWayError(
            "no way was found on which the robot need not turn on the spot; valid is a smaller "
            "minimum_turning_radius, or another planner"
        )
    return (*leaving, *_legs(path))


def _left_wall(free: FreeSpace, start: Pose2) -> tuple[tuple[WayLeg, ...], Pose2]:
    """Return the shortest straight way from beside a wall, or from one, to where the robot fits.

    Raises:
        NoWayError: the robot stands in a wall, and no straight way leads out of it.
    """
    if free.fits(start.to_array()[None]):
        return (), start
    for distance in sorted(GATES[1:], key=abs):
        leg = straight(start, distance)
        if free.fits(leg.end.to_array()[None]) and comes_no_nearer(free, leg, start):
            return (leg,), leg.end
    if free.stands_in_wall(start):
        raise NoWayError("the robot stands on a wall, and no straight way leads away from it")
    return (), start


def _passages(free: FreeSpace) -> NDArray[np.float32]:
    """Return costs (h, w) of cells; inf where the robot fits in no heading."""
    height, width = free.shape
    resolution = free.settings.resolution
    rows, columns = np.mgrid[:height, :width] + 0.5
    points = np.column_stack([columns.ravel(), rows.ravel()]) * resolution + free.origin
    distance = free.clearance(points).reshape(height, width)
    near = np.exp(-free.settings.cost_scaling_factor * distance)
    return np.where(distance <= 0, np.inf, 1 + COST_WEIGHT * near).astype(np.float32)


def _legs(path: Array) -> tuple[WayLeg, ...]:
    """Return legs of a path (n, 4): poses, and whether each was reached ahead (1) or not (-1)."""
    poses = path[:, :3].copy()
    poses[:, 2] = np.unwrap(poses[:, 2])
    changes = np.flatnonzero(np.diff(path[1:, 3])) + 1
    borders = [0, *changes.tolist(), len(path) - 1]
    return tuple(
        WayLeg(poses[low : high + 1], backwards=bool(path[high, 3] < 0))
        for low, high in pairwise(borders)
    )


@compiled()
def _ways_left(costs: NDArray[np.float32], goal_row: int, goal_column: int) -> NDArray[np.float32]:
    """Return what the way from each cell to the goal's costs, in cells; inf without one."""
    height, width = costs.shape
    left = np.full(height * width, np.inf, np.float32)
    flat = costs.ravel()
    keys = np.empty(8 * height * width + 8, np.float32)
    cells = np.empty(8 * height * width + 8, np.int32)
    end = goal_row * width + goal_column
    keys[0], cells[0], size = 0.0, end, 1
    left[end] = 0.0
    while size > 0:
        key, cell = keys[0], cells[0]
        size -= 1
        _sift_down(keys, cells, size)
        if key > left[cell]:
            continue
        for place in range(9):
            row, column = cell // width + place // 3 - 1, cell % width + place % 3 - 1
            if not (0 <= row < height and 0 <= column < width):
                continue
            neighbour = row * width + column
            step = 1.0 if place % 2 == 1 else math.sqrt(2.0)
            new = left[cell] + np.float32(step * 0.5) * (flat[cell] + flat[neighbour])
            if new < left[neighbour]:
                left[neighbour] = new
                _sift_up(keys, cells, size, new, neighbour)
                size += 1
    return left.reshape(height, width)


@compiled()
def _fits(
    distance: NDArray[np.float32],
    grid: Array,
    body: Array,
    sizes: Array,
    x: float,
    y: float,
    theta: float,
) -> bool:
    """Whether the outline keeps its clearance at a pose."""
    rows, columns = distance.shape
    radius, clearance = sizes[0], sizes[1]
    column, row = int((x - grid[0]) / grid[2]), int((y - grid[1]) / grid[2])
    if x < grid[0] or y < grid[1] or row >= rows or column >= columns:
        return False
    if distance[row, column] >= radius + clearance:
        return True
    cos, sin = math.cos(theta), math.sin(theta)
    for point in range(len(body)):
        px = x + cos * body[point, 0] - sin * body[point, 1]
        py = y + sin * body[point, 0] + cos * body[point, 1]
        if px < grid[0] or py < grid[1]:
            return False
        column, row = int((px - grid[0]) / grid[2]), int((py - grid[1]) / grid[2])
        if row >= rows or column >= columns or distance[row, column] < clearance:
            return False
    return True


@compiled()
def _all_fit(
    distance: NDArray[np.float32], grid: Array, body: Array, sizes: Array, poses: Array
) -> bool:
    for place in range(len(poses)):
        x, y, theta = poses[place, 0], poses[place, 1], poses[place, 2]
        if not _fits(distance, grid, body, sizes, x, y, theta):
            return False
    return True


@compiled()
def _hybrid(
    distance: NDArray[np.float32],
    grid: Array,
    body: Array,
    sizes: Array,
    left: NDArray[np.float32],
    resolution: float,
    start: Array,
    goal: Array,
) -> Array:
    """Return the path (n, 4): x, y, theta and direction; (0, 4) if none was found.

    Args:
        distance: to walls [m].
        grid: its origin and the side of its cells [m].
        body: (k, 2) points of the robot [m].
        sizes: its radius, the clearance and the smallest radius of its bends [m].
        left: the estimate of what is left from each cell, in cells.
        resolution: side of those cells [m].
        start: (3,) pose.
        goal: (3,) pose.
    """
    bend, stride = sizes[2], STRIDE_CELLS * resolution
    height, width = left.shape[0] // CELL + 1, left.shape[1] // CELL + 1
    states = height * width * HEADINGS
    way = np.full(states, np.inf, np.float32)
    done = np.zeros(states, np.bool_)
    poses = np.empty((MOST_PLACES, 4))
    before = np.full(MOST_PLACES, -1, np.int64)
    cost = np.empty(MOST_PLACES, np.float32)
    keys = np.empty(MOST_PLACES + 8, np.float32)
    heap = np.empty(MOST_PLACES + 8, np.int32)
    poses[0, 0], poses[0, 1], poses[0, 2], poses[0, 3] = start[0], start[1], start[2], 0.0
    cost[0], count, size, popped = 0.0, 1, 1, 0
    keys[0], heap[0] = 0.0, 0
    while size > 0:
        node = heap[0]
        size -= 1
        _sift_down(keys, heap, size)
        x, y, theta, direction = poses[node]
        state = _state(grid, resolution, x, y, theta, height, width)
        if state < 0 or done[state]:
            continue
        done[state] = True
        popped += 1
        if popped % SHOT_EVERY == 1:
            path = _shot(distance, grid, body, sizes, poses, before, node, goal)
            if len(path) > 0:
                return path
        for move in range(MOVES):
            to_x, to_y, to_theta, half_x, half_y, half_theta = _moved(
                x, y, theta, move, stride, bend
            )
            to_state = _state(grid, resolution, to_x, to_y, to_theta, height, width)
            if to_state < 0 or done[to_state] or count >= MOST_PLACES:
                continue
            near = _left_at(left, grid, resolution, to_x, to_y)
            new = np.float32(cost[node] + _price(move, direction, stride))
            if (
                not math.isfinite(near) or new >= way[to_state]
                or not _fits(distance, grid, body, sizes, to_x, to_y, to_theta)
                or not _fits(distance, grid, body, sizes, half_x, half_y, half_theta)
            ):  # fmt: skip
                continue
            way[to_state] = new
            poses[count, 0], poses[count, 1] = to_x, to_y
            poses[count, 2], poses[count, 3] = to_theta, _side(move)
            before[count], cost[count] = node, new
            _sift_up(keys, heap, size, float(new + np.float32(near * resolution)), count)
            size += 1
            count += 1
    return np.empty((0, 4))


@compiled()
def _side(move: int) -> float:
    """Return 1 of a step ahead and -1 of one backwards."""
    return 1.0 if move < MOVES // 2 else -1.0


@compiled()
def _moved(
    x: float, y: float, theta: float, move: int, stride: float, bend: float
) -> tuple[float, float, float, float, float, float]:
    """Return the pose after a step, and the one about half of it: right, straight or left."""
    ahead, bends, turn = _side(move), float(move % 3 - 1), stride / bend
    angle = ahead * bends * turn
    chord = stride if bends == 0 else stride * math.sin(turn / 2) / (turn / 2)
    to_x = x + ahead * chord * math.cos(theta + angle / 2)
    to_y = y + ahead * chord * math.sin(theta + angle / 2)
    half = ahead * chord / 2
    half_x, half_y = x + half * math.cos(theta), y + half * math.sin(theta)
    return to_x, to_y, theta + angle, half_x, half_y, theta + angle / 2


@compiled()
def _price(move: int, direction: float, stride: float) -> float:
    """Return what a step counts after one in a direction: 1 ahead, -1 backwards, 0 for none."""
    length = stride * (BEND_COST if move % 3 != 1 else 1.0)
    length *= 1.0 if _side(move) > 0 else BACKWARDS_COST
    return length + (SWITCH_M if direction * _side(move) < 0 else 0.0)


@compiled()
def _left_at(
    left: NDArray[np.float32], grid: Array, resolution: float, x: float, y: float
) -> float:
    """Return the estimate of what is left at a place, in cells; inf without a way."""
    row, column = int((y - grid[1]) / resolution), int((x - grid[0]) / resolution)
    if not (0 <= row < left.shape[0] and 0 <= column < left.shape[1]):
        return float(np.inf)
    return float(left[row, column])


@compiled()
def _shot(
    distance: NDArray[np.float32],
    grid: Array,
    body: Array,
    sizes: Array,
    poses: Array,
    before: NDArray[np.int64],
    node: int,
    goal: Array,
) -> Array:
    """Return the path to a node and on by the shortest arcs to the goal; (0, 4) if none is free."""
    bend, middle = sizes[2], np.empty(3)
    x, y, theta, direction = poses[node]
    # Ahead by arcs, or backwards by those of the poses turned about.
    for shot in range(2 if direction < 0 else 1):
        side = math.pi * shot
        middle[0], middle[1], middle[2] = x, y, theta + side
        end = np.array([goal[0], goal[1], goal[2] + side])
        shown = along_arcs(middle, shortest_arcs(middle, end, bend), bend, STEP)
        shown[:, 2] -= side
        if _all_fit(distance, grid, body, sizes, shown):
            return _joined(poses, before, node, shown, 1.0 - 2.0 * shot)
    return np.empty((0, 4))


@compiled()
def _state(
    grid: Array, resolution: float, x: float, y: float, theta: float, height: int, width: int
) -> int:
    column = int(math.floor((x - grid[0]) / resolution / CELL))
    row = int(math.floor((y - grid[1]) / resolution / CELL))
    if not (0 <= row < height and 0 <= column < width):
        return -1
    heading = int(math.floor(theta / (2 * math.pi) * HEADINGS + 0.5)) % HEADINGS
    return (row * width + column) * HEADINGS + heading


@compiled()
def _joined(
    poses: Array, before: NDArray[np.int64], node: int, shown: Array, direction: float
) -> Array:
    """Return the steps to a node, filled with points, and the arcs from there."""
    nodes = _nodes_to(before, node)
    parts = len(shown) - 1
    for index in range(1, len(nodes)):
        parts += _points_between(poses[nodes[index - 1]], poses[nodes[index]])
    path = np.empty((1 + parts, 4))
    path[0, 0], path[0, 1], path[0, 2], path[0, 3] = poses[0, 0], poses[0, 1], poses[0, 2], 0.0
    place = 1
    for index in range(1, len(nodes)):
        place = _fill(path, place, poses[nodes[index - 1]], poses[nodes[index]])
    for index in range(1, len(shown)):
        path[place, 0], path[place, 1] = shown[index, 0], shown[index, 1]
        path[place, 2], path[place, 3] = shown[index, 2], direction
        place += 1
    return path


@compiled()
def _nodes_to(before: NDArray[np.int64], node: int) -> NDArray[np.int64]:
    """Return the nodes from the start to one, which is the last."""
    count, place = 0, node
    while before[place] >= 0:
        count += 1
        place = before[place]
    nodes = np.empty(count + 1, np.int64)
    place = node
    for index in range(count, -1, -1):
        nodes[index] = place
        place = before[place]
    return nodes


@compiled()
def _points_between(low: Array, high: Array) -> int:
    """Return by how many points a step (4,) is shown."""
    apart = math.hypot(high[0] - low[0], high[1] - low[1])
    return max(1, int(math.ceil(apart / STEP)))


@compiled()
def _fill(path: Array, place: int, low: Array, high: Array) -> int:
    """Fill a path (n, 4) from a place on with the arc of a step; returns the next place."""
    apart = math.hypot(high[0] - low[0], high[1] - low[1])
    steps = _points_between(low, high)
    angle, ahead = high[2] - low[2], high[3]
    length = apart if abs(angle) < 1e-9 else apart * (angle / 2) / math.sin(angle / 2)
    for step in range(1, steps + 1):
        part = angle * step / steps
        way = length * step / steps
        chord = way if abs(part) < 1e-9 else way * math.sin(part / 2) / (part / 2)
        heading = low[2] + part / 2
        path[place, 0] = low[0] + ahead * chord * math.cos(heading)
        path[place, 1] = low[1] + ahead * chord * math.sin(heading)
        path[place, 2], path[place, 3] = low[2] + part, ahead
        place += 1
    return place
