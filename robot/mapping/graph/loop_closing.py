"""Finds places where a robot has been before, and refuses those that only look alike."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from robot.geometry import Pose2
from robot.mapping.graph.branch_and_bound import Window
from robot.mapping.graph.constraints import Constraint
from robot.mapping.graph.key_frames import MATCH_GATE_M, KeyFrames, search

OLD = 25
"""A loop leads to a scan that is at least this many scans older."""
CHAIN = 10
"""How many successive scans are examined together."""
RECENT = 4
"""How many of the newest scans are laid on them together."""
NEAR_M = 4.0
"""Loops are searched for within this distance [m], and farther by the graph's uncertainty."""
MOST_CHAINS = 3
"""How many chains are examined for a scan."""
DEVIATIONS = 4.0
"""How far a window reaches, in standard deviations."""
WIDEST = np.array([6.0, 6.0, 1.0])
"""... but at most this far [m, m, rad]."""
LEAST = np.array([0.2, 0.2, 0.08])
"""... and at least this far, besides the uncertainty [m, m, rad]."""
LEVELS = 6
"""Resolutions of the field."""
SCORE = 0.55
"""Least fit of a loop."""
MATCHES = 4
"""Most scans of a chain that are matched one by one, and ..."""
FEWEST_MATCHES = 2
"""this many have to fit."""
AGREEMENT = (0.15, 0.04)
"""Loops agree if they move a pose alike within this [m, rad], and ..."""
AGREEMENT_STEP = (0.02, 0.004)
"""... and this much more for each scan that lies between them."""
PATIENCE = 15
"""A loop is confirmed by another one within this many scans."""
FITTING = 4.0
"""A loop whose squared residual is below this needs no adjustment at once."""
REST = 5
"""After a loop was closed, the next is searched for this many scans later."""
OUTLIER = 25.0
"""A loop is wrong if its squared residual stays above this, in deviations."""


@dataclass(frozen=True, eq=False)
class Closure:
    """A node that was recognized from earlier ones."""

    node: int
    constraints: list[Constraint]


class LoopCloser:
    """Looks for loops, and adds those to the graph that are confirmed."""

    def __init__(self, frames: KeyFrames) -> None:
        """Begin without any."""
        self._frames, self._graph = frames, frames.graph
        self._waiting: list[Closure] = []
        self._closed: list[Closure] = []

    @property
    def count(self) -> int:
        """How many loops were closed."""
        return len(self._closed)

    def close(self, node: int) -> None:
        """Look for loops that end at a node, and close those that are confirmed."""
        if self._closed and node - self._closed[-1].node < REST:
            return
        for chain in self._chains(node):
            closure = self._closure(node, chain)
            if closure is not None:
                self._confirm(closure)

    def _chains(self, node: int) -> list[list[int]]:
        """Return chains of old scans that may be of the same place, the nearest first."""
        poses = self._graph.poses
        away = np.hypot(*(poses[: max(0, node - OLD), :2] - poses[node, :2]).T)
        nearest: dict[int, int] = {}
        for other in np.argsort(away).tolist():
            block = other // CHAIN
            if block in nearest or len(nearest) == MOST_CHAINS:
                continue
            if away[other] > NEAR_M:
                spread = self._graph.covariance(node, other)
                if away[other] > NEAR_M + 3 * np.sqrt(np.diag(spread)[:2].max()):
                    break
            nearest[block] = other
        chains = []
        for other in nearest.values():
            around = range(max(0, other - CHAIN // 2), min(node - OLD, other + CHAIN // 2))
            chains.append(self._frames.telling(around))
        return [chain for chain in chains if chain]

    def _closure(self, node: int, chain: list[int]) -> Closure | None:
        frames = self._frames
        recent = frames.telling(range(max(0, node - RECENT + 1), node + 1))
        if not recent or recent[-1] != node:
            return None
        pose = self._graph.pose(node)
        deviations = np.sqrt(np.diag(self._graph.covariance(node, chain[len(chain) // 2])))
        deviations[:2] = deviations[:2].max()
        half = np.minimum(LEAST + DEVIATIONS * deviations, WIDEST)
        # Where doors look alike, the nearest one is the likeliest.
        window = Window(pose, half, 1 / (deviations + LEAST / DEVIATIONS))
        points = frames.points(recent, node)
        best = search(frames, chain, points, window, SCORE, LEVELS)
        if best is None:
            return None
        place = best[0]
        chain = sorted(chain, key=lambda other: self._graph.pose(other).distance_to(place))
        constraints = []
        for other in chain:
            constraint = frames.constraint(other, node, place, MATCH_GATE_M)
            if constraint is not None:
                constraints.append(constraint)
            if len(constraints) == MATCHES:
                break
        return Closure(node, constraints) if len(constraints) >= FEWEST_MATCHES else None

    def _confirm(self, closure: Closure) -> None:
        """Add a closure with all that agree, if there are any; else let it wait."""
        oldest = closure.node - PATIENCE
        self._waiting = [other for other in self._waiting if other.node >= oldest]
        agreeing = [
            other
            for other in self._waiting
            if other.node != closure.node and self._agree(closure, other)
        ]
        if not agreeing:
            self._waiting.append(closure)
            return
        new = [closure, *(other for other in agreeing if other not in self._closed)]
        if self._add(new):
            self._closed += sorted(new, key=lambda each: each.node)
            self._waiting.append(closure)

    def _agree(self, closure: Closure, other: Closure) -> bool:
        """Return whether two closures say the same of where the robot is."""
        between = self._graph.pose(closure.node).inverse() @ self._graph.pose(other.node)
        expected = self._place(closure) @ between
        place = self._place(other)
        steps = abs(closure.node - other.node)
        far, turn = (
            most + steps * step for most, step in zip(AGREEMENT, AGREEMENT_STEP, strict=True)
        )
        return expected.distance_to(place) < far and abs(expected.turn_to(place)) < turn

    def _place(self, closure: Closure) -> Pose2:
        constraint = closure.constraints[0]
        return self._graph.pose(constraint.begin) @ constraint.moved

    def _add(self, closures: list[Closure]) -> bool:
        """Add closures to the graph, unless it does not hold together with them."""
        graph = self._graph
        before, poses = list(graph.constraints), graph.poses.copy()
        new = [constraint for closure in closures for constraint in closure.constraints]
        graph.add_constraints(new)
        if np.median(graph.squares(new)) < FITTING:
            return True
        # A loop that moves much would count as an outlier before it has moved anything.
        graph.adjust(tail=np.inf)
        graph.adjust()
        if np.median(graph.squares(new)) > OUTLIER:
            graph.keep_constraints(before)
            graph.poses = poses
            return False
        return True
