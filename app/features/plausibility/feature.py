"""What plausibility adds: wrong plugs, mirrored and frozen pictures are named before all else."""

from app.feature import Feature, Late

FEATURE = Feature(
    name="plausibility",
    about="names motors that are plugged in wrongly, and pictures that are mirrored or frozen",
    compiled=(Late("app.features.plausibility.compiled:COMPILED"),),
    models=(Late("app.features.plausibility.checks:plausibility_checks"),),
    companions=(Late("app.features.plausibility.companion:plausibility_companion"),),
)
