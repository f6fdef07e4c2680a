"""What control adds: the robot is driven by a process of its own, which nothing here slows."""

from app.feature import Feature, Late, SettingOption

SETTINGS = Late("app.features.control.settings:ControlSettings")
FEATURE = Feature(
    name="control",
    about="drives the robot in a process of its own, which pages and files do not slow",
    settings=SETTINGS,
    run_options=(SettingOption("control.one_process", SETTINGS),),
    builders=(Late("app.features.control.starting:build_elsewhere"),),
)
