"""What the package adds to BrickPose; nothing else is imported until it is used."""

from pathlib import Path

from app.feature import Feature, Late, Panel, Subcommand

HERE = Path(__file__).parent
FEATURE = Feature(
    name="tape_seen",
    about="how much tape the camera sees",
    settings=Late("tape_seen.settings:TapeSettings"),
    subcommands=(
        Subcommand(
            "tape-seen",
            "say how much tape a running program's camera sees",
            Late("tape_seen.command:add_options"),
        ),
    ),
    commands=(Late("tape_seen.commands:rows"),),
    values=(Late("tape_seen.commands:values"),),
    routers=(Late("tape_seen.routes:tape_router"),),
    messages=(Late("tape_seen.routes:MESSAGES"),),
    robots=(Late("tape_seen.robot:robots"), Late("tape_seen.rover:robots")),
    models=(Late("tape_seen.models:models"),),
    topics=(Late("tape_seen.topic:topics"),),
    panels=(Panel("tape-rays", "Tape", HERE / "page" / "tape_panel.js"),),
    documents=(HERE / "tape_seen.md",),
    checks=(Late("tape_seen.doctor_check:check_tape"),),
)
