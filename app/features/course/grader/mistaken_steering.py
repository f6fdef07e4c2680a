"""A controller by pure pursuit, with mistakes that are made."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from app.features.course.grader.case import by_mistake
from robot.geometry import Array, wrap_angle

THERE_M = 0.01
GAIN = 0.25
"""Times the delay."""

GAINS: dict[str, Callable[[float], float]] = {
    "gain-four": lambda delay: 4 * GAIN / delay,
    "gain-eight": lambda delay: 8 * GAIN / delay,
    "gain-two": lambda delay: 2 * GAIN / delay,
    "gain-times": lambda delay: GAIN * delay,
    "gain-upside": lambda delay: delay / GAIN,
    "gain-plain": lambda _delay: GAIN,
    "gain-one": lambda _delay: 1.0,
}
BROUGHT_BACK: dict[str, Callable[[float], float]] = {
    "unwrapped": lambda angle: angle,
    "full-turns": lambda angle: angle % math.tau,
    "half-turns": lambda angle: angle % math.pi,
    "half-round": lambda angle: math.remainder(angle, math.pi),
    "turned-half": lambda angle: wrap_angle(angle) + math.pi,
    "clipped": lambda angle: min(max(angle, -math.pi), math.pi),
}
"""What is done to an error where it should be brought back to -π to π."""
FURTHER = (2, 3, 4, 5, 6, 8, 10, 15, 20)
"""Points beyond the nearest one at which one aims who counts points, not their distance."""
TARGETS = (
    *(
        "from-start",
        "from-start-or-last",
        "up-to-nearest",
        "from-nearest",
        "nearest",
        "last",
        "before",
        "next",
        "from-far",
        "one-less",
    ),
    *("last-far", "last-far-anywhere", "at-ahead", "at-ahead-whole", "larger-x", "in-front"),
    *(f"further-{points}" for points in FURTHER),
)
ENDS: dict[str, int | None] = {"end-nearest": None, "end-first": 0, "end-before": -2}
"""Where on the way one aims where no point is far enough; None is the nearest."""
ERRORS = (
    *("own-heading", "heading-added", "heading-axes", "axes-own", "axes", "from-target", "ratio"),
    *("from-origin", "shifted-late", "half-plane", "half-sine", "half-cosine", "half-own"),
    *("along-way", "way-there", "way-here"),
    *("degrees-heading", "degrees-bearing", "goal-always"),
)
"""What else the direction to a point is made of; with ``-turn`` behind it, where the robot turns
alone, and its speed is right."""
GOAL_TURNS = ("goal-heading-alone", "goal-added", "goal-zero", "goal-piece", "goal-bearing")
"""Where else one turns at the goal."""
SPEED_ANGLES = ("speed-heading", "speed-bearing")
"""Angles whose cosine is taken for that of the error."""


def commanded(arguments: tuple[Any, ...], mistakes: frozenset[str]) -> Array:
    """Return the speed and the turning speed of a controller with mistakes."""
    delay = arguments[-1]
    arrived = _is_there(arguments, mistakes)
    part = "goal" if arrived else "way"
    error = _goal_error(arguments, mistakes) if arrived else _way_error(arguments, mistakes)
    backs = _of_part(BROUGHT_BACK, part)
    error = by_mistake(mistakes, backs, wrap_angle)(error)
    changes: dict[str, Callable[[float], float]] = {
        "degrees": math.degrees,
        "sign": lambda angle: -angle,
        "unsigned": abs,
        "folded": lambda angle: math.asin(math.sin(angle)),
    }
    for name, change in _of_part(changes, part).items():
        error = change(error) if name in mistakes else error
    turns = {
        "degrees-turn": math.degrees(error),
        "sine-turn": math.sin(error),
        "folded-turn": math.asin(math.sin(error)),
    }
    turn = by_mistake(mistakes, _of_part(turns, part), error)
    otherwise = frozenset(name for name in ERRORS if f"{name}-turn" in mistakes)
    if otherwise and not arrived:
        turn = wrap_angle(_way_error(arguments, mistakes | otherwise))
    if arrived and "heading-forgotten" in mistakes:
        turn = 0.0
    gain = by_mistake(mistakes, _of_part(GAINS, part), lambda delay: GAIN / delay)(delay)
    speed = 0.0 if arrived and "drives-on" not in mistakes else _speed(arguments, error, mistakes)
    return np.array([speed, gain * turn])


def _of_part(choices: Mapping[str, Any], part: str) -> dict[str, Any]:
    """Return choices by their name, and by that of a mistake made on the way or at the goal."""
    return {each: value for name, value in choices.items() for each in (name, f"{name}-{part}")}


def _is_there(arguments: tuple[Any, ...], mistakes: frozenset[str]) -> bool:
    pose, path, goal, _, ahead, _ = arguments
    dx, dy = np.abs(goal[:2] - pose[:2]).tolist()
    nears = {"goal-x": dx, "goal-y": dy, "goal-square": max(dx, dy), "goal-sum": dx + dy}
    nears |= {"all-square": max(dx, dy), "all-sum": dx + dy, "all-x": dx, "all-y": dy}
    near = by_mistake(mistakes, nears, math.hypot(dx, dy))
    if "goal-nearest" in mistakes:
        return bool(np.hypot(*(path - pose[:2]).T).argmin() == len(path) - 1)
    reach = math.sqrt(THERE_M) if "goal-rooted" in mistakes else THERE_M
    reach = ahead if "goal-within-ahead" in mistakes else reach
    return near < reach and "no-goal" not in mistakes


def _goal_error(arguments: tuple[Any, ...], mistakes: frozenset[str]) -> float:
    pose, path, goal = arguments[:3]
    own, heading = float(pose[2]), float(goal[2])
    dx, dy = (goal[:2] - pose[:2]).tolist()
    errors = {
        "goal-heading-alone": heading,
        "goal-added": heading + own,
        "goal-zero": -own,
        "goal-piece": _direction(path, len(path) - 1) - own,
        "goal-bearing": math.atan2(dy, dx) - own,
    }
    return by_mistake(mistakes, errors, heading - own)


def _speed(arguments: tuple[Any, ...], error: float, mistakes: frozenset[str]) -> float:
    speed = float(arguments[3])
    if "full-speed" in mistakes:
        return speed
    own = float(arguments[0][2])
    shares = {
        "cosine-size": abs(math.cos(error)),
        "speed-sine": math.sin(error),
        "speed-heading": math.cos(own),
        "speed-bearing": math.cos(error + own),
    }
    share = by_mistake(mistakes, shares, math.cos(error))
    return speed * (share if "backwards" in mistakes else max(0.0, share))


def aimed_at(arguments: tuple[Any, ...], mistakes: frozenset[str]) -> int:
    """Return which point of the way is aimed at."""
    pose, path, _, _, ahead, _ = arguments
    away = _distances(path, pose, mistakes)
    nearest, last = nearest_to(arguments, mistakes), len(path) - 1
    ahead = by_mistake(mistakes, {"ahead-rooted": ahead**0.5, "ahead-squared": ahead**2}, ahead)
    far = nearest + np.flatnonzero(away[nearest:] > ahead)
    if "from-nearest" in mistakes:
        along = np.hypot(*(path[nearest:] - path[nearest]).T)
        far = nearest + np.flatnonzero(along > ahead)
    end = next((place for name, place in ENDS.items() if name in mistakes), -1)
    usual = int(far[0]) if len(far) else (nearest if end is None else end % len(path))
    behind = np.flatnonzero(away[: nearest + 1] > ahead)
    within = np.flatnonzero(away <= ahead)
    targets = {
        "from-start": int(np.append(np.flatnonzero(away > ahead), last)[0]),
        "from-start-or-last": int(
            np.argmax(away > ahead) if (away[nearest:] > ahead).any() else last
        ),
        "up-to-nearest": int(behind[0]) if len(behind) else last,
        "nearest": nearest,
        "last": last,
        "before": int(behind[-1]) if len(behind) else 0,
        "next": min(nearest + 1, last),
        "from-far": int(within[-1]) if len(within) else nearest,
        "one-less": max(nearest, int(far[0]) - 1) if len(far) else last,
        "last-far": int(far[-1]) if len(far) else last,
        "last-far-anywhere": int(np.append(last, np.flatnonzero(away > ahead))[-1]),
        "at-ahead": nearest + int(np.abs(away[nearest:] - ahead).argmin()),
        "at-ahead-whole": int(np.abs(away - ahead).argmin()),
    }
    dx, dy = (path - pose[:2]).T
    fronts = {"larger-x": dx, "in-front": dx * np.cos(pose[2]) + dy * np.sin(pose[2])}
    for name, front in fronts.items():
        targets[name] = int(np.append(np.flatnonzero((front > 0) & (away > ahead)), last)[0])
    targets |= {f"further-{points}": min(nearest + points, last) for points in FURTHER}
    return by_mistake(mistakes, targets, usual)


def nearest_to(arguments: tuple[Any, ...], mistakes: frozenset[str]) -> int:
    """Return which point of the way is nearest to the robot."""
    pose, path = arguments[:2]
    if "nearest-origin" in mistakes:
        return int(np.hypot(*path.T).argmin())
    return int(_distances(path, pose, mistakes - {"far-origin"}).argmin())


def _distances(path: Array, pose: Array, mistakes: frozenset[str]) -> Array:
    """Return how far the points (n, 2) of a way are from a pose (n,) [m]."""
    apart = np.abs(path - pose[:2])
    if mistakes & {"path-sum", "all-sum"}:
        return np.asarray(apart.sum(axis=1))
    if mistakes & {"path-square", "all-square"}:
        return np.asarray(apart.max(axis=1))
    if mistakes & {"path-origin", "far-origin"}:
        return np.asarray(np.hypot(*path.T))
    for axis, name in enumerate("xy"):
        if mistakes & {f"path-{name}", f"all-{name}"}:
            return np.asarray(apart[:, axis])
    return np.asarray(np.hypot(*apart.T))


def _way_error(arguments: tuple[Any, ...], mistakes: frozenset[str]) -> float:
    pose, path = arguments[:2]
    target, own = aimed_at(arguments, mistakes), float(pose[2])
    x, y = path[target].tolist()
    dx, dy = (path[target] - pose[:2]).tolist()
    bearing = math.atan2(dy, dx)
    if not mistakes.intersection(ERRORS):
        return bearing - own
    nearest = nearest_to(arguments, mistakes)
    along_x, along_y = (path[target] - path[nearest]).tolist()
    turned = complex(x, y) * complex(math.cos(own), -math.sin(own)) - complex(*pose[:2].tolist())
    errors: dict[str, float] = {
        "own-heading": bearing,
        "heading-added": bearing + own,
        "heading-axes": bearing - (math.pi / 2 - own),
        "axes-own": math.pi / 2 - (bearing - own),
        "axes": math.atan2(dx, dy) - own,
        "from-target": math.atan2(-dy, -dx) - own,
        "ratio": dy / dx - own,
        "from-origin": math.atan2(y, x) - own,
        "shifted-late": math.atan2(turned.imag, turned.real),
        "half-plane": math.atan(dy / dx) - own,
        "half-sine": math.asin(dy / math.hypot(dx, dy)) - own,
        "half-cosine": math.acos(dx / math.hypot(dx, dy)) - own,
        "half-own": math.remainder(bearing - own, math.pi),
        "along-way": math.atan2(along_y, along_x) - own,
        "goal-always": float(arguments[2][2]) - own,
        "way-there": _direction(path, target) - own,
        "way-here": _direction(path, nearest + 1) - own,
        "degrees-heading": bearing - math.radians(own),
        "degrees-bearing": math.degrees(bearing) - own,
    }
    return by_mistake(mistakes, errors, bearing - own)


def _direction(path: Array, point: int) -> float:
    """Return in which direction a way leads to one of its points, the second or a later one."""
    point = min(max(point, 1), len(path) - 1)
    dx, dy = (path[point] - path[point - 1]).tolist()
    return math.atan2(dy, dx)
