"""On journeys, with their turns on the spot, punctual pictures are taken for punctual."""

from __future__ import annotations

import pytest
from simulators import require_engine

from app.features.lab.evaluation.navigation.trials import NavigationTrial
from app.features.plausibility.checks import PlausibilityChecks
from app.settings.conditions import apply_condition
from app.settings.config import Config
from robot.localization.estimate import Cause

pytestmark = pytest.mark.slow


@pytest.mark.parametrize(
    ("field", "seed", "goals"), [("tee", 9300, 2), ("generated-9202", 9301, 8)]
)
def test_tape_that_comes_into_sight_as_the_robot_turns_is_no_late_picture(
    field: str, seed: int, goals: int
) -> None:
    """Robots were lost on the way to these goals."""
    require_engine("mujoco")
    trial = NavigationTrial(
        apply_condition(Config(robot="sim", map=field, seed=seed), "default"), "goals"
    )
    (checks,) = [m for m in trial.engine.localization.added if isinstance(m, PlausibilityChecks)]
    late: list[float] = []
    advise = checks.advise

    def noted(monitor) -> None:
        advise(monitor)
        if any(alert.cause is Cause.PICTURES_LATE for alert in checks.alerts):
            late.append(checks.memory.stamp)

    checks.advise = noted
    rows = [trial.journey(number) for number in range(goals)]
    trial.close()
    assert {row["state"] for row in rows} == {"arrived"}
    assert not late
