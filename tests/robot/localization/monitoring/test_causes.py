"""Which reason is told, from when, and until when."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from robot.localization.estimate import Cause
from robot.localization.monitoring.causes import CLEARED, FLAT_RAYS, RAISED, Causes, Findings
from robot.localization.monitoring.mounting_check import ApparentErrors
from robot.localization.monitoring.odometry_check import ERRORS, OdometryErrors

PERIOD = 0.1


def findings(stamp: float, **found: Any) -> Findings:
    """What was found; by default nothing. Steady errors by their names, each well known."""
    values = np.array([found.get(name, 0.0) for name in ERRORS])
    sds = np.array([0.002, 0.003, 0.04, 0.01, 0.001, 0.001, 0.002])
    rest, explains = found.get("rest", (1.0, 1.0, 1.0)), found.get("tilt_explains", 0.0)
    tilt = math.radians(found.get("pitch", 0.0))
    return Findings(
        stamp,
        PERIOD,
        OdometryErrors(values, np.diag(np.square(sds)), np.array(rest), 50.0),
        ApparentErrors(tilt, 0.0, 0.0, 1e-8 * np.eye(3), explains, 0.1),
        found.get("returned", 60),
        found.get("spread", 0.5),
        found.get("width", 0.002),
        found.get("stuck_for", math.inf),
        found.get("fit_change", 0.0),
        found.get("model_suspected", True),
    )


def told(causes: Causes, seconds: float, begin: float = 0.0, **found: Any) -> list[Cause]:
    for tick in range(round(seconds / PERIOD)):
        causes.judge(findings(begin + PERIOD * tick, **found))
    return [alert.cause for alert in causes.alerts]


CASES: list[tuple[Cause, str, dict[str, Any]]] = [
    (Cause.CAMERA_ASKEW, "0.5°", {"pitch": 0.5, "tilt_explains": 0.8}),
    (Cause.PICTURES_LATE, "30 ms", {"late": 0.03}),
    (Cause.WHEEL_SLIP, "slip", {"rest": (1.0, 1.0, 4.0)}),
    (Cause.WHEEL_SLIP, "stuck", {"rest": (3.0, 1.0, 1.0), "stuck_for": 1.0}),
    (Cause.MAP, "map", {"rest": (3.0, 1.0, 1.0)}),
    (Cause.WHEEL_SIZE, "+5 %", {"forward": 0.05}),
    (Cause.WHEEL_SIZE, "-29° a metre", {"turn_by_way": -0.5}),
    (Cause.MODEL, "do not fit", {"fit_change": -2.5}),
    (Cause.MODEL, "alike", {"spread": 1.0, "width": 0.05}),
]


@pytest.mark.parametrize(("cause", "words", "found"), CASES, ids=[one[1] for one in CASES])
def test_each_pattern_has_its_reason_with_its_size(
    cause: Cause, words: str, found: dict[str, Any]
) -> None:
    causes = Causes()
    assert told(causes, RAISED + 2 * PERIOD, **found) == [cause]
    assert words in causes.alerts[0].text


@pytest.mark.parametrize(
    "found",
    [
        {},
        {"late": 0.005},
        {"pitch": 0.5, "tilt_explains": 0.1},
        {"pitch": 0.05, "tilt_explains": 0.9},
        {"forward": 0.02},
        {"spread": 1.0, "width": 0.05, "returned": FLAT_RAYS - 1},
        {"spread": 1.0, "width": 0.002},
        {"fit_change": -1.5},
        {"fit_change": -2.5, "model_suspected": False},
        {"spread": 1.0, "width": 0.05, "model_suspected": False},
    ],
    ids=str,
)
def test_what_is_usual_or_unsure_is_no_reason(found: dict[str, Any]) -> None:
    assert told(Causes(), 5.0, **found) == []


def test_it_is_raised_when_it_lasts_and_goes_away_some_seconds_after() -> None:
    causes = Causes()
    assert told(causes, RAISED - PERIOD, late=0.03) == []
    assert told(causes, 2 * PERIOD, 1.0, late=0.03) == [Cause.PICTURES_LATE]
    assert told(causes, CLEARED - 0.5, 1.5) == [Cause.PICTURES_LATE]
    assert told(causes, 1.0, 1.5 + CLEARED) == []


def test_reasons_that_take_turns_too_quickly_are_none() -> None:
    causes = Causes()
    for turn in range(10):
        told(causes, 2 * PERIOD, turn * 0.4, late=0.03)
        assert told(causes, 2 * PERIOD, turn * 0.4 + 0.2, forward=0.05) == []


def test_the_newest_reason_is_told_first_and_forgotten_all_are_gone() -> None:
    causes = Causes()
    told(causes, 1.0, 0.0, late=0.03)
    both = told(causes, 1.0, 1.0, forward=0.05)
    assert both == [Cause.WHEEL_SIZE, Cause.PICTURES_LATE]
    causes.forget()
    assert causes.alerts == ()
