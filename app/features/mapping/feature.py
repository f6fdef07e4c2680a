"""What drawing maps adds: a map of the floor's tape while the robot drives on it."""

from app.feature import Feature, Late

FEATURE = Feature(
    name="mapping",
    about="draws the floor's tape while the robot drives, and explores it",
    outlet=Late("app.features.mapping.outlet:MappingOutlet"),
    commands=(Late("app.features.mapping.commands:COMMANDS"),),
    messages=(Late("app.features.mapping.messages:MESSAGES"),),
)
