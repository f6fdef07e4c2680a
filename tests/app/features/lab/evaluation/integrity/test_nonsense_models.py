"""Sensor models as students write them first: what is wrong is said while the robot drives."""

from __future__ import annotations

from pathlib import Path

import pytest
from nonsense_models import GOOD, NONSENSE

from app.features.lab.evaluation.integrity.claims import Claims, follow_claims
from app.features.lab.evaluation.integrity.drives import TrialDrive, lap_drive
from app.features.lab.evaluation.integrity.measures import misleading
from app.settings.config import Config
from robot.localization.estimate import Cause

pytestmark = pytest.mark.slow

CONFIG = Config(robot="sim", map="stub", seed=1003)
DOUBTED = 5.0
"""Within so long [s]."""


@pytest.fixture(scope="module")
def lap() -> TrialDrive:
    return lap_drive(CONFIG, 0.45)


def claims_with(lap: TrialDrive, folder: Path, changed: str = "") -> Claims:
    path = folder / "model.py"
    path.write_text(f"{GOOD}\n\nclass Tried(Model):\n{changed or '    pass'}\n")
    config = Config(robot="sim", map="stub", seed=1003, sensor_model=f"{path}:Tried")
    return follow_claims(lap, config, "known")


@pytest.mark.parametrize("kind", NONSENSE)
def test_a_model_that_makes_no_sense_is_named_within_seconds(
    lap: TrialDrive, tmp_path: Path, kind: str
) -> None:
    claims = claims_with(lap, tmp_path, NONSENSE[kind])
    first = next(place for place, cause in enumerate(claims.causes) if cause is not None)
    assert claims.causes[first] is Cause.MODEL
    assert claims.stamps[first] - claims.stamps[0] < DOUBTED
    assert misleading(claims)[claims.stamps - claims.stamps[0] > DOUBTED].mean() < 0.01


def test_a_good_model_is_never_doubted(lap: TrialDrive, tmp_path: Path) -> None:
    claims = claims_with(lap, tmp_path)
    assert set(claims.causes) == {None}
    assert not misleading(claims).any()
