"""What calibration adds: a drive that measures the robot as it was built, and the lens page."""

from app.feature import Feature, Late

FEATURE = Feature(
    name="calibration",
    about="measures the robot that was built by a drive, and its lens by a board",
    settings=Late("app.features.calibration.settings:CalibrationSettings"),
    lens_files=(Late("app.features.calibration.lens_file:read_lens"),),
    outlet=Late("app.features.calibration.outlet:CalibrationOutlet"),
    companions=(Late("app.features.calibration.companions:trackings"),),
    commands=(Late("app.features.calibration.commands:COMMANDS"),),
    messages=(
        Late("app.features.calibration.messages:MESSAGES"),
        Late("app.features.calibration.lens.messages:MESSAGES"),
    ),
)
