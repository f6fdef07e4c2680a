"""What the Kalman filter adds: one more choice of the parameter ``filter``."""

from app.feature import Feature, Late

FEATURE = Feature(
    name="kalman_filter",
    about="a filter that keeps the belief as one Gaussian, as the choice kalman",
    filters=(Late("app.features.kalman_filter.filters:FILTERS"),),
)
