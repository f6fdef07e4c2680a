"""What recordings add: a drive is recorded, kept, and replayed in place of the robot."""

from app.feature import Feature, Late, RunOptions, Subcommand

FEATURE = Feature(
    name="recordings",
    about="records drives, and replays them in place of the robot",
    subcommands=(
        Subcommand(
            "record",
            "record a program that runs, here or on another machine",
            Late("app.features.recordings.options:add_record"),
        ),
        Subcommand(
            "replay",
            "serve the dashboard on a recording",
            Late("app.features.recordings.options:add_replay"),
        ),
    ),
    run_options=(
        RunOptions(
            Late("app.features.recordings.run_options:add"),
            Late("app.features.recordings.run_options:apply"),
        ),
    ),
    outlet=Late("app.features.recordings.outlet:RecordingsOutlet"),
    commands=(Late("app.features.recordings.commands:COMMANDS"),),
    messages=(Late("app.features.recordings.messages:MESSAGES"),),
)
