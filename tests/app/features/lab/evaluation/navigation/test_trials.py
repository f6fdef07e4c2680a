"""A correction of a pose that few rays made exact is no doubt: a journey by its seed."""

from __future__ import annotations

import pytest

from app.features.lab.evaluation.navigation.experiment import NavigationExperiment
from app.features.lab.evaluation.navigation.trials import COLUMNS, do_trial
from app.settings.config import Config


@pytest.mark.slow
def test_a_correction_of_a_pose_that_few_rays_made_exact_is_no_doubt() -> None:
    """It stood in doubt for 120 s a goal: a first glimpse of tape made the pose exact, and two
    pictures later a corner moved it by more than that, and by more than wheels explain."""
    experiment = NavigationExperiment(Config(), maps=("square",), seeds=1, first_seed=8800, goals=1)
    (planned,) = experiment.jobs()
    run = do_trial(planned.job)
    assert [row["state"] for row in run.rows] == ["arrived"]
    states = {tick[COLUMNS.index("state")] for tick in run.ticks}
    assert "certain" in states and "ambiguous" not in states
