"""What the Build HAT adds: the real robot, checks of its board, and a board that is emulated."""

from app.feature import Feature, Late, Subcommand

FEATURE = Feature(
    name="build_hat",
    about="the real robot: LEGO motors on a Raspberry Pi's Build HAT, and a camera",
    subcommands=(
        Subcommand(
            "emulate-hat",
            "a Build HAT without the board, on a serial port of its own",
            Late("app.features.build_hat.options:add_emulate_hat"),
        ),
        Subcommand(
            "stop-motors",
            "stop the motors of a Build HAT that no program drives any more",
            Late("app.features.build_hat.options:add_stop_motors"),
        ),
    ),
    robots=(Late("app.features.build_hat.robot:ROBOTS"),),
    checks=(Late("app.features.build_hat.doctor_check:check_robot"),),
)
