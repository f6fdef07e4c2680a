"""What faults add: a simulated robot is made worse, or mended, while it drives."""

from app.feature import Feature, Late

FEATURE = Feature(
    name="faults",
    about="changes what is wrong with a simulated robot while it drives, from the page",
    routers=(Late("app.features.faults.routes:faults_router"),),
    commands=(Late("app.features.faults.commands:COMMANDS"),),
    messages=(Late("app.features.faults.messages:MESSAGES"),),
)
