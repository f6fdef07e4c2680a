"""A robot that has looked around tells its filter the only place that is left."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from journeys import PAGE, JourneyBench

from app.features.lab.evaluation.navigation.trials import NavigationTrial
from app.features.navigation.messages import TakePlaceCommand
from app.settings.config import Config
from robot.errors import CommandError
from robot.localization.estimate import State

SD = np.array([0.01, 0.01, 0.03])


def place(x: float = 0.1, **more) -> TakePlaceCommand:
    said = {"y": 0.0, "theta": 0.0, "covariance": np.diag(SD**2).reshape(-1).tolist(), **more}
    return TakePlaceCommand(type="take_place", x=x, **said)


@pytest.fixture
def bench():
    made = JourneyBench()
    yield made
    made.close()


def test_it_is_as_given_and_taken_once(bench):
    """In a replay, the recorded command comes, and that of the journey which goes along."""
    earlier = bench.program.engine.localization.earlier
    before = len(earlier)
    bench.send(place(0.004))
    bench.go(0.2)
    assert bench.now.integrity.state is State.GIVEN
    assert len(earlier) == before + 1
    bench.send(place(0.3))
    bench.go(0.2)
    assert len(earlier) == before + 1
    bench.go(1.0)
    bench.send(place(0.004))
    bench.go(0.2)
    assert len(earlier) == before + 2


@pytest.mark.parametrize(
    ("said", "words"),
    [
        ({"x": 9.0}, "is not on the field square; valid is x -0.750 to"),
        ({"covariance": [-1.0, *[0.0] * 8]}, "covariance"),
    ],
)
def test_what_is_no_place_is_refused(bench, said, words):
    with pytest.raises(CommandError, match=words):
        bench.send(place(**said), PAGE)


@pytest.mark.slow
def test_in_a_corner_where_the_filter_sees_too_little_to_search_it_finds_itself():
    """Carried to a corner of *tee*, it knew where it was, and its filter stayed lost."""
    trial = NavigationTrial(replace(Config(), map="tee", seed=7900), "carried")
    try:
        row = trial.journey(0)
    finally:
        trial.close()
    assert row["moved"] and row["state"] == "arrived", row
    assert row["error_m"] < 0.003
