"""What navigation adds: goals on the map, to which the robot drives by itself."""

from app.feature import Feature, Late

FEATURE = Feature(
    name="navigation",
    about="drives to goals on the map, around what must not be touched",
    settings=Late("robot.navigation.settings:NavigationSettings"),
    companions=(Late("app.features.navigation.companion:companions"),),
    commands=(Late("app.features.navigation.commands:COMMANDS"),),
    messages=(Late("app.features.navigation.messages:MESSAGES"),),
    compiled=(Late("app.features.navigation.compiled:COMPILED"),),
    outlet=Late("app.features.navigation.outlet:NavigationOutlet"),
)
