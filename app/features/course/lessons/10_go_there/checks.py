"""Lesson 10: ``go_there(pose, path, goal, speed, ahead, delay)`` steers a robot along a way."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

import numpy as np

from app.features.course.grader.case import REFERENCE, Case, Checks, Hypothesis, Outcome, Sign
from app.features.course.grader.drawing import draw_bars
from app.features.course.grader.forms import array_of
from app.features.course.grader.mistaken_steering import (
    BROUGHT_BACK,
    ENDS,
    ERRORS,
    FURTHER,
    GAINS,
    GOAL_TURNS,
    SPEED_ANGLES,
    TARGETS,
    commanded,
)
from app.features.course.grader.steering_signs import Commanded, signs_of
from app.features.course.grader.words import Words
from robot.geometry import Array, wrap_angle

SPEED, AHEAD, DELAY = 0.2, 0.1, 0.1
STEP_M = 0.02
"""From one point of a way to the next; all numbers of the cases are off it by a little, so that no
distance equals ``ahead`` up to rounding."""
PARTS = ("", "-way", "-goal")
"""Where a mistake can be made that fits both errors."""
TURNS = {
    "unsigned": "turn-unsigned", "degrees": "S4", "degrees-turn": "S4", "sine-turn": "turn-sine",
    "folded": "turn-sine", "folded-turn": "turn-sine",
}  # fmt: skip
"""What can be wrong with how an error becomes a turn, by its cause."""
DIRECTIONS = {
    "own-heading": "own-heading", "heading-added": "own-heading", "heading-axes": "sine",
    "axes": "bearing-axes", "axes-own": "bearing-axes", "from-target": "bearing-back",
    "ratio": "no-arctan", "half-plane": "half-plane", "half-sine": "half-plane",
    "half-cosine": "half-plane", "half-own": "half-plane", "from-origin": "map-frame",
    "shifted-late": "map-frame", "along-way": "way-direction", "way-there": "way-direction",
    "way-here": "way-direction", "degrees-heading": "S4", "degrees-bearing": "S4",
    "goal-always": "goal-early",
}  # fmt: skip
"""What else the direction to a point can be made of, by its cause."""
ALIKE = frozenset(["heading-axes", "degrees-heading", "degrees-bearing"])
"""Those of them of which a slip in a line says more."""


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
        _case("way", "It is close to its goal.", (0.2843, 0.0087, 0.3), straight, 1.0, ahead=0.2),
        _case("way", "The goal is near.", (0.153, 0.021, 0.1), straight, 1.0, ahead=0.2),
        _case("way", "It is past its goal.", (0.331, 0.011, 2.5), straight, 1.0),
        _case("goal", "It is at the goal.", (0.2935, 0.0055, 0.4), straight, -2.6),
        _case("way", "It is at a point of its way.", (-0.0813, 0.0011, 0.2), straight, 0.0),
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
    return commanded(case.arguments, mistakes)


def signs(outcomes: Sequence[Outcome]) -> Iterator[Sign]:
    """What shows by itself in the speeds of all cases."""
    return signs_of(
        [Commanded(item, features(item), expected(item.case, REFERENCE)) for item in outcomes]
    )


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
        Hypothesis("sign-goal", "goal-away", kind="goal"),
        *(
            Hypothesis(f"{name}{part}", "E2", frozenset(BROUGHT_BACK), kind=part[1:])
            for name in BROUGHT_BACK
            for part in PARTS
            if (name, part) != ("half-round", "-way")  # rather a direction of half a plane
        ),
        *(Hypothesis(name, "gain-delay", frozenset(GAINS)) for name in GAINS),
        *(Hypothesis(f"{name}-way", "gain-delay", kind="way") for name in GAINS),
        *(Hypothesis(f"{name}-goal", "gain-delay", kind="goal") for name in GAINS),
        Hypothesis("no-goal", "goal-heading", kind="goal"),
        Hypothesis("heading-forgotten", "goal-heading", kind="goal"),
        *(
            Hypothesis(name, "goal-heading", frozenset(GOAL_TURNS), kind="goal")
            for name in ("goal-piece", "goal-bearing", "goal-zero")
        ),
        *(
            Hypothesis(name, "own-heading", frozenset(GOAL_TURNS), kind="goal")
            for name in ("goal-heading-alone", "goal-added")
        ),
        *(
            Hypothesis(name, "goal-place")
            for name in ("goal-x", "goal-y", "goal-square", "goal-sum")
        ),
        *(Hypothesis(name, "goal-reach") for name in ("goal-nearest", "goal-within-ahead")),
        Hypothesis("goal-rooted", "goal-rooted", broad=True),
        *(
            Hypothesis(f"{part}-{rule}", "distance")
            for rule in ("sum", "square", "x", "y")
            for part in ("path", "all")
        ),
        Hypothesis("from-start", "look-behind", frozenset(TARGETS)),
        Hypothesis("from-start-or-last", "look-behind", frozenset(TARGETS)),
        Hypothesis("before", "look-behind", frozenset(TARGETS)),
        Hypothesis("up-to-nearest", "look-behind", frozenset(TARGETS)),
        Hypothesis("nearest", "no-look-ahead", frozenset(TARGETS)),
        Hypothesis("next", "no-look-ahead", frozenset(TARGETS)),
        Hypothesis("from-far", "no-look-ahead", frozenset(TARGETS)),
        Hypothesis("one-less", "no-look-ahead", frozenset(TARGETS), broad=True),
        Hypothesis("at-ahead", "ahead-about", frozenset(TARGETS)),
        Hypothesis("at-ahead-whole", "ahead-about", frozenset(TARGETS)),
        *(Hypothesis(f"further-{n}", "points-counted", frozenset(TARGETS)) for n in FURTHER),
        Hypothesis("last", "corners-cut", frozenset(TARGETS)),
        Hypothesis("last-far", "corners-cut", frozenset(TARGETS)),
        Hypothesis("last-far-anywhere", "corners-cut", frozenset(TARGETS)),
        Hypothesis("larger-x", "ahead-axis", frozenset(TARGETS)),
        Hypothesis("in-front", "ahead-axis", frozenset(TARGETS)),
        *(
            Hypothesis(f"{name}{turn}", cause, frozenset(ERRORS), broad=name in ALIKE)
            for turn in ("", "-turn")
            for name, cause in DIRECTIONS.items()
        ),
        *(
            Hypothesis(name, "map-frame")
            for name in ("path-origin", "far-origin", "nearest-origin")
        ),
        Hypothesis("from-nearest", "ahead-along", frozenset(TARGETS)),
        *(Hypothesis(name, "end-lost", frozenset([*TARGETS, *ENDS])) for name in ENDS),
        Hypothesis("full-speed", "full-speed"),
        Hypothesis("backwards", "backwards"),
        Hypothesis("cosine-size", "drives-away"),
        Hypothesis("speed-sine", "sine", broad=True),
        *(Hypothesis(name, "speed-angle", broad=True) for name in SPEED_ANGLES),
        Hypothesis("ahead-rooted", "ahead-rooted"),
        Hypothesis("ahead-squared", "ahead-squared"),
        Hypothesis("drives-on", "drives-on", kind="goal"),
        *(
            Hypothesis(f"{name}{part}", cause, kind=part[1:])
            for name, cause in TURNS.items()
            for part in PARTS
        ),
    ),
    signs=signs,
    show=show,
    picture=picture,
    situation=situation,
)
