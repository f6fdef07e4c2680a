"""Robots that are not as drawn: what is wrong is named, and nothing certain is untrue."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from app.features.lab.evaluation.integrity.claims import Claims, follow_claims
from app.features.lab.evaluation.integrity.drives import lap_drive
from app.settings.conditions import apply_condition
from app.settings.config import Config
from robot.driving.figure_eight import FigureEight
from robot.localization.estimate import BOUNDED, Cause, State

pytestmark = pytest.mark.slow

PLAIN = Config(robot="sim", map="stub", figure_eight=FigureEight(speed=0.25))
BROUGHT_IN = 1.0
"""Until then what was told of the start may be what is off [s]."""


def claims_of(condition: str, seed: int) -> Claims:
    """Of most of a lap of a robot in a condition, its start known."""
    config = apply_condition(replace(PLAIN, seed=seed), condition)
    return follow_claims(lap_drive(config, 0.9), config, "known")


def check_true(claims: Claims) -> None:
    """Never certain outside the bound, nor lost."""
    certain = np.array([state is State.CERTAIN for state in claims.states])
    outside = (claims.distances > claims.radius) | (claims.turns > claims.heading_bound)
    since = claims.stamps - claims.stamps[0]
    assert not (certain & outside)[since > BROUGHT_IN].any()
    assert (certain & outside).sum() <= 2
    assert State.LOST not in claims.states and State.SEARCHING not in claims.states
    assert claims.distances[since > BROUGHT_IN].max() < 0.030


CASES = [
    ("askew", 101, Cause.CAMERA_ASKEW),
    ("late", 104, Cause.PICTURES_LATE),
    ("slippery", 102, Cause.WHEEL_SLIP),
]


@pytest.mark.parametrize(("condition", "seed", "cause"), CASES, ids=[one[0] for one in CASES])
def test_what_is_wrong_is_named_within_ten_seconds(condition: str, seed: int, cause: Cause) -> None:
    claims = claims_of(condition, seed)
    check_true(claims)
    told = [one for one in claims.causes if one is not None]
    assert told and set(told) == {cause}
    first = next(i for i, one in enumerate(claims.causes) if one is not None)
    assert claims.stamps[first] - claims.stamps[0] < 10


@pytest.mark.parametrize("seed", [102, 103, 105])
def test_a_robot_as_usual_raises_no_alert(seed: int) -> None:
    claims = claims_of("default", seed)
    check_true(claims)
    assert set(claims.causes) == {None}
    since = claims.stamps - claims.stamps[0]
    bounded = np.array([state in BOUNDED for state in claims.states])
    assert bounded[since > 3].mean() > 0.9
    assert claims.states[-1] is State.CERTAIN
