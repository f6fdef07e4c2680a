"""What own shadow adds: what travels with the robot is left out of its scans, and told."""

from app.feature import Feature, Late

FEATURE = Feature(
    name="own_shadow",
    about="leaves out of scans what travels with the robot, as the shadow of its mast or a cable",
    compiled=(Late("app.features.own_shadow.compiled:COMPILED"),),
    models=(Late("app.features.own_shadow.scans:cleared_scans"),),
)
