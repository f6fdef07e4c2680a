"""Lesson 1: ``odometry(pose, left, right, track)`` gives the pose after the wheels have rolled."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence

import numpy as np

from app.features.course.grader.case import Case, Checks, Hypothesis, Outcome, Sign, by_mistake
from app.features.course.grader.drawing import draw_poses
from app.features.course.grader.forms import array_of, heading_signs, pose_features
from app.features.course.grader.words import Words
from robot.geometry import Array, wrap_angle

TRACK = 0.11
TOLERANCE = np.array([1.5e-5, 1.5e-5, 2e-6, 2e-6])
"""[m, m] and of cosine and sine: a chord in the middle's direction is as good as an arc."""
STEPS: tuple[tuple[str, str, float, float], ...] = (
    ("line", "Both wheels roll {left} mm.", 0.03, 0.03),
    ("spin", "It turns on the spot: left {left} mm, right {right} mm.", -0.0027, 0.0027),
    ("spin", "It turns on the spot: left {left} mm, right {right} mm.", 0.0022, -0.0022),
    ("line", "Both wheels roll {left} mm: it backs.", -0.02, -0.02),
    ("arc", "An arc to the left: left {left} mm, right {right} mm.", 0.026, 0.031),
    ("arc", "An arc to the right: left {left} mm, right {right} mm.", 0.03, 0.0255),
    ("arc", "An arc backwards: left {left} mm, right {right} mm.", -0.022, -0.027),
    ("arc", "A slight arc: left {left} mm, right {right} mm.", 0.03, 0.0306),
    ("arc", "Only the right wheel rolls: {right} mm.", 0.0, 0.005),
    ("arc", "Only the left wheel rolls: {left} mm.", 0.0048, 0.0),
)

LEFT_SPIN, RIGHT_SPIN = [step for step in STEPS if step[0] == "spin"]
LEFT_ARC, RIGHT_ARC = [step for step in STEPS if step[0] == "arc"][:2]
WAYS: dict[str, Callable[[float, float], float]] = {
    "absolute": lambda left, right: (abs(left) + abs(right)) / 2,
    "right-wheel": lambda _left, right: right,
    "left-wheel": lambda left, _right: left,
    "larger": lambda left, right: max(left, right, key=abs),
    "twice": lambda left, right: left + right,
    "difference": lambda left, right: (right - left) / 2,
    "exchanged": lambda left, right: (right - left) / 2,
    "left-whole": lambda left, right: left + right / 2,
}
TURNS = {
    "other-way": -1.0,
    "half-turn": 0.5,
    "double-turn": 2.0,
    "turn-in-degrees": 180 / math.pi,
    "turn-to-radians": math.pi / 180,
}
DIRECTIONS = {"new-heading": 1.0, "old-heading": 0.0}
FUNCTIONS: dict[str, tuple[Callable[[float], float], Callable[[float], float]]] = {
    "sine-first": (math.sin, math.cos),
    "cosine-twice": (math.cos, math.cos),
    "sine-twice": (math.sin, math.sin),
}
"""Functions of the heading for x and y, where these are taken for each other."""
ARCS: dict[str, tuple[Callable[[float], float], Callable[[float], float]]] = {
    "arc-leftwards": (lambda angle: -math.sin(angle), math.cos),
    "arc-rightwards": (math.sin, lambda angle: -math.cos(angle)),
    "arc-mirrored": (math.sin, math.cos),
    "arc-mirrored-back": (lambda angle: -math.sin(angle), lambda angle: -math.cos(angle)),
    "arc-cosine-twice": (math.cos, math.cos),
    "arc-sine-twice": (math.sin, math.sin),
    "arc-half-turned": (lambda angle: -math.sin(angle), math.sin),
}
"""Functions of the middle's heading that arcs take where the formula of a circle has cosines for
sines; straight ahead has a line of its own there, which is right."""
SHARES = {"middle-returned": 0.5, "half-more": 1.5}
"""How much of the turn is in the heading that comes back, where half of it is for the way."""


def cases(seed: int) -> list[Case]:
    """Each step from heading 0, then from poses by the seed; then where the heading wraps."""
    rng = np.random.default_rng(seed)
    starts = [np.zeros(3)] * len(STEPS)
    starts += [rng.uniform([-1, -1, -math.pi], [1, 1, math.pi]) for _ in STEPS]
    made = [_case(start, step, TRACK) for start, step in zip(starts, STEPS + STEPS, strict=True)]
    made.append(_case(rng.uniform(-1, 1, 3), LEFT_ARC, 0.2))
    made += [
        _case(np.array([0.5, 0.5, math.pi - 0.01]), LEFT_SPIN, TRACK),
        _case(np.array([0.5, 0.5, 0.01 - math.pi]), RIGHT_SPIN, TRACK),
        _case(np.array([0.5, 0.5, math.pi - 0.01]), LEFT_ARC, TRACK),
        _case(np.array([0.5, 0.5, 0.01 - math.pi]), RIGHT_ARC, TRACK),
    ]
    return made


def _case(start: Array, step: tuple[str, str, float, float], track: float) -> Case:
    kind, text, left, right = step
    words = Words(
        "{step} It starts at x {x} mm, y {y} mm, heading {heading}°; track {track} mm.",
        {
            "step": Words(text, {"left": _mm(left), "right": _mm(right)}),
            "x": _mm(start[0]),
            "y": _mm(start[1]),
            "heading": round(math.degrees(start[2]), 1),
            "track": _mm(track),
        },
    )
    return Case("odometry", (start, left, right, track), words, kind, TOLERANCE)


def features(outcome: Outcome) -> Array:
    """The pose, its heading as cosine and sine."""
    return pose_features(array_of(outcome.result, (3,)))


def expected(case: Case, mistakes: frozenset[str]) -> Array:
    """The pose that a formula with mistakes gives."""
    pose, left, right, track = case.arguments
    way, turn = _way(left, right, mistakes), (right - left) / track
    turn = right - left / track if "right-whole" in mistakes else turn
    if mistakes & {"turn-summed", "exchanged"}:
        turn = (right + left) / track
    if "turn-right-alone" in mistakes:
        turn = right / track
    if "turn-left-alone" in mistakes:
        turn = left / track
    if "turn-times-track" in mistakes:
        turn = (right - left) * track
    if "turn-undivided" in mistakes:
        turn = right - left
    turn = abs(turn) if "turn-one-way" in mistakes else turn
    turn = 0.0 if "spin-kept" in mistakes and left == -right else turn
    turn *= next((share for name, share in TURNS.items() if name in mistakes), 1.0)
    way = 0.0 if "straight-kept" in mistakes and left == right else way
    direction = _direction(float(pose[2]), turn, mistakes)
    along_x = pose[2] if "old-heading-x" in mistakes else direction
    along_y = pose[2] if "old-heading-y" in mistakes else direction
    x_of, y_of = by_mistake(mistakes, FUNCTIONS, (math.cos, math.sin))
    if left != right:
        x_of, y_of = by_mistake(mistakes, ARCS, (x_of, y_of))
    x, y = way * x_of(along_x), way * y_of(along_y)
    turn *= next((share for name, share in SHARES.items() if name in mistakes), 1.0)
    theta = turn if "heading-lost" in mistakes else pose[2] + turn
    if "from-zero" in mistakes:
        return np.array([x, y, math.cos(theta), math.sin(theta)])
    theta = pose[2] if "turn-lost" in mistakes else theta
    x = 0.0 if "x-kept" in mistakes else x
    y = 0.0 if "y-kept" in mistakes else y
    y = -y if "sine-negative" in mistakes else y
    return np.array([pose[0] + x, pose[1] + y, math.cos(theta), math.sin(theta)])


def _direction(heading: float, turn: float, mistakes: frozenset[str]) -> float:
    ahead = next((share for name, share in DIRECTIONS.items() if name in mistakes), 0.5)
    direction = heading + ahead * turn
    if "wrapped-middle" in mistakes:
        direction = (heading + float(wrap_angle(heading + turn))) / 2
    if "no-heading" in mistakes:
        direction -= heading
    return math.radians(direction) if "degrees" in mistakes else direction


def _way(left: float, right: float, mistakes: frozenset[str]) -> float:
    rule = next((rule for name, rule in WAYS.items() if name in mistakes), None)
    return rule(left, right) if rule else (left + right) / 2


def signs(outcomes: Sequence[Outcome]) -> Iterator[Sign]:
    """What shows by itself: headings out of range, spins that move, arcs in a wrong direction."""
    wrong = [item for item in outcomes if not _right(item)]
    if wrong and all(_turned_round(item) for item in wrong):
        yield Sign("wrap-half", wrong[0])
    yield from heading_signs(outcomes, [array_of(item.result, (3,))[None] for item in outcomes])
    turned = [item for item in outcomes if item.case.kind == "spin"]
    spins = [item for item in turned if _moved(item) > 1e-4]
    if spins and len(spins) == len(turned) and all(_right(item) for item in outcomes[:1]):
        yield Sign("M4", spins[0], weak=True)
    shares = [_turn_share(item) for item in outcomes if item.case.kind in ("spin", "arc")]
    usual = not shares or min(abs(np.mean(shares)), abs(np.mean(shares) - 1)) < 0.05
    if wrong and not usual and np.ptp(shares) < 0.05:
        yield Sign("track" if shares[0] > 0 else "turn-sign", wrong[0], weak=True)
        return  # where it comes to follows from that
    arcs = [item for item in outcomes if item.case.kind == "arc"]
    if arcs and not spins and all(abs(_ahead(item) - 1.0) < 0.2 for item in arcs):
        yield Sign("M2", arcs[0], weak=True)
    if wrong:
        apart = np.abs(features(wrong[0]) - expected(wrong[0].case, frozenset())) < TOLERANCE
        place, heading = bool(apart[:2].all()), bool(apart[2:].all())
        area = "place" if heading else "heading" if place else "step"
        yield Sign(area, wrong[0], weak=True)


def _right(outcome: Outcome) -> bool:
    return bool((np.abs(features(outcome) - expected(outcome.case, frozenset())) < TOLERANCE).all())


def _turned_round(outcome: Outcome) -> bool:
    """Return whether only the heading is wrong, and looks the other way."""
    given, due = features(outcome), expected(outcome.case, frozenset())
    return bool((np.abs(given - due * [1, 1, -1, -1]) < TOLERANCE).all())


def _turn_share(outcome: Outcome) -> float:
    """Return how much of the turn that is due has been made."""
    pose, left, right, track = outcome.case.arguments
    turned = wrap_angle(float(outcome.result[2]) - float(pose[2]))
    return float(turned) / (float(right - left) / float(track))


def _moved(outcome: Outcome) -> float:
    x, y = outcome.result[:2] - outcome.case.arguments[0][:2]
    return math.hypot(x, y)


def _ahead(outcome: Outcome) -> float:
    """Return the share of the turn that had been added before the way was taken."""
    pose, left, right, track = outcome.case.arguments
    x, y = outcome.result[:2] - pose[:2]
    backwards = math.pi if left + right < 0 else 0.0
    turned = wrap_angle(math.atan2(y, x) + backwards - float(pose[2]))
    return turned / (float(right - left) / float(track))


def show(_case: Case, values: Array) -> str:
    """Return features as a pose in words."""
    heading = math.degrees(math.atan2(values[3], values[2]))
    return f"x {1000 * values[0]:.2f} mm, y {1000 * values[1]:.2f} mm, {heading:.2f}°"


def picture(outcome: Outcome, due: Array, given: Array) -> str:
    """Draw where it starts, where it is due, and where the code puts it."""
    start = pose_features(outcome.case.arguments[0])
    return draw_poses({"start": start, "due": due, "given": given})


def situation(case: Case) -> dict[str, float]:
    """The start, to put the robot there; where the dashboard's square ends, beside it."""
    x, y, theta = np.clip(case.arguments[0], [-0.4, -0.4, -np.inf], [0.4, 0.4, np.inf])
    return {"x": x, "y": y, "theta": theta}


def _mm(value: float) -> float:
    return round(1000 * value, 1)


CHECKS = Checks(
    functions=("odometry",),
    cases=cases,
    features=features,
    expected=expected,
    hypotheses=(
        Hypothesis("new-heading", "M2", frozenset(["old-heading"])),
        Hypothesis("old-heading", "old-heading"),
        *(Hypothesis(name, "M4", frozenset(WAYS)) for name in list(WAYS)[:4]),
        Hypothesis("twice", "way"),
        Hypothesis("difference", "way"),
        Hypothesis("exchanged", "way-for-turn", frozenset([*WAYS, *TURNS])),
        Hypothesis("left-whole", "brackets", frozenset(WAYS)),
        Hypothesis("right-whole", "brackets", frozenset(TURNS)),
        Hypothesis("other-way", "turn-sign", frozenset(TURNS)),
        Hypothesis("half-turn", "track", frozenset(TURNS)),
        Hypothesis("double-turn", "track", frozenset(TURNS)),
        Hypothesis("turn-in-degrees", "S4", frozenset(TURNS)),
        Hypothesis("turn-to-radians", "S4", frozenset(TURNS)),
        Hypothesis("degrees", "S4"),
        Hypothesis("no-heading", "M1"),
        Hypothesis("wrapped-middle", "middle-wrapped"),
        Hypothesis("sine-first", "sine"),
        Hypothesis("cosine-twice", "same-function"),
        Hypothesis("sine-twice", "same-function"),
        *(Hypothesis(name, "arc-sine", frozenset([*ARCS, *FUNCTIONS]), "arc") for name in ARCS),
        Hypothesis("from-zero", "start-lost"),
        Hypothesis("heading-lost", "start-lost"),
        Hypothesis("old-heading-x", "old-heading"),
        Hypothesis("old-heading-y", "old-heading"),
        Hypothesis("turn-lost", "turn-lost"),
        Hypothesis("straight-kept", "straight-lost"),
        Hypothesis("spin-kept", "spin-lost"),
        Hypothesis("x-kept", "axis-lost"),
        Hypothesis("y-kept", "axis-lost"),
        Hypothesis("sine-negative", "slip-sign", broad=True),
        Hypothesis("turn-summed", "turn-summed", frozenset(TURNS)),
        Hypothesis("turn-right-alone", "one-wheel-turns", frozenset(TURNS)),
        Hypothesis("turn-left-alone", "one-wheel-turns", frozenset(TURNS)),
        Hypothesis("turn-times-track", "track", frozenset(TURNS)),
        Hypothesis("turn-undivided", "track", frozenset(TURNS)),
        Hypothesis("turn-one-way", "turn-one-way", frozenset(TURNS)),
        *(Hypothesis(name, "half-for-way", frozenset(SHARES)) for name in SHARES),
    ),
    signs=signs,
    show=show,
    picture=picture,
    situation=situation,
)
