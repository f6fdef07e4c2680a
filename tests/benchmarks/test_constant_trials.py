"""The figures by which a constant is judged, of claims that were made by hand."""

from __future__ import annotations

import pytest
from claims_made import claims_made

from app.features.lab.evaluation.drives import Drive
from app.features.lab.evaluation.integrity.drives import TrialDrive
from app.settings.config import MAPS, Config
from benchmarks.constant_trials import ConstantTrial, figures
from robot.fields.field_loading import load_field
from robot.localization.estimate import Cause, State

NOWHERE = TrialDrive(Drive(load_field("stub", MAPS), []), None)


def trial(condition: str) -> ConstantTrial:
    return ConstantTrial(Config(), condition, "carried", NOWHERE)


def test_alarms_count_as_false_where_nothing_is_wrong_and_as_named_where_it_is() -> None:
    slip = [Cause.WHEEL_SLIP] * 10 + [None] * 30
    claims = claims_made([0.001] * 40, cause=slip, carry_stamp=1.95)
    shown = figures([(trial("default"), claims), (trial("slippery"), claims)])
    assert shown["false alarm [%]"] == pytest.approx(25)
    assert shown["cause named [%]"] == pytest.approx(50)


def test_in_the_second_after_the_carry_nobody_can_know() -> None:
    errors = [0.001] * 20 + [0.3] * 20
    claims = claims_made(errors, carry_stamp=1.95)
    # Pictures at 2.0 to 2.9 s are forgiven; those at 3.0 to 3.9 s are not.
    assert figures([(trial("default"), claims)])["misleading [%]"] == pytest.approx(25)


def test_who_is_not_found_again_counts() -> None:
    states = [State.SEARCHING] * 40
    claims = claims_made([0.001] * 20 + [0.3] * 20, state=states, carry_stamp=1.95)
    shown = figures([(trial("default"), claims)])
    assert shown["found [s]"] == 0 and shown["not found"] == 1 and shown["certain [%]"] == 0
