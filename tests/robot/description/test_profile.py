"""A robot's profile is written, read again and applied; nothing wrong in it goes unnoticed."""

from __future__ import annotations

from datetime import UTC, datetime
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from app.engine.robots import robot_spec
from app.settings.config import Config
from robot.description.profile import Profile, load_profile, profile_of
from robot.description.spec import RobotSpec, SpecError
from robot.description.unknowns import NAMES, PRIORS, ROBOT

MADE = datetime(2026, 11, 23, 7, 30, tzinfo=UTC)
SHARES = arrays(np.float64, ROBOT, elements=st.floats(-3, 3))


def profile(values: np.ndarray | None = None) -> Profile:
    given_values = np.zeros(ROBOT) if values is None else values
    return Profile("spike", MADE, "60 s on square", given_values, 0.1 * PRIORS[:ROBOT])


@pytest.fixture
def text() -> str:
    return profile(0.5 * PRIORS[:ROBOT]).to_toml()


def written(folder: Path, text: str) -> Path:
    path = folder / "profile.toml"
    path.write_text(text, encoding="utf-8")
    return path


@given(SHARES, st.text())
def test_what_is_written_is_read_again(tmp_path_factory, shares, source) -> None:
    made = Profile("spike", MADE, source, shares * PRIORS[:ROBOT], PRIORS[:ROBOT])
    folder = tmp_path_factory.getbasetemp()
    again = load_profile(written(folder, made.to_toml()))
    assert (again.robot, again.made, again.source) == (made.robot, made.made, made.source)
    assert again.values.tolist() == made.values.tolist()
    assert again.sd.tolist() == made.sd.tolist()


def test_it_corrects_the_description(tmp_path: Path, text: str) -> None:
    config = Config(profile=str(written(tmp_path, text)))
    corrected, drawn = robot_spec(config), RobotSpec.load()
    assert corrected.picture_delay == pytest.approx(0.03)
    assert corrected.track == pytest.approx(drawn.track * 1.0375)
    assert corrected.robot_from_camera[:3, 3] - drawn.robot_from_camera[:3, 3] == pytest.approx(
        [0.00375] * 3
    )
    assert corrected.lens.matrix[0, 0] == pytest.approx(drawn.lens.matrix[0, 0] * 1.015)
    assert robot_spec(Config()).picture_delay == 0


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ('robot = "spike"', "", "robot is missing"),
        ("made = ", "# ", "made is missing"),
        ("[camera_x]", "[camera_w]", "there is no camera_w; valid are camera_roll, "),
        ("value = 0.00375", "value = nan", r"camera_x.value is nan; valid is -0\.075 to 0\.075"),
        ("value = 0.00375", "value = 1.0", r"camera_x.value is 1; valid is -0\.075 to 0\.075"),
        ("value = 0.00375", f"value = 1{400 * '0'}", "value is a very large number; valid is -0"),
        ("value = 0.00375", "value = true", "camera_x.value is True; valid is a number"),
        ("sd = 0.00075", "sd = -1", "camera_x.sd is -1; valid is 0 to"),
        ("sd = 0.00075", "", "camera_x.sd is None; valid is a number"),
        ("[camera_x]", "[camera_x", "is no TOML"),
    ],
)
def test_a_fault_is_named(tmp_path: Path, text: str, old: str, new: str, words: str) -> None:
    assert old in text
    path = written(tmp_path, text.replace(old, new, 1))
    with pytest.raises(SpecError, match=words) as fault:
        load_profile(path)
    assert str(path) in str(fault.value)


def test_a_table_that_is_missing_is_named() -> None:
    with pytest.raises(SpecError, match=r"\[camera_roll\] is missing"):
        profile_of({"robot": "spike", "made": MADE})
    assert len(NAMES[:ROBOT]) == 11


def test_the_profile_of_another_robot_is_refused(tmp_path: Path, text: str) -> None:
    path = written(tmp_path, text.replace("spike", "crab"))
    with pytest.raises(SpecError, match="the profile is of the robot 'crab', not of 'spike'"):
        robot_spec(Config(profile=str(path)))


def test_a_file_that_cannot_be_read_is_named(tmp_path: Path) -> None:
    with pytest.raises(SpecError, match=r"nowhere\.toml cannot be read: No such file"):
        load_profile(tmp_path / "nowhere.toml")
    large = written(tmp_path, "#" * 1_000_001)
    with pytest.raises(SpecError, match="is too long; valid are up to 1000000 characters"):
        load_profile(large)
