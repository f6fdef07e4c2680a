"""A robot's profile holds wherever the robot is described: exports, recordings, replays."""

from datetime import UTC, datetime

import numpy as np
import pytest
import yaml
from engine_runs import kinematic
from recordings import record

from app.command_line import main
from app.page.telemetry import field_message
from app.recordings.replay.opening import ReplayOptions, open_replay
from robot.calibration.profile import Profile
from robot.calibration.unknowns import PRIORS, ROBOT
from robot.description.spec import SPIKE, RobotSpec

VALUES = np.array([0.01, -0.02, 0.03, 0.002, -0.003, 0.004, 0.02, 0.04, 0.01, -0.02, 0.03])
DRAWN = RobotSpec.load()
BUILT = Profile(DRAWN.name, datetime.now(UTC), "a test", VALUES, PRIORS[:ROBOT]).applied_to(DRAWN)


@pytest.fixture
def profile(tmp_path):
    path = tmp_path / "profile.toml"
    made = Profile(DRAWN.name, datetime.now(UTC), "a test", VALUES, PRIORS[:ROBOT])
    path.write_text(made.to_toml())
    return path


def assert_is_built(spec):
    assert [joint.radius for joint in spec.joints] == [joint.radius for joint in BUILT.joints]
    assert spec.track == pytest.approx(BUILT.track)
    np.testing.assert_allclose(spec.robot_from_camera, BUILT.robot_from_camera, atol=1e-12)
    np.testing.assert_allclose(spec.lens.matrix, BUILT.lens.matrix)


def test_the_exported_description_is_of_the_built_robot(profile, tmp_path):
    assert main(["export", "ros2", str(tmp_path / "ros"), "--profile", str(profile)]) == 0
    assert_is_built(RobotSpec.load(tmp_path / "ros" / "urdf" / "brickpose.urdf"))
    text = (tmp_path / "ros" / "config" / "controllers.yaml").read_text()
    wheels = yaml.safe_load(text)["diff_drive_controller"]["ros__parameters"]
    for place, side in zip(BUILT.axle, ("left", "right"), strict=True):
        radius = wheels["wheel_radius"] * wheels[f"{side}_wheel_radius_multiplier"]
        assert radius == pytest.approx(BUILT.joints[place].radius)


def test_the_camera_s_body_moves_with_its_frame():
    moved = RobotSpec.from_urdf(BUILT.urdf, SPIKE.parent)
    np.testing.assert_allclose(moved.robot_from_camera, BUILT.robot_from_camera, atol=1e-12)
    assert not np.array_equal(moved.outline, DRAWN.outline)


def test_the_page_says_when_the_robot_was_measured(profile):
    measured = field_message(kinematic(profile=str(profile))).robot_measured
    assert measured == f"{datetime.now(UTC):%Y-%m-%d}, a test"
    assert field_message(kinematic()).robot_measured == ""


def test_a_recording_keeps_the_profile_and_a_replay_may_have_another(profile, tmp_path):
    made, _, _ = record(kinematic(seed=1, profile=str(profile)), tmp_path / "kept", 1.0)
    profile.unlink()
    replayed = open_replay(made, ReplayOptions()).robot.spec
    assert_is_built(replayed)
    assert replayed.picture_delay == BUILT.picture_delay
    assert [joint.radius for joint in replayed.as_drawn.joints] == [
        joint.radius for joint in DRAWN.joints
    ]
    other = tmp_path / "other.toml"
    none = Profile.unmeasured(DRAWN.name, "nothing")
    other.write_text(none.to_toml())
    again = open_replay(made, ReplayOptions(profile=other)).robot.spec
    np.testing.assert_allclose(again.robot_from_camera, DRAWN.robot_from_camera, atol=1e-12)


def test_a_profile_of_another_robot_is_refused_by_name(profile, tmp_path, capsys):
    profile.write_text(profile.read_text().replace(DRAWN.name, "bulldozer"))
    assert main(["export", "ros2", str(tmp_path / "ros"), "--profile", str(profile)]) != 0
    assert "bulldozer" in capsys.readouterr().err
    assert not (tmp_path / "ros" / "urdf").exists()
