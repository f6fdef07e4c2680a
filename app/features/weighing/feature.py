"""What weighing adds: what a scan says of a pose and along a ray, and the filter by hand."""

from app.feature import Feature, Late

FEATURE = Feature(
    name="weighing",
    about="shows what a scan says of each particle, and has the filter stepped by hand",
    routers=(
        Late("app.features.weighing.routes:weighing_router"),
        Late("app.features.weighing.filter_by_hand:hand_router"),
        Late("app.features.weighing.ray_profile:ray_router"),
    ),
    commands=(Late("app.features.weighing.hand_commands:COMMANDS"),),
    messages=(Late("app.features.weighing.messages:MESSAGES"),),
)
