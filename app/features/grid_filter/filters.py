"""The filter ``grid``; ``robot/localization/grid`` has it."""

from robot.localization.filter_kinds import FilterKind

FILTERS = (FilterKind("grid", "robot.localization.grid.grid_filter:GridFilter.of"),)
