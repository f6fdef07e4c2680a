"""Lesson 10: ``go_there(pose, path, goal, speed, ahead, delay)`` steers a robot along a way."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence

import numpy as np

from app.features.course.grader.case import Case, Checks, Hypothesis, Outcome, Sign, by_mistake
from app.features.course.grader.drawing import draw_bars
from app.features.course.grader.forms import array_of
from app.features.course.grader.words import Words
from robot.geometry import Array, wrap_angle

THERE_M = 0.01
GAIN = 0.25
"""Times the delay."""
SPEED, AHEAD, DELAY = 0.2, 0.1, 0.1
STEP_M = 0.02
"""From one point of a way to the next; all numbers of the cases are off it by a little, so that no
distance equals ``ahead`` up to rounding."""

Rule = Callable[[float], float]
GAINS: dict[str, Rule] = {
    "gain-four": lambda delay: 4 * GAIN / delay,
    "gain-eight": lambda delay: 8 * GAIN / delay,
    "gain-two": lambda delay: 2 * GAIN / delay,
    "gain-times": lambda delay: GAIN * delay,
    "gain-upside": lambda delay: delay / GAIN,
    "gain-plain": lambda _delay: GAIN,
    "gain-one": lambda _delay: 1.0,
}
FURTHER = (2, 3, 4, 5, 6, 8, 10, 15, 20)
"""Points beyond the nearest one at which one aims who counts points, not their distance."""
TARGETS = (
    *("from-start", "from-nearest", "nearest", "last", "before", "next", "from-far"),
    *(f"further-{points}" for points in FURTHER),
)
ENDS: dict[str, int | None] = {"end-nearest": None, "end-first": 0, "end-before": -2}
"""Where on the way one aims where no point is far enough; None is the nearest."""
ERRORS = ("own-heading", "heading-added", "axes", "from-target")


def cases(seed: int) -> list[Case]:
    """A straight way, then bows, from beside it; then the goal."""
    rng = np.random.default_rng(seed)
    straight = np.column_stack([np.arange(-0.3, 0.301, STEP_M), np.zeros(31)])
    turns = np.linspace(0.0, math.pi, 32)
    bow = 0.25 * np.column_stack([np.sin(turns), -np.cos(turns)])
    made = [
        _case("way", "It is on its way.", (-0.29, 0.001, 0.0), straight, 0.0),
        _case("way", "It is to the left of its way.", (-0.29, 0.043, 0.0), straight, 0.0),
        _case("way", "It is to the right of its way.", (-0.09, -0.037, 0.1), straight, 0.0),
        _case("way", "It is in the middle of a bow.", (0.227, 0.013, 1.4), bow, math.pi),
        _case("way", "It looks the other way.", (-0.151, 0.021, 2.6), straight, 0.0),
        _case("wrap", "The bow leads along -x.", (0.063, 0.237, 3.0), bow, -3.0),
        _case("wrap", "The bow leads along -x.", (0.113, 0.261, -2.9), bow, -3.0),
        _case("wrap", "The bow leads along -x.", (0.087, 0.281, 2.9), bow, -3.0),
        _case("wrap", "The bow leads along -x.", (0.171, 0.113, -3.0), bow, -3.0),
        _case("end", "The goal is near.", (0.243, 0.011, -0.3), straight, 0.5),
        _case("goal", "It is at the goal.", (0.297, 0.003, 0.2), straight, 1.0),
        _case("goal", "It is at the goal.", (0.303, -0.004, 2.9), straight, -2.8),
        _case("way", "It is beside its goal.", (0.297, 0.053, -0.7), straight, 1.0),
        _case("way", "It is close to its goal.", (0.2923, 0.0087, 0.3), straight, 1.0),
    ]
    for delay in (0.05, 0.2):
        drawn = tuple(rng.uniform([-0.28, -0.06, -0.8], [0.1, 0.06, 0.8]).tolist())
        made.append(_case("way", "It is beside its way.", drawn, straight, 0.0, delay=delay))
    for _ in range(4):
        angle, offset = rng.uniform(0.3, 2.6), rng.uniform(-0.05, 0.05)
        place = (0.25 + offset) * np.array([math.sin(angle), -math.cos(angle)])
        theta = wrap_angle(angle + rng.uniform(-0.9, 0.9))
        numbers = rng.uniform([0.1, 0.07, 0.05], [0.3, 0.13, 0.2]).tolist()
        pose = (*place.tolist(), theta)
        made.append(_case("way", "It is beside a bow.", pose, bow, -2.5, *numbers))
    for _ in range(2):
        x, y, theta, heading = rng.uniform([0.296, -0.004, -3, -3], [0.304, 0.004, 3, 3]).tolist()
        made.append(_case("goal", "It is at the goal.", (x, y, theta), straight, heading))
    return made


def _case(
    kind: str, text: str, pose: tuple[float, ...], path: Array, heading: float,
    speed: float = SPEED, ahead: float = AHEAD, delay: float = DELAY,
) -> Case:  # fmt: skip
    words = Words(
        "{text} It is at x {x} mm, y {y} mm, heading {heading}°; the goal's heading is {wanted}°; "
        "speed {speed} m/s, ahead {ahead} mm, delay {delay} s.",
        {
            "text": Words(text),
            "x": round(1000 * pose[0]),
            "y": round(1000 * pose[1]),
            "heading": round(math.degrees(pose[2])),
            "wanted": round(math.degrees(heading)),
            "speed": f"{speed:.3g}",
            "ahead": round(1000 * ahead),
            "delay": f"{delay:.3g}",
        },
    )
    goal = np.array([*path[-1], heading])
    arguments = (np.array(pose), path.copy(), goal, speed, ahead, delay)
    return Case("go_there", arguments, words, kind, tolerance=1e-6)


def features(outcome: Outcome) -> Array:
    """Speed and turning speed."""
    return array_of(outcome.result, (2,))


def expected(case: Case, mistakes: frozenset[str]) -> Array:
    """What a controller with mistakes commands."""
    pose, _, goal, _, _, delay = case.arguments
    dx, dy = np.abs(goal[:2] - pose[:2]).tolist()
    nears = {"goal-x": dx, "goal-y": dy, "goal-square": max(dx, dy), "goal-sum": dx + dy}
    nears |= {"all-square": max(dx, dy), "all-sum": dx + dy, "all-x": dx, "all-y": dy}
    near = next((each for name, each in nears.items() if name in mistakes), math.hypot(dx, dy))
    arrived = near < THERE_M and "no-goal" not in mistakes
    own = 0.0 if "goal-heading-alone" in mistakes else pose[2]
    error = float(goal[2] - own) if arrived else _bearing(case, mistakes)
    part = "goal" if arrived else "way"
    rules = {each: rule for name, rule in GAINS.items() for each in (name, f"{name}-{part}")}
    gain = by_mistake(mistakes, {name: rule(delay) for name, rule in rules.items()}, GAIN / delay)
    if not mistakes & {"unwrapped", f"unwrapped-{part}"}:
        error = wrap_angle(error)
    if "degrees" in mistakes:
        error = math.degrees(error)
    if mistakes & {"sign", f"sign-{part}"}:
        error = -error
    turns = {"degrees-turn": math.degrees(error), "sine-turn": math.sin(error)}
    turn = by_mistake(mistakes, turns, error)
    if arrived and "heading-forgotten" in mistakes:
        turn = 0.0
    return np.array([_speed(case, error, arrived, mistakes), gain * turn])


def _speed(case: Case, error: float, arrived: bool, mistakes: frozenset[str]) -> float:
    speed = float(case.arguments[3])
    if arrived and "drives-on" not in mistakes:
        return 0.0
    if "full-speed" in mistakes:
        return speed
    ahead = abs(math.cos(error)) if "cosine-size" in mistakes else math.cos(error)
    return speed * (ahead if "backwards" in mistakes else max(0.0, ahead))


def _target(case: Case, mistakes: frozenset[str]) -> int:
    """Return which point of the way is aimed at."""
    pose, path, _, _, ahead, _ = case.arguments
    away = _distances(path, pose, mistakes)
    nearest = int(away.argmin())
    ahead = math.sqrt(ahead) if "ahead-rooted" in mistakes else ahead
    far = nearest + np.flatnonzero(away[nearest:] > ahead)
    if "from-nearest" in mistakes:
        along = np.hypot(*(path[nearest:] - path[nearest]).T)
        far = nearest + np.flatnonzero(along > ahead)
    end = next((place for name, place in ENDS.items() if name in mistakes), -1)
    target = int(far[0]) if len(far) else (nearest if end is None else end)
    if "from-start" in mistakes:
        target = int(np.append(np.flatnonzero(away > ahead), len(path) - 1)[0])
    if "nearest" in mistakes:
        target = nearest
    if "last" in mistakes:
        target = len(path) - 1
    if "before" in mistakes:
        behind = np.flatnonzero(away[: nearest + 1] > ahead)
        target = int(behind[-1]) if len(behind) else 0
    if "next" in mistakes:
        target = min(nearest + 1, len(path) - 1)
    further = next((points for points in FURTHER if f"further-{points}" in mistakes), None)
    if further is not None:
        target = min(nearest + further, len(path) - 1)
    if "from-far" in mistakes:
        within = np.flatnonzero(away <= ahead)
        target = int(within[-1]) if len(within) else nearest
    return target


def _distances(path: Array, pose: Array, mistakes: frozenset[str]) -> Array:
    """Return how far the points (n, 2) of a way are from a pose (n,) [m]."""
    apart = np.abs(path - pose[:2])
    if mistakes & {"path-sum", "all-sum"}:
        return np.asarray(apart.sum(axis=1))
    if mistakes & {"path-square", "all-square"}:
        return np.asarray(apart.max(axis=1))
    for axis, name in enumerate("xy"):
        if mistakes & {f"path-{name}", f"all-{name}"}:
            return np.asarray(apart[:, axis])
    return np.asarray(np.hypot(*apart.T))


def _bearing(case: Case, mistakes: frozenset[str]) -> float:
    pose, path = case.arguments[:2]
    dx, dy = (path[_target(case, mistakes)] - pose[:2]).tolist()
    if "from-target" in mistakes:
        dx, dy = -dx, -dy
    bearing = math.atan2(dx, dy) if "axes" in mistakes else math.atan2(dy, dx)
    if "own-heading" in mistakes:
        return bearing
    own = float(pose[2])
    return bearing + own if "heading-added" in mistakes else bearing - own


def signs(outcomes: Sequence[Outcome]) -> Iterator[Sign]:
    """A limit of speed or turn; a gain that is another one, whichever: the speed is right, and all
    turns are off alike."""
    if limited := _limited(outcomes):
        yield Sign("limited", limited)
        return
    shares, plain, shown = [], [], None
    for outcome in outcomes:
        given, due = features(outcome), expected(outcome.case, frozenset())
        if abs(given[0] - due[0]) > 1e-6:
            return
        if abs(due[1]) > 0.02:
            shares.append(given[1] / due[1])
            plain.append(shares[-1] / outcome.case.arguments[5])
            shown = shown or outcome
    for each in (shares, plain):
        alike = bool(each) and np.ptp(each) < 1e-6 * abs(each[0])
        if shown and alike and each[0] > 0 and not math.isclose(shares[0], 1.0):
            yield Sign("gain-delay", shown)
            return


def _limited(outcomes: Sequence[Outcome]) -> Outcome | None:
    """Return a case whose speed or turn is cut off, if that is all that is wrong; or None."""
    pairs = [(item, features(item), expected(item.case, frozenset())) for item in outcomes]
    wrong = [each for each in pairs if np.abs(each[1] - each[2]).max() > 1e-6]
    for axis in (0, 1):
        sizes = [abs(given[axis]) for _, given, _ in wrong]
        if len(wrong) < 2 or np.ptp(sizes) > 1e-9 or sizes[0] == 0:
            continue
        cut = [due.copy() for _, _, due in pairs]
        for due in cut:
            due[axis] = np.clip(due[axis], -sizes[0], sizes[0])
        if all(np.abs(due - each[1]).max() <= 1e-6 for due, each in zip(cut, pairs, strict=True)):
            return wrong[0][0]
    return None


def show(_case: Case, values: Array) -> str:
    """Return speed and turning speed in words."""
    return f"{values[0]:.3f} m/s, {values[1]:.3f} rad/s"


def picture(_outcome: Outcome, due: Array, given: Array) -> str:
    """Draw both numbers."""
    return draw_bars(due, given, ["m/s", "rad/s"])


def situation(case: Case) -> dict[str, float]:
    """Where the robot is."""
    x, y, theta = case.arguments[0].tolist()
    return {"x": x, "y": y, "theta": theta}


CHECKS = Checks(
    functions=("go_there",),
    cases=cases,
    features=features,
    expected=expected,
    hypotheses=(
        Hypothesis("sign", "turn-away"),
        Hypothesis("sign-way", "turn-away", kind="way"),
        Hypothesis("sign-goal", "turn-away", kind="goal"),
        Hypothesis("unwrapped", "E2"),
        Hypothesis("unwrapped-way", "E2"),
        Hypothesis("unwrapped-goal", "E2", kind="goal"),
        *(Hypothesis(name, "gain-delay", frozenset(GAINS)) for name in GAINS),
        *(Hypothesis(f"{name}-way", "gain-delay", kind="way") for name in GAINS),
        *(Hypothesis(f"{name}-goal", "gain-delay", kind="goal") for name in GAINS),
        Hypothesis("no-goal", "goal-heading", kind="goal"),
        Hypothesis("heading-forgotten", "goal-heading", kind="goal"),
        *(
            Hypothesis(name, "goal-place")
            for name in ("goal-x", "goal-y", "goal-square", "goal-sum")
        ),
        *(
            Hypothesis(f"{part}-{rule}", "distance")
            for rule in ("sum", "square", "x", "y")
            for part in ("path", "all")
        ),
        Hypothesis("goal-heading-alone", "own-heading", kind="goal"),
        Hypothesis("from-start", "look-behind", frozenset(TARGETS)),
        Hypothesis("before", "look-behind", frozenset(TARGETS)),
        Hypothesis("nearest", "no-look-ahead", frozenset(TARGETS)),
        Hypothesis("next", "no-look-ahead", frozenset(TARGETS)),
        Hypothesis("from-far", "no-look-ahead", frozenset(TARGETS)),
        *(Hypothesis(f"further-{n}", "points-counted", frozenset(TARGETS)) for n in FURTHER),
        Hypothesis("last", "corners-cut", frozenset(TARGETS)),
        Hypothesis("own-heading", "own-heading", frozenset(ERRORS)),
        Hypothesis("heading-added", "own-heading", frozenset(ERRORS)),
        Hypothesis("axes", "bearing-axes", frozenset(ERRORS)),
        Hypothesis("from-target", "bearing-back", frozenset(ERRORS)),
        Hypothesis("from-nearest", "ahead-along", frozenset(TARGETS)),
        *(Hypothesis(name, "end-lost", frozenset([*TARGETS, *ENDS])) for name in ENDS),
        Hypothesis("full-speed", "full-speed"),
        Hypothesis("backwards", "backwards"),
        Hypothesis("cosine-size", "drives-away"),
        Hypothesis("ahead-rooted", "ahead-rooted"),
        Hypothesis("drives-on", "drives-on", kind="goal"),
        Hypothesis("degrees", "S4"),
        Hypothesis("degrees-turn", "S4"),
        Hypothesis("sine-turn", "turn-sine"),
    ),
    signs=signs,
    show=show,
    picture=picture,
    situation=situation,
)
