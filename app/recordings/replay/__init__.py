"""A recording in place of a robot: the filter runs again on what was recorded."""
