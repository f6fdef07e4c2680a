"""Trials of a constant of navigation are repeatable, other numbers change them, and so it does."""

import pytest

from benchmarks import constant_journeys
from robot.navigation import navigator, tracker


def test_journeys_arrive_repeat_and_tell_a_poor_constant(monkeypatch, tmp_path):
    monkeypatch.setattr(constant_journeys, "ROUNDS", 1)
    monkeypatch.setattr(constant_journeys, "KINDS", ("usual", "pushed", "curve"))
    kept = tmp_path / "journeys"
    usual = constant_journeys.tried(constant_journeys.recorded(kept), 0)
    assert usual == constant_journeys.tried(constant_journeys.recorded(kept), 0)
    assert usual["not reached"] == 0
    assert usual["place off [mm]"] < 1.5
    other = constant_journeys.tried(constant_journeys.recorded(kept), 1000)
    assert other["each"] != usual["each"]
    monkeypatch.setattr(tracker, "ALONG_GAIN", 0.0)
    monkeypatch.setattr(tracker, "TURN_GAIN", 0.0)
    poor = constant_journeys.tried(constant_journeys.recorded(kept), 0)
    # One that hardly gets on is not far off its way.
    assert poor["not reached"] > 0


@pytest.mark.parametrize(("doubts", "looks"), [(0.5, False), (2.5, True)])
def test_a_robot_in_doubt_looks_around_if_that_lasts(monkeypatch, doubts, looks):
    monkeypatch.setattr(constant_journeys, "ROUNDS", 1)
    monkeypatch.setattr(constant_journeys, "KINDS", ("in doubt",))
    monkeypatch.setattr(constant_journeys, "DOUBTS_S", (doubts,))
    began = []
    begin = navigator.LookingAround.begin
    monkeypatch.setattr(
        navigator.LookingAround,
        "begin",
        lambda self, stamp: (began.append(stamp), begin(self, stamp)),
    )
    outcome = constant_journeys.tried(constant_journeys.recorded(None), 0)
    assert outcome["not reached"] == 0
    assert bool(began) is looks
