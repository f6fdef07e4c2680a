"""What control adds: the robot is driven by a process of its own, which nothing here slows."""

from app.feature import Feature, Late, RunOptions

FEATURE = Feature(
    name="control",
    about="drives the robot in a process of its own, which pages and files do not slow",
    settings=Late("app.features.control.settings:ControlSettings"),
    run_options=(
        RunOptions(
            Late("app.features.control.settings:add"), Late("app.features.control.settings:apply")
        ),
    ),
    builders=(Late("app.features.control.starting:build_elsewhere"),),
)
