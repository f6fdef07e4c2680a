"""A setting knows what it means, and refuses what cannot be."""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass

import pytest
from hypothesis import given
from hypothesis import strategies as st

from robot.driving.drive_controller import DriveSettings
from robot.driving.odometry import OdometrySettings
from robot.localization.models.motion_models import MotionParameters
from robot.localization.models.sensor_models import SensorParameters
from robot.localization.parameters import FilterParameters
from robot.scanning.line_scanner import LineScannerSettings
from robot.settings import SettingError, check_names, check_settings, describe, setting
from sim.floor_camera import CameraSettings

GROUPS = [
    CameraSettings,
    DriveSettings,
    FilterParameters,
    LineScannerSettings,
    MotionParameters,
    OdometrySettings,
    SensorParameters,
]


@dataclass(frozen=True)
class Oven:
    heat: float = setting(180.0, "Temperature inside", unit="C", low=50, high=250)
    shelves: int = setting(2, "Places for a tray", low=1)
    below: float = setting(0.0, "Depth", unit="m", high=0.0)
    mode: str = setting("fan", "How heat moves", choices=("fan", "grill"))
    light: bool = setting(True, "Whether the lamp is on")
    owner: str = "nobody"

    def __post_init__(self) -> None:
        check_settings(self)


def test_the_defaults_are_made_and_described() -> None:
    known = describe(Oven())
    assert list(known) == ["heat", "shelves", "below", "mode", "light"]
    assert known == describe(Oven)
    assert (known["heat"].meaning, known["heat"].unit) == ("Temperature inside", "C")
    assert (known["heat"].low, known["heat"].high) == (50, 250)
    assert known["shelves"].high == math.inf
    assert known["mode"].choices == ("fan", "grill")
    assert Oven().heat == 180.0


@given(st.floats(allow_nan=True, allow_infinity=True))
def test_a_value_is_taken_exactly_if_it_is_within_its_range(heat: float) -> None:
    if 50 <= heat <= 250:
        assert Oven(heat=heat).heat == heat
    else:
        with pytest.raises(SettingError, match=r"heat is .*valid is 50 to 250 C"):
            Oven(heat=heat)


def test_both_ends_of_a_range_are_allowed() -> None:
    assert Oven(heat=50).heat == 50
    assert Oven(heat=250, shelves=1).shelves == 1


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"heat": math.nan}, "heat is nan C; valid is 50 to 250 C"),
        ({"shelves": 0}, "shelves is 0; valid is 1 or more"),
        ({"below": 0.5}, "below is 0.5 m; valid is 0 or less m"),
        ({"mode": "steam"}, "mode is 'steam'; valid are fan, grill"),
    ],
)
def test_a_refusal_names_the_setting_and_what_is_valid(
    values: dict[str, float], message: str
) -> None:
    with pytest.raises(SettingError) as refused:
        Oven(**values)
    assert str(refused.value) == message
    assert isinstance(refused.value, ValueError)


def test_a_misspelt_name_is_refused_with_its_path() -> None:
    check_names(Oven, ["heat", "owner"])
    with pytest.raises(SettingError, match=r"kitchen\.hat is unknown; valid are .*heat, .*mode"):
        check_names(Oven, ["heat", "hat"], "kitchen.")


@pytest.mark.parametrize("group", GROUPS)
def test_every_group_of_the_program_has_valid_defaults_with_meanings(group: type) -> None:
    known = describe(group())
    assert set(known) == {field.name for field in dataclasses.fields(group)}
    for name, one in known.items():
        assert one.meaning and not one.meaning.endswith("."), name
        assert one.low <= one.high, name


@pytest.mark.parametrize("group", GROUPS)
def test_every_number_of_the_program_is_refused_beyond_its_range_and_as_nan(group: type) -> None:
    for name, known in describe(group()).items():
        value = getattr(group(), name)
        if isinstance(value, bool):
            continue
        odd = (
            ["no such choice"]
            if isinstance(value, str)
            else [math.nan, *(b for b in (known.low - 1, known.high + 1) if math.isfinite(b))]
        )
        for wrong in odd:
            with pytest.raises(SettingError, match=f"^{name} is "):
                group(**{name: wrong})


@pytest.mark.parametrize("group", GROUPS)
def test_every_number_of_the_program_may_be_at_the_ends_of_its_range(group: type) -> None:
    for name, known in describe(group()).items():
        value = getattr(group(), name)
        for end in (known.low, known.high):
            if isinstance(value, (int, float)) and math.isfinite(end):
                made = group(**{name: type(value)(end)})
                assert getattr(made, name) == end


def test_more_particles_at_least_than_at_most_are_never_fewer() -> None:
    assert FilterParameters(min_particles=3000, max_particles=200).most_particles == 3000
    assert FilterParameters(min_particles=200, max_particles=3000).most_particles == 3000
