"""What is counted of claims, against cases that are counted by hand."""

import math

import numpy as np
import pytest
from claims_made import PERIOD, claims_made

from app.features.lab.evaluation.integrity.claims import COLUMNS, claims_csv, read_numbers
from app.features.lab.evaluation.integrity.measures import longest, measures
from app.features.lab.evaluation.integrity.oracle import decision_measures
from app.features.lab.evaluation.integrity.summary import (
    EXPECTED,
    PLACE_BINS,
    causes_of,
    counted,
    group_summary,
    summary_of,
    trade,
)
from robot.localization.estimate import Cause, State

CERTAIN, LOST, APPROXIMATE = State.CERTAIN, State.LOST, State.APPROXIMATE


def test_a_good_robot_is_right_sure_and_never_misleading():
    found = measures(claims_made([0.001] * 40))
    assert (found["pictures"], found["right"], found["sure"], found["misleading"]) == (40, 1, 1, 0)
    assert found["right_to_the_end"] and not found["lost_again"]
    assert found["time_to_right_s"] == 0
    assert found["ate_rmse_m"] == pytest.approx(0.001)
    assert found["nees_mean"] == pytest.approx(0.04)
    assert found["inside_95"] == 1
    assert found["available"] == 1
    assert found["bound_mean_m"] == pytest.approx(0.01)


def test_certain_beyond_the_radius_is_misleading_and_approximate_is_not():
    errors = [0.0] * 10 + [0.02] * 5 + [0.0] * 25
    found = measures(claims_made(errors))
    assert found["misleading"] == pytest.approx(5 / 40)
    assert found["misleading_longest_s"] == pytest.approx(0.5)
    assert measures(claims_made(errors, APPROXIMATE))["misleading"] == 0
    assert measures(claims_made(errors, radius=0.03))["misleading"] == 0


def test_a_heading_beyond_its_bound_is_misleading():
    assert measures(claims_made([0.0] * 20, turn=math.radians(4)))["misleading"] == 1
    assert measures(claims_made([0.0] * 20, turn=math.radians(-4)))["misleading"] == 1
    assert measures(claims_made([0.0] * 20, turn=math.radians(-2)))["misleading"] == 0


def test_lost_again_needs_a_second_of_being_right_and_certain():
    errors = [0.0] * 20 + [0.06] + [0.0] * 20
    assert measures(claims_made(errors))["lost_again"]
    assert not measures(claims_made(errors))["right_to_the_end"]
    assert not measures(claims_made(errors, APPROXIMATE))["lost_again"]
    assert not measures(claims_made(errors[15:]))["lost_again"]


def test_a_robot_that_is_carried_off_is_not_lost_again_but_has_to_be_right_anew():
    errors = [0.0] * 30 + [0.5] * 20 + [0.0] * 30
    found = measures(claims_made(errors, carry_stamp=2.9))
    assert not found["lost_again"] and found["right_to_the_end"]
    assert found["time_to_right_s"] == pytest.approx(2.0)
    assert found["misleading_before_carry"] == 0
    assert found["misleading_first_second"] == 1
    assert found["misleading_later"] == pytest.approx(10 / 40)
    assert found["misleading_later_longest_s"] == pytest.approx(1.0)
    twice = [*errors, 0.5, *[0.0] * 5]
    assert measures(claims_made(twice, carry_stamp=2.9))["lost_again"]


def test_an_alarm_counts_where_it_is_right_within_the_bound():
    states = [CERTAIN] * 10 + [LOST] * 10 + [State.SEARCHING] * 10 + [State.AMBIGUOUS] * 10
    radius = [0.01 if state is CERTAIN else math.inf for state in states]
    found = measures(claims_made([0.001] * 40, states, radius))
    assert found["alarm_while_right"] == pytest.approx(0.5)
    assert found["sure_while_right"] == pytest.approx(0.25)
    errors = [0.001] * 10 + [0.2] * 30
    assert measures(claims_made(errors, states, radius))["alarm_while_right"] == 0


def test_pictures_without_an_estimate_are_wrong_and_have_no_error():
    nowhere = [math.nan] * 10 + [0.001] * 30
    states = [State.SEARCHING] * 10 + [CERTAIN] * 30
    found = measures(claims_made(nowhere, states, [math.inf] * 10 + [0.01] * 30))
    assert found["right"] == pytest.approx(0.75)
    assert found["time_to_right_s"] == pytest.approx(1.0)
    assert found["ate_rmse_m"] == pytest.approx(0.001)


def test_a_claim_holds_until_the_next_picture():
    stamps = np.array([0.0, 0.1, 2.1, 2.2])
    assert longest(stamps, np.array([False, True, False, False])) == pytest.approx(2.0)
    assert longest(stamps, np.array([False, False, False, True])) == pytest.approx(0.1)
    assert longest(stamps, np.zeros(4, dtype=bool)) == 0


def test_certain_before_the_field_has_decided_is_unfounded():
    claims = claims_made([0.5] * 10 + [0.0] * 30)
    found = decision_measures(claims, 0.5)
    assert found["decided_s"] == pytest.approx(0.5)
    assert found["unfounded"] == pytest.approx(5 / 40)
    assert found["right_after_decided"] == pytest.approx(30 / 35)
    assert found["right_after_decided_s"] == pytest.approx(0.5)
    never = decision_measures(claims, math.inf)
    assert never["decided_s"] is None and never["unfounded"] == 1


def test_stanford_diagrams_count_each_claim_of_one_place():
    states = [CERTAIN] * 10 + [APPROXIMATE] * 5 + [LOST] * 5
    radius = [0.011] * 10 + [0.05] * 5 + [math.inf] * 5
    diagram = counted(claims_made([0.02] * 20, states, radius))
    assert diagram.place.sum() == diagram.heading.sum() == 15
    assert diagram.unavailable == 5
    error, bound = (int(np.searchsorted(PLACE_BINS, value)) - 1 for value in (0.02, 0.011))
    assert diagram.place[error, bound] == 10
    both = diagram + diagram
    assert both.place.sum() == 30 and both.unavailable == 10


def test_the_trade_counts_what_a_limit_on_the_radius_lets_through():
    radius = [0.003] * 10 + [0.03] * 10 + [0.3] * 10
    one = counted(claims_made([0.001] * 10 + [0.05] * 20, radius=radius))
    available, outside = trade(one, 40)
    for limit, expected in ((0.01, (0.25, 0.0)), (0.1, (0.5, 0.25)), (1.0, (0.75, 0.25))):
        place = int(np.searchsorted(PLACE_BINS[1:], limit * 0.999))
        assert (available[place], outside[place]) == expected


def test_claims_are_read_as_they_were_written(tmp_path):
    claims = claims_made([0.001, math.nan], [CERTAIN, State.SEARCHING], [0.01, math.inf])
    path = tmp_path / "one.csv"
    path.write_text(claims_csv(claims))
    lines = path.read_text().splitlines()
    assert lines[0] == ",".join(COLUMNS)
    assert lines[0] == "stamp,true_x,true_y,true_theta,x,y,theta,state,radius,heading_bound,weight"
    numbers = read_numbers(path)
    np.testing.assert_allclose(numbers["x"], [0.001, np.nan])
    np.testing.assert_allclose(numbers["radius"], [0.01, np.inf])
    np.testing.assert_allclose(numbers["stamp"], [0, PERIOD])
    assert lines[2].split(",")[7] == "searching"


def row(**changes):
    about = {"map": "square", "condition": "askew", "start": "known", "seed": 0}
    claims = claims_made([0.0] * 20, cause=[None] * 5 + [Cause.CAMERA_ASKEW] * 15)
    return about | measures(claims) | changes


def test_a_cause_is_right_by_condition():
    rows = [row(), row(first_cause="wheel slip"), row(first_cause=None)]
    found = causes_of("askew", rows)
    assert found["first"]["camera askew"] == found["first"]["wheel slip"] == 1
    assert found["first"]["none"] == 1
    assert found["first_right"] == pytest.approx(1 / 3)
    assert found["first_alert_median_s"] == pytest.approx(0.5)
    assert causes_of("default", rows)["first_right"] is None
    assert "default" not in EXPECTED


def test_doubt_after_a_carry_is_no_false_alarm():
    cause = [None] * 30 + [Cause.MAP] * 30
    found = measures(claims_made([0.0] * 60, cause=cause, carry_stamp=2.95))
    assert (found["alert"], found["first_cause"], found["main_cause"]) == (0, None, None)
    early = measures(claims_made([0.0] * 60, cause=cause, carry_stamp=4.0))
    assert early["first_cause"] == "map" and early["alert"] == pytest.approx(11 / 41)


def test_shares_of_a_group_are_of_its_pictures():
    rows = [row(pictures=100, misleading=0.1), row(pictures=300, misleading=0.0, lost_again=True)]
    found = group_summary(rows)
    assert found["misleading"] == pytest.approx(0.025)
    assert (found["drives"], found["misleading_drives"], found["lost_again_drives"]) == (2, 1, 1)
    whole = summary_of([*rows, row(condition="late", start="carried")])
    assert [(one["condition"], one["start"]) for one in whole["groups"]] == [
        ("askew", "known"),
        ("late", "carried"),
    ]
