"""Settings of navigation: refused where they contradict each other, and documented."""

import pytest

from app.settings.config import ROOT
from robot.navigation.settings import NavigationSettings
from robot.settings import SettingError, describe


def test_every_setting_is_documented_with_its_default():
    text = (ROOT / "docs" / "navigation.md").read_text(encoding="utf-8")
    for name, known in describe(NavigationSettings()).items():
        value = getattr(NavigationSettings(), name)
        shown = f"{value:g} {known.unit}".strip() if isinstance(value, float) else value
        assert f"| `{name}` | {shown} | {known.meaning} |" in text, name


def test_a_robot_slows_down_before_it_stands():
    with pytest.raises(SettingError, match="valid is more than slow_radius"):
        NavigationSettings(slow_radius=0.2, stop_radius=0.1)


def test_tape_is_a_wall_or_ignored():
    with pytest.raises(SettingError, match="valid are wall, ignored"):
        NavigationSettings(tape="lava")
