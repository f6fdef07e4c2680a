"""Settings of what is done about a robot that changes."""

from __future__ import annotations

from dataclasses import dataclass

from robot.settings import check_settings, setting


@dataclass(frozen=True)
class CalibrationSettings:
    """What is done about a robot that changes."""

    track: bool = setting(
        False,
        "Measure the calibration again while driving: follow drifts, and a camera that was bumped",
    )

    def __post_init__(self) -> None:
        check_settings(self)
