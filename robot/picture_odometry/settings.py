"""Settings of the odometer that needs no wheels."""

from __future__ import annotations

from dataclasses import dataclass

from robot.settings import check_settings, setting

NAME = "picture_odometry"
"""The name of the settings' table, and by which a tick has what was measured."""


@dataclass(frozen=True)
class PictureOdometrySettings:
    """Where the floor is looked at, and when it is said to be seen."""

    enabled: bool = setting(False, "Whether motion is measured in the picture, beside the wheels")
    fuse: bool = setting(
        False, "Whether dead reckoning is corrected by it; if so, it is measured as well"
    )
    nearest: float = setting(
        0.165, "Where the floor that is compared begins, before the axle", unit="m", low=0, high=5
    )
    farthest: float = setting(0.325, "Where it ends, before the axle", unit="m", low=0.05, high=5)
    width: float = setting(0.20, "How wide it is", unit="m", low=0.02, high=5)
    resolution: float = setting(
        0.00125, "Side of a pixel of the projected floor", unit="m", low=0.0003, high=0.02
    )
    largest_sd: float = setting(
        0.001,
        "A direction counts as seen if a motion along it is known better than this",
        unit="m",
        low=0.0001,
        high=0.1,
    )
    scale_error: float = setting(
        0.001, "Standard deviation of the picture's scale: motions are off by this share",
        low=0, high=0.2,
    )  # fmt: skip

    def __post_init__(self) -> None:
        check_settings(self)
