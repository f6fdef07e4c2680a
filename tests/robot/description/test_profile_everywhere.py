"""A robot's profile holds wherever the robot is described: exports, recordings, replays."""

from datetime import UTC, datetime

import numpy as np
import pytest
import yaml
from engine_runs import kinematic, run
from recordings import record
from ros_messages import topic

from app.command_line import main
from app.engine.profile_command import calibration_command
from app.features.recordings.attachments import PROFILE
from app.features.recordings.contents import contents_of
from app.features.recordings.replay.opening import ReplayOptions, open_replay
from app.features.ros.source import TopicSource
from app.features.ros.topics import UNCHANGING
from app.page.outlets import Outlets
from app.page.telemetry import TelemetryWriter, field_message
from app.page.view.view import View
from robot.description.profile import Profile, profile_of
from robot.description.spec import SPIKE, RobotSpec
from robot.description.unknowns import PRIORS, ROBOT
from robot.toml_file import parse_toml

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


@pytest.fixture(scope="module")
def calibrated():
    """A running robot, the tick before its calibration, and the first ones after it."""
    program = kinematic()
    before = run(program, 0.2)[-1]
    made = Profile(DRAWN.name, datetime.now(UTC), "a test", VALUES, PRIORS[:ROBOT] / 10)
    program.engine.commands.put(calibration_command(made))
    return program, before, run(program, 0.2)


def test_the_page_s_field_follows_a_calibration(calibrated):
    program, before, (first, *_, last) = calibrated
    assert_is_built(last.spec)
    message = field_message(program)
    assert message.robot_measured == f"{datetime.now(UTC):%Y-%m-%d}, a test"
    lines = before.filter.scanner.table.lines(9).round(1)
    assert not np.array_equal(np.array(message.rays_px), lines)
    writer = TelemetryWriter(program, Outlets(program))
    told = [writer.message(shown).robot.calibrated for shown in (before, first, last)]
    assert told == [None, first.stamp, first.stamp]


def test_no_scan_is_shown_through_another_camera_than_its_own(calibrated):
    _, before, ticks = calibrated
    assert ticks[0].filter.scanner is not before.filter.scanner
    assert ticks[0].filter.line_scan is not before.filter.line_scan
    assert ticks[-1].filter.line_scan is not None
    # The calibration moved the pictures' stamps, too: the page draws the scan of its picture.
    assert ticks[-1].frame.stamp == ticks[-1].filter.line_scan.scan.stamp


def test_topics_follow_a_calibration(calibrated):
    program, before, ticks = calibrated
    source, last = TopicSource.of(program), ticks[-1]
    seen = next(shown for shown in ticks if shown.reading.frame is not None)
    told = topic("camera/camera_info").make(source, seen)
    np.testing.assert_allclose(told.k.reshape(3, 3), BUILT.lens.matrix)
    for name in ("tf_static", "robot_description"):
        assert topic(name).stamp(before) == UNCHANGING
        assert topic(name).stamp(last) == ticks[0].stamp
    assert topic("robot_description").make(source, last).data == last.spec.urdf
    fixed = {link.child: link for link in source.robot(last).links.fixed}
    as_drawn = {link.child: link for link in source.robot(before).links.fixed}
    assert fixed.keys() == as_drawn.keys()
    assert fixed != as_drawn
    assert source.robot(last).drive.track == pytest.approx(BUILT.track)


def test_the_3d_view_shows_the_calibrated_robot(calibrated):
    program, before, ticks = calibrated
    view = View(program.field, program.robot.spec, program.engine.latest)
    try:
        scene = view._scene
        scene.update(before)
        drawn = scene._parts[0].vertices.copy()
        scene.update(ticks[-1])
        assert not np.array_equal(scene._parts[0].vertices, drawn)
    finally:
        view.close()


def test_a_recording_begun_after_a_calibration_has_its_profile(calibrated):
    program, _, _ = calibrated
    (kept,) = [item for item in contents_of(program).attachments if item.name == PROFILE]
    profile = profile_of(parse_toml(kept.data.decode(), "kept"))
    np.testing.assert_allclose(profile.values, VALUES)
    np.testing.assert_allclose(profile.sd, PRIORS[:ROBOT] / 10)


def test_a_profile_of_another_robot_is_refused_by_name(profile, tmp_path, capsys):
    profile.write_text(profile.read_text().replace(DRAWN.name, "bulldozer"))
    assert main(["export", "ros2", str(tmp_path / "ros"), "--profile", str(profile)]) != 0
    assert "bulldozer" in capsys.readouterr().err
    assert not (tmp_path / "ros" / "urdf").exists()
