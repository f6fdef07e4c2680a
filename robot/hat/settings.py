"""Settings of the Build HAT and its motors."""

from __future__ import annotations

from dataclasses import dataclass

from robot.settings import check_settings, setting


@dataclass(frozen=True)
class BuildHatSettings:
    """The Build HAT and its motors."""

    serial_port: str = setting(
        "auto", "The Build HAT's serial port, as /dev/serial0; auto is the one of this Pi"
    )
    power_limit: float = setting(
        1.0, "Highest duty a motor may get; the firmware's own default is 0.1", low=0.05, high=1
    )
    position_gain: float = setting(
        7.0,
        "Speed asked for by angle that a wheel is behind; more is stiffer, and overshoots "
        "with a delay of 40 ms from about 12 on",
        unit="1/s",
        low=0,
        high=20,
    )
    encoder_delay: float = setting(
        0.0,
        "Age of a position when the Build HAT sends it",
        unit="s",
        low=0,
        high=0.1,
    )
    low_supply: float = setting(
        6.0, "Below this voltage the motors are stopped", unit="V", low=0, high=9
    )

    def __post_init__(self) -> None:
        check_settings(self)
