"""What faults add: a simulated robot is worse from the start, or made worse while it drives."""

from app.feature import Feature, Late, RunOptions

FEATURE = Feature(
    name="faults",
    about="a simulated robot is made worse: from the start, and by the page while it drives",
    run_options=(
        RunOptions(
            Late("app.features.faults.run_options:add"),
            Late("app.features.faults.run_options:apply"),
        ),
    ),
    routers=(Late("app.features.faults.routes:faults_router"),),
    commands=(Late("app.features.faults.commands:COMMANDS"),),
    messages=(Late("app.features.faults.messages:MESSAGES"),),
)
