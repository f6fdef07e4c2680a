"""``plan_in_headings``: ways of a robot that cannot turn on the spot, ahead and backwards.

Hybrid A* (Dolgov et al. 2010): A* over places and headings, whose steps are arcs of the smallest
radius and straight lines; from time to time the shortest arcs to the goal are tried, so that it
ends there exactly.
"""

from __future__ import annotations

import math
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from robot.compiling import compiled
from robot.geometry import Array, Pose2
from robot.navigation.dubins import along_arcs, shortest_arcs
from robot.navigation.free_space import COST_WEIGHT, FreeSpace
from robot.navigation.gates import AHEAD, BACK, comes_no_nearer
from robot.navigation.grid_search import _sift_down, _sift_up
from robot.navigation.legs import STEP, WayLeg, straight
from robot.navigation.planning import NoWayError, require_joined

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
"""A robot that stands nearer to a wall than its clearance keeps what it has, less this [m]."""


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
    clearance = min(free.kept, room - FRINGE)
    ground = Ground(
        free.distance,
        *(float(free.origin[0]), float(free.origin[1]), float(free.side)),
        np.ascontiguousarray(free.hollow.body),
        *(float(free.radius), float(clearance), float(settings.minimum_turning_radius)),
        _ways_left(_passages(free), *free.cell(goal.x, goal.y)),
        float(settings.resolution),
    )
    path = _hybrid(ground, begin.to_array(), goal.to_array())
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
    for distance in sorted((*AHEAD, *BACK), key=abs):
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


class Ground(NamedTuple):
    """Where the outline may be, and what is left to the goal from there."""

    distance: NDArray[np.float32]
    """(h, w) to walls [m]."""
    origin_x: float
    origin_y: float
    side: float
    """Of the cells of ``distance`` [m]."""
    body: Array
    """(k, 2) points of the robot [m]."""
    radius: float
    """Of the robot [m]."""
    clearance: float
    bend: float
    """Smallest radius of its bends [m]."""
    left: NDArray[np.float32]
    """(rows, columns) the estimate of what is left from each cell, in cells; inf without a way."""
    resolution: float
    """Side of those cells [m]."""


class _Tree(NamedTuple):
    """The places that were reached, and those of them from which it goes on."""

    poses: Array
    """(n, 4) x, y, theta and the direction in which it was reached."""
    before: NDArray[np.int64]
    """(n,) the place before each; -1 of the start."""
    cost: NDArray[np.float32]
    """(n,) of the way to each [m]."""
    keys: NDArray[np.float32]
    """Of the heap: the cost of the way there and of what is left."""
    heap: NDArray[np.int32]
    """Places to go on from."""
    least: NDArray[np.float32]
    """(states,) the least cost at which each state was reached."""
    done: NDArray[np.bool_]
    """(states,) whether it was gone on from there."""


@compiled()
def _hybrid(ground: Ground, start: Array, goal: Array) -> Array:
    """Return the path (n, 4) between poses: x, y, theta and direction; (0, 4) if none was found."""
    tree = _planted(ground, start)
    reached, waiting, tried = 1, 1, 0
    while waiting > 0:
        node = tree.heap[0]
        waiting -= 1
        _sift_down(tree.keys, tree.heap, waiting)
        x, y, theta, _ = tree.poses[node]
        state = _state(ground, x, y, theta)
        if state < 0 or tree.done[state]:
            continue
        tree.done[state] = True
        tried += 1
        if tried % SHOT_EVERY == 1:
            path = _shot(ground, tree, node, goal)
            if len(path) > 0:
                return path
        new = _grow(ground, tree, node, reached, waiting)
        reached, waiting = reached + new, waiting + new
    return np.empty((0, 4))


@compiled()
def _planted(ground: Ground, start: Array) -> _Tree:
    """Return a tree of one place, the start."""
    rows, columns = _state_shape(ground)
    states = rows * columns * HEADINGS
    tree = _Tree(
        np.empty((MOST_PLACES, 4)),
        np.full(MOST_PLACES, -1, np.int64),
        np.empty(MOST_PLACES, np.float32),
        np.empty(MOST_PLACES + 8, np.float32),
        np.empty(MOST_PLACES + 8, np.int32),
        np.full(states, np.inf, np.float32),
        np.zeros(states, np.bool_),
    )
    for axis in range(3):
        tree.poses[0, axis] = start[axis]
    tree.poses[0, 3] = tree.cost[0] = 0.0
    tree.keys[0], tree.heap[0] = 0.0, 0
    return tree


@compiled()
def _grow(ground: Ground, tree: _Tree, node: int, reached: int, waiting: int) -> int:
    """Add each step from a node that fits and comes to its state at less cost; return how many.

    Args:
        reached: how many places the tree has.
        waiting: how many of them its heap has.
    """
    x, y, theta, direction = tree.poses[node]
    stride, new = STRIDE_CELLS * ground.resolution, 0
    for move in range(MOVES):
        pose, half = _moved(x, y, theta, move, stride, ground.bend)
        state = _state(ground, *pose)
        if state < 0 or tree.done[state] or reached + new >= MOST_PLACES:
            continue
        left = _left_at(ground, pose[0], pose[1])
        cost = np.float32(tree.cost[node] + _price(move, direction, stride))
        if not math.isfinite(left) or cost >= tree.least[state]:
            continue
        if not (_fits(ground, *pose) and _fits(ground, *half)):
            continue
        place = reached + new
        tree.least[state] = tree.cost[place] = cost
        tree.before[place] = node
        tree.poses[place, 0], tree.poses[place, 1], tree.poses[place, 2] = pose
        tree.poses[place, 3] = _side(move)
        key = float(cost + np.float32(left * ground.resolution))
        _sift_up(tree.keys, tree.heap, waiting + new, key, place)
        new += 1
    return new


@compiled()
def _fits(ground: Ground, x: float, y: float, theta: float) -> bool:
    """Whether the outline keeps its clearance at a pose."""
    near = _distance_at(ground, x, y)
    if near < 0:
        return False
    if near >= ground.radius + ground.clearance:
        return True
    cos, sin = math.cos(theta), math.sin(theta)
    for point in range(len(ground.body)):
        px = x + cos * ground.body[point, 0] - sin * ground.body[point, 1]
        py = y + sin * ground.body[point, 0] + cos * ground.body[point, 1]
        if _distance_at(ground, px, py) < max(ground.clearance, 0.0):
            return False
    return True


@compiled()
def _distance_at(ground: Ground, x: float, y: float) -> float:
    """Return the distance to walls at a place [m]; -1 outside of all cells."""
    rows, columns = ground.distance.shape
    if x < ground.origin_x or y < ground.origin_y:
        return -1.0
    row, column = int((y - ground.origin_y) / ground.side), int((x - ground.origin_x) / ground.side)
    return ground.distance[row, column] if row < rows and column < columns else -1.0


@compiled()
def _all_fit(ground: Ground, poses: Array) -> bool:
    for place in range(len(poses)):
        if not _fits(ground, poses[place, 0], poses[place, 1], poses[place, 2]):
            return False
    return True


@compiled()
def _side(move: int) -> float:
    """Return 1 of a step ahead and -1 of one backwards."""
    return 1.0 if move < MOVES // 2 else -1.0


@compiled()
def _moved(
    x: float, y: float, theta: float, move: int, stride: float, bend: float
) -> tuple[tuple[float, float, float], tuple[float, float, float]]:
    """Return the pose after a step, and the one about half of it: right, straight or left."""
    ahead, bends, turn = _side(move), float(move % 3 - 1), stride / bend
    angle = ahead * bends * turn
    chord = stride if bends == 0 else stride * math.sin(turn / 2) / (turn / 2)
    to_x = x + ahead * chord * math.cos(theta + angle / 2)
    to_y = y + ahead * chord * math.sin(theta + angle / 2)
    half = ahead * chord / 2
    half_x, half_y = x + half * math.cos(theta), y + half * math.sin(theta)
    return (to_x, to_y, theta + angle), (half_x, half_y, theta + angle / 2)


@compiled()
def _price(move: int, direction: float, stride: float) -> float:
    """Return what a step counts after one in a direction: 1 ahead, -1 backwards, 0 for none."""
    length = stride * (BEND_COST if move % 3 != 1 else 1.0)
    length *= 1.0 if _side(move) > 0 else BACKWARDS_COST
    return length + (SWITCH_M if direction * _side(move) < 0 else 0.0)


@compiled()
def _left_at(ground: Ground, x: float, y: float) -> float:
    """Return the estimate of what is left at a place, in cells; inf without a way."""
    row = int((y - ground.origin_y) / ground.resolution)
    column = int((x - ground.origin_x) / ground.resolution)
    if not (0 <= row < ground.left.shape[0] and 0 <= column < ground.left.shape[1]):
        return float(np.inf)
    return float(ground.left[row, column])


@compiled()
def _shot(ground: Ground, tree: _Tree, node: int, goal: Array) -> Array:
    """Return the path to a node and on by the shortest arcs to the goal; (0, 4) if none is free."""
    middle = np.empty(3)
    x, y, theta, direction = tree.poses[node]
    # Ahead by arcs, or backwards by those of the poses turned about.
    for shot in range(2 if direction < 0 else 1):
        side = math.pi * shot
        middle[0], middle[1], middle[2] = x, y, theta + side
        end = np.array([goal[0], goal[1], goal[2] + side])
        shown = along_arcs(middle, shortest_arcs(middle, end, ground.bend), ground.bend, STEP)
        shown[:, 2] -= side
        if _all_fit(ground, shown):
            return _joined(tree.poses, tree.before, node, shown, 1.0 - 2.0 * shot)
    return np.empty((0, 4))


@compiled()
def _state(ground: Ground, x: float, y: float, theta: float) -> int:
    """Return the number of the place and heading that a pose counts as; -1 beyond all."""
    rows, columns = _state_shape(ground)
    column = int(math.floor((x - ground.origin_x) / ground.resolution / CELL))
    row = int(math.floor((y - ground.origin_y) / ground.resolution / CELL))
    if not (0 <= row < rows and 0 <= column < columns):
        return -1
    heading = int(math.floor(theta / (2 * math.pi) * HEADINGS + 0.5)) % HEADINGS
    return (row * columns + column) * HEADINGS + heading


@compiled()
def _state_shape(ground: Ground) -> tuple[int, int]:
    """Return how many rows and columns of places are told apart."""
    return ground.left.shape[0] // CELL + 1, ground.left.shape[1] // CELL + 1


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
