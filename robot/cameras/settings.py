"""Settings of the real robot's camera."""

from __future__ import annotations

from dataclasses import dataclass

from robot.settings import SettingError, check_settings, setting


@dataclass(frozen=True)
class CameraSourceSettings:
    """The real robot's camera, and how it takes pictures; their size is the lens's."""

    source: str = setting(
        "auto",
        "The real robot's camera: pi, /dev/video0, a folder of pictures, a video file; auto is the "
        "first that delivers pictures",
    )
    frame_rate: float = setting(30.0, "Pictures a second", unit="1/s", low=1, high=120)
    rotation: int = setting(
        0, "How far pictures are turned, for a camera mounted upside down: 0 or 180", unit="deg",
        low=0, high=180,
    )  # fmt: skip
    focus_distance: float = setting(
        0.3, "What a Pi camera with a movable lens is focused on", unit="m", low=0.05, high=10
    )
    exposure: float = setting(
        0.010, "Exposure time of a camera that does not tell its own", unit="s", low=0, high=0.1
    )
    exposure_delay: float = setting(
        0.040,
        "How long before its arrival a picture was taken, for cameras without time stamps",
        unit="s",
        low=0,
        high=1,
    )

    def __post_init__(self) -> None:
        check_settings(self)
        if self.rotation not in (0, 180):
            raise SettingError(f"rotation is {self.rotation} deg; valid are 0 and 180 deg")
