"""Which sensor models are ours as they come: only another one is a reason for doubt."""

from __future__ import annotations

from typing import Any

import pytest

from app.engine.added_models import AddedModels
from app.engine.filter_models import FilterModels
from app.engine.parameter_changes import changed
from app.settings.config import MAPS
from robot.fields.field_loading import load_field
from robot.localization.models.sensor_models import SENSOR_MODELS
from robot.localization.parameters import LocalizationParameters


@pytest.fixture(scope="module")
def models() -> FilterModels:
    return FilterModels(load_field("stub", MAPS))


@pytest.mark.parametrize(
    ("values", "usual"),
    [
        *(({"laser_model_type": name}, True) for name in SENSOR_MODELS),
        ({"filter": "particles", "alpha1": 0.5}, True),
        ({"sigma_hit": 0.1}, False),
        ({"z_rand": 0.9}, False),
    ],
    ids=str,
)
def test_ours_is_usual_with_its_usual_parameters(
    models: FilterModels, values: dict[str, Any], usual: bool
) -> None:
    models.setup(changed(LocalizationParameters(), values), ())
    assert models.usual is usual


def test_one_of_a_feature_is_not(models: FilterModels) -> None:
    class Own(AddedModels):
        @property
        def in_use(self) -> tuple[Any, None]:
            return models.sensor, None

    models.setup(LocalizationParameters(), ())
    assert models.usual
    models.setup(LocalizationParameters(), [Own()])
    assert not models.usual
