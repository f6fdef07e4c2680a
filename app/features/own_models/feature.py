"""What own models add: sensor and motion models in a user's files, watched while they run."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

from app.feature import Feature, Late, SettingOption

if TYPE_CHECKING:
    from app.engine.added_models import AddedModels
    from app.settings.config import Config
    from robot.fields.field import Field

_OWN_MODELS = Late("app.features.own_models.own_models:own_models")


def _named(config: Config, field: Field) -> Iterable[AddedModels]:
    """Return the models that the settings name; nothing of them is loaded if they name none."""
    named = config.sensor_model or config.motion_model or config.models
    own: Iterable[AddedModels] = _OWN_MODELS(config, field) if named else ()
    return own


FEATURE = Feature(
    name="own_models",
    about="reads sensor and motion models from a user's own files while the robot drives",
    run_options=(
        SettingOption("sensor_model", metavar="FILE.py:CLASS", replays=True),
        SettingOption("motion_model", metavar="FILE.py:CLASS", replays=True),
        SettingOption("models", metavar="DIR", replays=True),
    ),
    models=(_named,),
)
