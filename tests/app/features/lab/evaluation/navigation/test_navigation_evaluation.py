"""Journeys are evaluated by the truth, the same with any worker, and summed up."""

import json

import pytest

from app.command_line import main
from app.features.lab.evaluation.navigation.experiment import NavigationExperiment, summary_of
from app.settings.config import Config
from robot.settings import SettingError

ABOUT = {"map": "square", "condition": "default", "trial": "goals", "seed": 1}


def journey(**more):
    row = {
        "number": 0, "state": "arrived", "reason": "", "seconds": 6.0, "fastest_s": 4.0,
        "error_m": 0.001, "turn_rad": 0.0, "room_m": 0.02, "moved": False,
    }  # fmt: skip
    return ABOUT | row | more


def test_only_those_that_arrived_count_as_reached_and_others_say_why():
    (group,) = summary_of(
        [
            journey(),
            journey(error_m=0.003, seconds=10.0),
            journey(state="failed", reason="a wall", error_m=0.5, room_m=-0.001),
            {**ABOUT, "number": 3, "state": "no goal", "reason": "", "room_m": None},
        ]
    )
    assert (group["journeys"], group["reached"], group["over_tape"]) == (3, 2, 1)
    assert group["error_median_m"] == pytest.approx(0.002)
    assert group["error_worst_m"] == 0.003
    assert group["over_fastest_median"] == pytest.approx(2.0)
    assert group["least_room_m"] == -0.001
    assert group["not_reached"] == {"failed: a wall": 1}


def test_a_field_without_goals_has_a_summary():
    (group,) = summary_of([{**ABOUT, "number": 0, "state": "no goal", "room_m": None}])
    assert (group["journeys"], group["least_room_m"]) == (0, None)


@pytest.mark.parametrize(
    ("wrong", "words"),
    [
        ({"trials": ("flying",)}, "no trial 'flying'; valid are goals"),
        ({"goals": 0}, "goals is 0; valid is 1"),
        ({"minutes": 0.0}, "minutes is 0"),
        ({"calibrate": 1.0}, "--calibrate is 1"),
        ({"first_seed": -1}, "first seed is -1"),
    ],
)
def test_what_cannot_be_evaluated_is_refused(wrong, words):
    with pytest.raises(SettingError, match=words):
        NavigationExperiment(Config(), ("square",), **wrong)


@pytest.mark.slow
def test_a_robot_is_sent_to_goals_and_its_end_is_that_of_the_truth(tmp_path):
    file = tmp_path / "kinematic.toml"
    file.write_text('robot = "kinematic"\n')
    words = ["--map", "square", "--seeds", "1", "--goals", "1", "--workers", "1"]
    out = ["--config", str(file), "--out", str(tmp_path / "out")]
    assert main(["evaluate", "navigation", *words, *out]) == 0
    results = json.loads((tmp_path / "out" / "results.json").read_text("utf-8"))
    (row,) = results["journeys"]
    assert row["state"] == "arrived"
    assert row["error_m"] < 0.003
    assert row["room_m"] > 0
    assert (tmp_path / "out" / "report.html").is_file()
