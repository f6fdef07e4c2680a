"""Settings of the line scanner."""

from __future__ import annotations

import math
from dataclasses import dataclass

from robot.scanning.tape import BRIGHTNESS
from robot.settings import SettingError, check_settings, setting

NARROWEST = 0.005
"""Narrowest tape [m]."""


@dataclass(frozen=True)
class LineScannerSettings:
    """How the picture is searched for tape."""

    rays: int = setting(91, "Number of rays; fewer than three make no line", low=3, high=720)
    field_of_view: float = setting(
        math.radians(62),
        "Angle between the outermost rays; with none, all see one point",
        unit="rad",
        low=0.01,
        high=2 * math.pi,
    )
    centre_x: float = setting(
        0.0, "Where the rays start, ahead of the robot's origin", unit="m", low=-1, high=1
    )
    range_max: float = setting(1.0, "How far rays are followed", unit="m", low=0.05, high=10)
    step: float = setting(
        1.5, "Distance of the samples along a ray in the picture", unit="px", low=0.25, high=4
    )
    kernel: int = setting(
        2,
        "Half width of the edge kernel; wider is calmer, narrower is finer; in noise it grows",
        unit="samples",
        low=1,
        high=20,
    )
    threshold: float = setting(
        25.0, "Weakest edge that counts, of 255 grey levels; more in noise", low=1, high=255
    )
    tape_brightness: str = setting(
        "field",
        "Whether tape is darker or lighter than the floor: as the field's strokes are drawn, "
        "always the one, or both are searched",
        choices=BRIGHTNESS,
    )
    tape_width: float = setting(
        0.0,
        "Width of the tape, 0.005 or more; with 0, the widths of the strokes in the field",
        unit="m",
        low=0,
        high=0.5,
    )
    width_tolerance: float = setting(
        0.012,
        "How far the measured width may be off; no measurement is exact",
        unit="m",
        low=0.0005,
        high=0.5,
    )
    support: float = setting(
        0.040,
        "Length of straight edge that must be seen around a hit; points farther apart than twice "
        "this are not of one edge, so that with too little none has neighbours",
        unit="m",
        low=0.005,
        high=1,
    )
    straightness: float = setting(
        0.0020,
        "How far an edge's points may lie off their line; no measurement is exact",
        unit="m",
        low=0.0002,
        high=0.1,
    )
    taper: float = setting(
        0.006,
        "How much the width may change over that length; no measurement is exact",
        unit="m",
        low=0.0001,
        high=0.5,
    )

    bend_radius: float = setting(
        0.070,
        "Tightest bend of an edge that is tape's; large, and only straight tape counts",
        unit="m",
        low=0.03,
        high=1000,
    )

    def __post_init__(self) -> None:
        check_settings(self)
        if 0 < self.tape_width < NARROWEST:
            raise SettingError(
                f"tape_width is {self.tape_width:g} m; valid is 0 or {NARROWEST:g} to 0.5 m"
            )
