"""What own models add: sensor and motion models in a user's files, watched while they run."""

from app.feature import Feature, Late, SettingOption

FEATURE = Feature(
    name="own_models",
    about="reads sensor and motion models from a user's own files while the robot drives",
    run_options=(
        SettingOption("sensor_model", metavar="FILE.py:CLASS", replays=True),
        SettingOption("motion_model", metavar="FILE.py:CLASS", replays=True),
        SettingOption("models", metavar="DIR", replays=True),
    ),
    models=(Late("app.features.own_models.own_models:own_models"),),
)
