"""The filter ``kalman``; ``robot/localization/kalman_filter.py`` has it."""

from robot.localization.filter_kinds import FilterKind

FILTERS = (
    FilterKind(
        "kalman", "robot.localization.kalman_filter:KalmanFilter.of", has_sensor_model=False
    ),
)
