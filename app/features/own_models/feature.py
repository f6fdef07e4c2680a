"""What own models add: sensor and motion models in a user's files, watched while they run."""

from app.feature import Feature, Late, RunOptions

FEATURE = Feature(
    name="own_models",
    about="reads sensor and motion models from a user's own files while the robot drives",
    run_options=(
        RunOptions(
            Late("app.features.own_models.options:add"),
            Late("app.features.own_models.options:apply"),
            replays=True,
        ),
    ),
    models=(Late("app.features.own_models.own_models:own_models"),),
)
