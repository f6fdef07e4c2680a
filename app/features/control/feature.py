"""What control adds: the robot is driven by a process of its own, which nothing here slows."""

from app.feature import Feature, Late, SettingOption

FEATURE = Feature(
    name="control",
    about="drives the robot in a process of its own, which pages and files do not slow",
    settings=Late("app.features.control.settings:ControlSettings"),
    run_options=(SettingOption("control.one_process"),),
    builders=(Late("app.features.control.starting:build_elsewhere"),),
)
