"""Signs of a wrong controller: what its speeds in all cases show by themselves."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from itertools import product
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from app.features.course.grader.case import REFERENCE, Outcome, Sign
from app.features.course.grader.mistaken_steering import GAIN, aimed_at, nearest_to
from app.features.course.grader.words import Words
from app.languages.marking import phrase
from robot.geometry import Array, wrap_angle

MOST_UNEQUAL = 1e-6
"""How far equal shares may be apart, of the largest."""
FEWEST = 8
"""Cases on the way that show a product."""
POWERS = tuple(
    (speed, ahead, delay)
    for delay in (0, -1, -2, 1)
    for speed in (0, 1, -1)
    for ahead in (0, 1, -1)
)
"""Powers of speed, look-ahead distance and delay with which turns that are off become alike."""


class Commanded(NamedTuple):
    """A case with the speeds that are given and due."""

    outcome: Outcome
    given: Array
    due: Array

    @property
    def at_goal(self) -> bool:
        """Whether the robot stands where it should."""
        return self.outcome.case.kind == "goal"

    @property
    def wrong(self) -> NDArray[np.bool_]:
        """Whether the speed is wrong, and whether the turning speed is."""
        return np.abs(self.given - self.due) > self.outcome.case.tolerance


def signs_of(seen: Sequence[Commanded]) -> Iterator[Sign]:
    """A limit, errors off by whole turns, another gain, an arc; else which part is wrong."""
    if not any(item.wrong.any() for item in seen):
        return
    for find in (_limited, _turned_more, _scaled, _arcs, _areas):
        known = list(find(seen))
        if known:
            yield from known
            return


def _limited(seen: Sequence[Commanded]) -> Iterator[Sign]:
    """A speed or a turn that is cut off, if that is all that is wrong."""
    wrong = [item for item in seen if item.wrong.any()]
    for axis in (0, 1):
        sizes = [abs(item.given[axis]) for item in wrong]
        if len(wrong) < 2 or np.ptp(sizes) > 1e-9 or sizes[0] == 0:
            continue
        cut = [item.due.copy() for item in seen]
        for due in cut:
            due[axis] = np.clip(due[axis], -sizes[0], sizes[0])
        if all(np.abs(due - item.given).max() <= 1e-6 for due, item in zip(cut, seen, strict=True)):
            yield Sign("limited", wrong[0].outcome)
            return


def _turned_more(seen: Sequence[Commanded]) -> Iterator[Sign]:
    """Errors that are whole turns too large or too small."""
    wrong = [item for item in seen if item.wrong.any()]
    turns = [
        (item.given[1] - item.due[1]) * item.outcome.case.arguments[5] / GAIN / math.tau
        for item in wrong
    ]
    whole = all(abs(turn - round(turn)) < MOST_UNEQUAL and round(turn) for turn in turns)
    if whole and not any(item.wrong[0] for item in wrong):
        yield Sign("E2", wrong[0].outcome)


def _scaled(seen: Sequence[Commanded]) -> Iterator[Sign]:
    """A gain that is another one, whichever, on the way, at the goal or everywhere: the speed is
    right, and all turns are off alike, or by what the delay and the other numbers make of it."""
    if any(item.wrong[0] for item in seen):
        return
    goal = [item for item in seen if item.at_goal]
    way = [item for item in seen if not item.at_goal]
    for part, others in ((seen, []), (way, goal), (goal, way)):
        shown = [item for item in part if abs(item.due[1]) > 0.02]
        if len(shown) < 2 or any(item.wrong.any() for item in others):
            continue
        shares = np.array([item.given[1] / item.due[1] for item in shown])
        numbers_of = np.array([item.outcome.case.arguments[3:] for item in shown])
        for powers in POWERS:
            alike = shares * np.prod(numbers_of ** np.array(powers), axis=1)
            if not alike.all() or np.ptp(alike) > MOST_UNEQUAL * abs(alike[0]):
                continue
            if alike[0] < 0:
                yield Sign("goal-away" if part is goal else "turn-away", shown[0].outcome)
            if any(powers[:2]):
                yield Sign("gain-more", shown[0].outcome, weak=True)
            elif powers[2] or not math.isclose(abs(alike[0]), 1.0):
                yield Sign("gain-delay", shown[0].outcome)
            return
        usual = shares[(numbers_of == numbers_of[0]).all(axis=1)]
        if len(usual) > FEWEST and usual[0] > 0 and np.ptp(usual) < MOST_UNEQUAL * usual[0]:
            yield Sign("gain-delay", shown[0].outcome, weak=True)
            return


def _arcs(seen: Sequence[Commanded]) -> Iterator[Sign]:
    """Turns on the way by the curvature of an arc, by its radius, or by how far a point is to the
    side: a product of such numbers in all cases."""
    way = [item for item in seen if not item.at_goal]
    given = np.array([item.given[1] for item in way])
    if len(way) < FEWEST or not given.any() or not any(item.wrong[1] for item in way):
        return
    sides, others = _factors(way)
    for side, *rest in product(sides, *others):
        factors = [sides[side], *(group[name] for group, name in zip(others, rest, strict=True))]
        model = np.prod(factors, axis=0)
        share = given @ model / (model @ model)
        if np.abs(given - share * model).max() <= MOST_UNEQUAL * np.abs(given).max():
            angles = {"sine": "turn-sine", "tangent": "no-arctan", "error": "gain-delay"}
            more = "gain-more" if side == "error" else "arc"
            code = more if any(rest[:2]) else angles.get(side, "arc")
            yield Sign(code, way[0].outcome, weak=side == "error")
            return


def _factors(way: Sequence[Commanded]) -> tuple[dict[str, Array], list[Mapping[str, Array]]]:
    """Return what tells left from right, and what it can be multiplied by, in each case."""
    poses = np.array([item.outcome.case.arguments[0] for item in way])
    speeds, aheads, delays = np.array([item.outcome.case.arguments[3:] for item in way]).T
    places = [
        np.array([item.outcome.case.arguments[1][point(item.outcome.case.arguments, REFERENCE)]
                  for item in way])
        for point in (aimed_at, nearest_to)
    ]  # fmt: skip
    cosines, sines = np.cos(poses[:, 2]), np.sin(poses[:, 2])
    (x, y), (near_x, near_y) = (
        (cosines * dx + sines * dy, cosines * dy - sines * dx)
        for dx, dy in ((place - poses[:, :2]).T for place in places)
    )
    far, ones = np.hypot(x, y), np.ones(len(way))
    sides = {
        "sine": y / far,
        "offset": y,
        "tangent": y / x,
        "radius": far / y,
        "one over": 1 / y,
        "error": np.arctan2(y, x),
        "nearest": near_y,
        "gap": np.hypot(near_x, near_y),
    }
    lengths = {"": ones} | {
        f"{name}{power}": length**power
        for name, length in (("far", far), ("ahead", aheads))
        for power in (1.0, 2.0, -1.0, -2.0)
    }
    given = np.array([item.given[0] for item in way])
    rates = {"": ones, "speed": speeds}
    rates |= {"given": given, "share": given / speeds} if given.any() else {}
    return sides, [rates, lengths, {"": ones, "delay": 1 / delays}]


def _areas(seen: Sequence[Commanded]) -> Iterator[Sign]:
    """Which part is wrong: what is aimed at, the speed, the turn, all at the goal."""
    wrong = [item for item in seen if item.wrong.any()]
    way = [item for item in wrong if not item.at_goal]
    aimed = [_aimed_at(item) for item in way]
    speeds, turns = np.any([item.wrong for item in wrong], axis=0).tolist()
    if way and None not in aimed and len({*aimed}) > 1:
        values = {
            "aimed": aimed[0],
            "due": aimed_at(way[0].outcome.case.arguments, REFERENCE),
            "count": len(way[0].outcome.case.arguments[1]),
        }
        text = phrase("It aims at path[{aimed}] of {count} points; path[{due}] is due.")
        yield Sign("aim", way[0].outcome, note=Words(text, values), weak=True)
    elif not way:
        yield Sign("goal-alone", wrong[0].outcome, weak=True)
    elif not turns:
        yield Sign("speed-shape" if _slows(seen) else "speed-alone", wrong[0].outcome, weak=True)
    elif not speeds:
        yield Sign("turn-alone", wrong[0].outcome, weak=True)


def _slows(seen: Sequence[Commanded]) -> bool:
    """Return whether the robot drives the more slowly on its way, the larger the error is."""
    shares = []
    for item in seen:
        _, _, _, speed, _, delay = item.outcome.case.arguments
        if not item.at_goal:
            shares.append((abs(item.due[1]) * delay, float(item.given[0] / speed)))
    falls = np.diff([share for _, share in sorted(shares)])
    return bool((falls <= MOST_UNEQUAL).all() and falls.min() < -MOST_UNEQUAL)


def _aimed_at(item: Commanded) -> int | None:
    """Return at which point of the way the given speeds aim; None if at none of them."""
    pose, path, _, speed, _, delay = item.outcome.case.arguments
    dx, dy = (path - pose[:2]).T
    errors = wrap_angle(np.arctan2(dy, dx) - pose[2])
    speeds = np.column_stack([speed * np.maximum(0.0, np.cos(errors)), GAIN / delay * errors])
    alike = np.flatnonzero(np.abs(speeds - item.given).max(axis=1) < item.outcome.case.tolerance)
    return int(alike[0]) if len(alike) else None
