"""What the grid filter adds: one more choice of the parameter ``filter``, and its compiled code."""

from app.feature import Feature, Late

FEATURE = Feature(
    name="grid_filter",
    about="a filter that keeps the belief on a grid of poses, as the choice grid",
    filters=(Late("app.features.grid_filter.filters:FILTERS"),),
    compiled=(Late("app.features.grid_filter.compiled:COMPILED"),),
)
