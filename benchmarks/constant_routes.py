"""Trials of a constant of routes: robots drive to places, with wheels that slip a little."""

from __future__ import annotations

import math
import pickle
import zlib
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from robot.driving.route import Route
from robot.geometry import Pose2

PLACES = 40
"""How many routes."""
SEED = 60400
TICK, LONGEST_S = 0.05, 60.0
"""Of a control loop, and of a route [s]."""
SLIP = 0.05
"""Noise of a tick's motion, as a share of it."""


@dataclass(frozen=True, eq=False)
class RouteTrial:
    """Where to drive."""

    goals: list[tuple[Pose2, Pose2]]
    """Starts and goals."""
    seed: int


def recorded(kept: Path | None, seed: int = 0) -> list[RouteTrial]:
    """Return the trial; from a file, or to it if it is not there yet."""
    if kept is not None and kept.exists():
        trials: list[RouteTrial] = pickle.loads(kept.read_bytes())  # our own, of a minute ago
        return trials
    rng = np.random.default_rng(SEED + seed)
    ends = rng.uniform((-1, -1, -math.pi), (1, 1, math.pi), (PLACES, 2, 3)).tolist()
    goals = [(Pose2(*start), Pose2(*goal)) for start, goal in ends]
    trials = [RouteTrial(goals, SEED + seed)]
    if kept is not None:
        kept.write_bytes(pickle.dumps(trials))
    return trials


def few(trials: list[RouteTrial]) -> list[RouteTrial]:
    """Return all: they are few."""
    return trials


def tried(trials: list[RouteTrial], other_numbers: int) -> dict[str, Any]:
    """Drive all routes; return figures by name, and numbers of results.

    Args:
        other_numbers: if not 0, the seed of other places.
    """
    (trial,) = recorded(None, other_numbers) if other_numbers else trials
    rng = np.random.default_rng(trial.seed)
    ends = [_Driver(start, rng) for start, _ in trial.goals]
    routes = [
        driver.driven(Route(goal)) for driver, (_, goal) in zip(ends, trial.goals, strict=True)
    ]
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
        "each": [zlib.crc32(driver.pose.to_array().tobytes()) for driver in ends],
    }


class _Driver:
    """A robot that drives routes with wheels that slip."""

    def __init__(self, pose: Pose2, rng: np.random.Generator) -> None:
        self.pose, self.seconds = pose, 0.0
        self._rng = rng

    def driven(self, route: Route) -> bool:
        """Drive; return whether the route came to its end."""
        for _ in range(round(LONGEST_S / TICK)):
            twist = route.twist(self.pose)
            if twist is None:
                return True
            step = twist.integrate(TICK)
            along, turn = 1 + SLIP * self._rng.normal(size=2)
            self.pose @= Pose2(along * step.x, along * step.y, turn * step.theta)
            self.seconds += TICK
        return False
