"""What the laboratory adds: commands that measure, fit, sweep and map; generated fields."""

from app.feature import Feature, Late, Subcommand

FEATURE = Feature(
    name="lab",
    about="evaluations, fits, sweeps, calibrations, maps and laser bags; generated fields",
    subcommands=(
        Subcommand(
            "evaluate",
            "the paper's experiment, statistics of the models, integrity, or navigation",
            Late("app.features.lab.evaluate_options:add_evaluate"),
        ),
        Subcommand(
            "sweep",
            "the experiment at many settings, on this machine or a cluster",
            Late("app.features.lab.sweep.options:add_sweep"),
        ),
        Subcommand(
            "localize",
            "any laser robot's bag (ROS 1, ROS 2, MCAP) on a ROS map, or pictures on a field",
            Late("app.features.lab.localize.options:add_localize"),
        ),
        Subcommand(
            "calibrate",
            "measure the robot that was built",
            Late("app.features.lab.calibrate.options:add_calibrate"),
        ),
        Subcommand(
            "map",
            "draw the tape of a floor from a recorded drive, or walls from a laser's bag",
            Late("app.features.lab.mapping.options:add_map_command"),
        ),
    ),
    fields=(Late("app.features.lab.generated_fields:FIELDS"),),
)
