"""What the feature bullet adds: one more choice of ``[sim] engine``."""

from app.feature import Feature, Late

FEATURE = Feature(
    name="bullet",
    about="pybullet, which moves the simulated robot where it is installed",
    engines=(Late("app.features.bullet.engines:ENGINES"),),
)
