"""Trials of a constant of routes and of exploring: robots drive to places, and explore floors.

The wheels slip a little. A floor is a closed line with a line inside and one that leads out; what
was in the camera's view is known, and nothing else.
"""

from __future__ import annotations

import math
import pickle
import zlib
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from robot.driving.route import Route
from robot.geometry import Array, Pose2
from robot.mapping.exploring import Explorer
from robot.mapping.sketch import Sketch

PLACES, FLOORS = 40, 6
"""How many routes, and how many floors."""
SEED = 60400
TICK, LONGEST_S = 0.05, 60.0
"""Of a control loop, and of a route [s]."""
MOST_ROUTES = 60
SLIP = 0.05
"""Noise of a tick's motion, as a share of it."""
POINTS = 0.01
"""Distance of a line's points [m]."""
VIEW = (0.08, 0.65, math.radians(30))
"""Floor in view: nearest and farthest [m], and angle from straight ahead [rad]."""
START = (-0.1, -0.4, 0.3)
"""Of an exploring robot."""
EVERY = 4
"""Ticks from picture to picture."""


@dataclass(frozen=True, eq=False)
class RouteTrial:
    """Where to drive, or what to explore."""

    goals: list[tuple[Pose2, Pose2]]
    """Starts and goals."""
    floors: list[list[Array]]
    """Lines (m, 2) of each floor [m]."""
    seed: int


def recorded(kept: Path | None, seed: int = 0) -> list[RouteTrial]:
    """Return the trial; from a file, or to it if it is not there yet."""
    if kept is not None and kept.exists():
        trials: list[RouteTrial] = pickle.loads(kept.read_bytes())  # our own, of a minute ago
        return trials
    rng = np.random.default_rng(SEED + seed)
    ends = rng.uniform((-1, -1, -math.pi), (1, 1, math.pi), (PLACES, 2, 3)).tolist()
    goals = [(Pose2(*start), Pose2(*goal)) for start, goal in ends]
    trials = [RouteTrial(goals, [_floor(rng) for _ in range(FLOORS)], SEED + seed)]
    if kept is not None:
        kept.write_bytes(pickle.dumps(trials))
    return trials


def few(trials: list[RouteTrial]) -> list[RouteTrial]:
    """Return all: they are few."""
    return trials


def _floor(rng: np.random.Generator) -> list[Array]:
    half = rng.uniform(0.45, 0.65, 2)
    corners = half * [(-1, -1), (1, -1), (1, 1), (-1, 1), (-1, -1)]
    lines = [corners, np.array([(-half[0], 0.0), (half[0] * rng.uniform(-0.2, 0.6), 0.0)])]
    lines.append(np.array([(half[0], 0.1), (half[0] + rng.uniform(0.1, 0.3), 0.1)]))
    return [_dense(line) for line in lines]


def _dense(line: Array) -> Array:
    way = np.concatenate([[0], np.cumsum(np.hypot(*np.diff(line, axis=0).T))])
    along = np.arange(0, way[-1], POINTS)
    return np.column_stack([np.interp(along, way, column) for column in line.T])


def tried(trials: list[RouteTrial], other_numbers: int) -> dict[str, Any]:
    """Drive all routes, and explore all floors; return figures by name, and numbers of results.

    Args:
        other_numbers: if not 0, the seed of other places and floors.
    """
    (trial,) = recorded(None, other_numbers) if other_numbers else trials
    rng = np.random.default_rng(trial.seed)
    ends = [_Driver(start, rng) for start, _ in trial.goals]
    routes = [
        driver.driven(Route(goal)) for driver, (_, goal) in zip(ends, trial.goals, strict=True)
    ]
    explored = [_explored(lines, rng) for lines in trial.floors]
    distances = [
        driver.pose.distance_to(goal) for driver, (_, goal) in zip(ends, trial.goals, strict=True)
    ]
    turned = [
        abs(math.remainder(driver.pose.theta - goal.theta, math.tau))
        for driver, (_, goal) in zip(ends, trial.goals, strict=True)
    ]
    return {
        "route [s]": float(np.mean([driver.seconds for driver in ends])),
        "place off [mm]": 1e3 * float(np.mean(distances)),
        "heading off [deg]": math.degrees(float(np.mean(turned))),
        "not reached": routes.count(False),
        "explored in [s]": float(np.mean([seconds for seconds, _ in explored])),
        "tape unseen [%]": 100 * float(np.mean([unseen for _, unseen in explored])),
        "each": [
            *(zlib.crc32(driver.pose.to_array().tobytes()) for driver in ends),
            *(zlib.crc32(repr(each).encode()) for each in explored),
        ],
    }


class _Driver:
    """A robot that drives routes with wheels that slip, and looks."""

    def __init__(self, pose: Pose2, rng: np.random.Generator) -> None:
        self.pose, self.seconds = pose, 0.0
        self.path = [pose.to_array()]
        self._rng = rng

    def driven(self, route: Route) -> bool:
        """Drive; return whether the route came to its end."""
        for tick in range(round(LONGEST_S / TICK)):
            twist = route.twist(self.pose)
            if twist is None:
                return True
            step = twist.integrate(TICK)
            along, turn = 1 + SLIP * self._rng.normal(size=2)
            self.pose @= Pose2(along * step.x, along * step.y, turn * step.theta)
            self.seconds += TICK
            if tick % EVERY == 0:
                self.path.append(self.pose.to_array())
        return False


def _explored(lines: list[Array], rng: np.random.Generator) -> tuple[float, float]:
    """Explore a floor; return how long it took [s], and the share of tape that was not seen."""
    driver, explorer = _Driver(Pose2(*START), rng), Explorer()
    sketch = None
    for _ in range(MOST_ROUTES):
        route = explorer.next(sketch, driver.pose)
        if route is None:
            break
        driver.driven(route)
        sketch = _sketch(lines, np.array(driver.path), driver.seconds)
    seen = 0 if sketch is None else len(sketch.edges)
    return driver.seconds, 1 - seen / sum(map(len, lines))


def _sketch(lines: list[Array], path: Array, stamp: float) -> Sketch | None:
    """Return what was seen of lines: each run of points that were in view is a line."""
    runs = []
    for line in lines:
        seen = _in_view(line, path)
        breaks = np.flatnonzero(np.diff(seen.astype(int))) + 1
        runs += [run for run, is_seen in zip(
            np.split(line, breaks), np.split(seen, breaks), strict=True
        ) if is_seen[0] and len(run) > 2]  # fmt: skip
    if not runs:
        return None
    return Sketch(tuple(runs), np.zeros(len(runs)), path, np.vstack(runs), stamp, None)


def _in_view(points: Array, path: Array) -> Array:
    nearest, farthest, angle = VIEW
    x, y = (points - path[:, None, :2]).transpose(2, 0, 1)
    c, s = np.cos(path[:, 2])[:, None], np.sin(path[:, 2])[:, None]
    ahead, left = c * x + s * y, c * y - s * x
    far = np.hypot(x, y)
    seen = (far > nearest) & (far < farthest) & (np.abs(left) < math.tan(angle) * ahead)
    return np.asarray(seen.any(axis=0))
