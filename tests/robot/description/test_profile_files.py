"""Where profiles are: a real robot's own one, the one before, and what the doctor says of them."""

from dataclasses import replace
from datetime import UTC, datetime, timedelta

import numpy as np
import pytest

from app.command_line import main
from app.engine.robots import profile_file, robot_spec
from app.features.build_hat.robot_check import check_profile
from app.settings.config import Config
from app.settings.profile_files import before, undo, write_calibration, write_profile
from app.settings.profiles import own_profile
from app.tools.doctor.finding import OK, PROBLEM, WARNING
from robot.description.lens_table import MeasuredLens
from robot.description.profile import Profile, load_profile
from robot.description.spec import RobotSpec
from robot.description.urdf import SpecError
from robot.settings import SettingError

SPEC = RobotSpec.load()
UNMEASURED = replace(Profile.unmeasured(SPEC.name, "a test"), made=datetime.now(UTC))
HAT = Config(robot="buildhat")


def profile(height: float) -> Profile:
    values = np.zeros(11)
    values[5] = height
    return replace(UNMEASURED, values=values)


@pytest.fixture
def own(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path))
    path = own_profile(SPEC.name)
    assert path.is_relative_to(tmp_path)
    return path


def test_a_real_robot_has_its_own_profile_and_a_simulated_one_none(own):
    assert profile_file(HAT) is None
    write_profile(own, profile(0.004))
    assert profile_file(HAT) == own
    higher = robot_spec(HAT).robot_from_camera[2, 3] - SPEC.robot_from_camera[2, 3]
    assert higher == pytest.approx(0.004)
    assert profile_file(replace(HAT, profile="none")) is None
    assert robot_spec(replace(HAT, profile="none")).robot_from_camera[2, 3] == pytest.approx(0.16)
    assert profile_file(Config(robot="sim")) is None


def test_undo_goes_back_and_undoing_twice_changes_nothing(own):
    write_profile(own, profile(0.001))
    write_profile(own, profile(0.002))
    assert load_profile(own).values[5] == 0.002
    assert undo(own) == own
    assert load_profile(own).values[5] == 0.001
    assert undo(own) == own
    assert load_profile(own).values[5] == 0.002


def test_undo_of_the_first_profile_is_the_robot_as_described(own, capsys):
    write_profile(own, profile(0.001))
    assert main(["calibrate", "undo"]) == 0
    assert "as described again" in capsys.readouterr().out
    assert not own.exists()
    assert main(["calibrate", "undo"]) == 0
    assert "a test" in capsys.readouterr().out
    assert load_profile(own).values[5] == 0.001


def test_undo_without_a_profile_says_what_makes_one(own):
    with pytest.raises(SettingError, match="calibrate drive makes one"):
        undo(own)
    assert not before(own).exists()


def test_a_lens_that_was_measured_while_the_robot_ran_is_not_overwritten(own):
    write_calibration(own, profile(0.001))
    write_calibration(own, profile(0.002))
    assert load_profile(own).values[5] == 0.002
    measured = replace(profile(0.003), lens=MeasuredLens.of(SPEC.lens))
    write_profile(own, measured)
    with pytest.raises(SpecError, match="has another lens by now"):
        write_calibration(own, profile(0.004))
    assert own.read_text() == measured.to_toml()
    write_calibration(own, replace(measured, source="a drive"))
    assert load_profile(own).source == "a drive"


def test_the_doctor_tells_what_is_wrong_with_a_profile(own):
    assert check_profile(None, SPEC).level == WARNING
    write_profile(own, UNMEASURED)
    assert check_profile(own, SPEC).level == OK
    later = datetime.now(UTC) + timedelta(days=200)
    assert "199 days old" in str(check_profile(own, SPEC, later)) or "200 days old" in str(
        check_profile(own, SPEC, later)
    )
    earlier = datetime.now(UTC) - timedelta(days=3)
    assert "future" in str(check_profile(own, SPEC, earlier))
    own.write_text(own.read_text().replace(SPEC.name, "bulldozer"))
    assert check_profile(own, SPEC).level == PROBLEM
    own.write_text("nonsense")
    assert check_profile(own, SPEC).level == PROBLEM


def test_what_could_not_be_read_back_is_not_written(own):
    write_profile(own, profile(0.004))
    with pytest.raises(SpecError, match=r"camera_z\.value is 0\.2; valid is -0\.075 to 0\.075"):
        write_profile(own, profile(0.2))
    assert load_profile(own).values[5] == pytest.approx(0.004)
    assert not before(own).exists()
