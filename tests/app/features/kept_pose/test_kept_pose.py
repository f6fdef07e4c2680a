"""Where a run starts: the field's start, a given pose, or where the last run ended."""

import json
import re
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from camera_sources import until

from app.command_line import main
from app.engine.build import build_program
from app.engine.plugging import start_of
from app.features.kept_pose.keeping import PoseKeeper, saved_pose
from app.features.kept_pose.pose_file import PoseFileError, pose_path, read, write
from app.messages.commands import PauseCommand, ResetCommand, SetParticlesCommand
from app.messages.driving_commands import DriveCommand
from app.options import config_from
from app.settings.config import Config, load_config
from app.settings.groups import InitialPose, StartPoseSettings
from robot.fields.field import FieldError
from robot.geometry import Pose2
from robot.localization.estimate import Hypothesis
from robot.localization.filter import Cloud
from robot.settings import SettingError


def program(**settings):
    return build_program(Config(robot="kinematic", start_pose=StartPoseSettings(**settings)))


def step(run, ticks, *renewed):
    for _ in range(ticks):
        for command in renewed:
            run.engine.commands.put(command)
        shown = run.engine.step()
    return shown


def last_of(run):
    return run.engine.latest.get()


def file_of(run):
    return pose_path(run.config, run.field)


def keeper(run, **settings):
    """What keeps the pose of a program, with other settings."""
    begins = replace(run.config.start_pose, **settings)
    kept = replace(run, config=replace(run.config, start_pose=begins))
    return PoseKeeper(SimpleNamespace(program=kept))


@pytest.fixture(scope="module")
def driven(tmp_path_factory):
    """A run that ended elsewhere than it began, with its pose saved."""
    run = program(pose_file=str(tmp_path_factory.mktemp("pose") / "deep" / "pose.json"))
    step(run, 60, DriveCommand(type="drive", v=0.15, omega=0.5))
    step(run, 30)
    keeper(run).save()
    return run


def test_the_next_run_starts_where_the_last_one_ended(driven):
    last = last_of(driven)
    assert last.pose.distance_to(driven.field.start) > 0.1
    restored = program(pose_file=str(file_of(driven)), restore_pose=True)
    now = step(restored, 1)
    assert now.truth.distance_to(last.truth) < 1e-6
    assert now.odometry.distance_to(last.truth) < 1e-6
    # Places that are hardly likely come back too.
    middle = now.filter.cloud.weights @ now.filter.cloud.poses[:, :2]
    assert middle == pytest.approx([last.pose.x, last.pose.y], abs=0.003)
    assert now.problems.count == 0
    followed = step(restored, 40, DriveCommand(type="drive", v=0.1, omega=0.0))
    assert followed.pose.distance_to(followed.truth) < 0.01


def test_unless_asked_it_starts_at_the_fields_start(driven):
    run = program(pose_file=str(file_of(driven)))
    now = step(run, 1)
    assert now.truth == run.field.start
    assert now.filter.cloud.poses[:, 0].mean() == pytest.approx(run.field.start.x, abs=0.01)


@pytest.mark.parametrize(
    ("change", "why"),
    [
        (lambda text: b"", "is damaged"),
        (lambda text: text[: len(text) // 2], "is damaged"),
        (lambda text: b"\x00" * 100, "is damaged"),
        (lambda text: text.replace(b'"x"', b'"z"'), "is damaged"),
        (lambda text: text.replace(b'"weight": ', b'"weight": -'), "nothing has a weight"),
        (lambda text: re.sub(b'"x": -?', b'"x": 9', text), "off the map"),
        (lambda text: text.replace(b"square", b"town"), "is of another map, town"),
        (lambda text: text + b" " * 2_000_000, "too large"),
    ],
)
def test_a_damaged_file_is_told_and_not_used(driven, tmp_path, change, why):
    path = tmp_path / "pose.json"
    path.write_bytes(change(file_of(driven).read_bytes()))
    wanted = StartPoseSettings(restore_pose=True, pose_file=str(path))
    begin = start_of(replace(driven.config, start_pose=wanted), driven.field)
    assert begin.hypotheses == ()
    assert begin.truth is None
    assert re.search(f"^The saved pose is not used: {path}.*{why}", begin.complaint)


def test_a_complaint_is_in_the_record_and_stops_nothing(tmp_path, caplog):
    path = tmp_path / "pose.json"
    path.write_text("{")
    run = program(pose_file=str(path), restore_pose=True)
    now = step(run, 1)
    assert now.truth == run.field.start
    assert now.problems.count == 1
    assert "is damaged" in now.problems.record[0].message
    assert now.problems.present == ()
    assert "is damaged" in caplog.text


def test_no_file_yet_is_told_too(driven, tmp_path):
    with pytest.raises(PoseFileError, match=r"there is no .* yet"):
        read(tmp_path / "none.json", driven.field)


def test_what_is_written_is_read_again(driven, tmp_path):
    saved = saved_pose(last_of(driven), driven.field)
    write(tmp_path / "pose.json", saved)
    assert read(tmp_path / "pose.json", driven.field) == saved
    assert [path.name for path in tmp_path.iterdir()] == ["pose.json"]


def test_a_robot_pushed_off_the_map_loses_nothing_but_its_true_place(driven, tmp_path):
    last, path = last_of(driven), tmp_path / "pose.json"
    write(path, saved_pose(replace(last, truth=Pose2(5.0, 0.0, 0.0)), driven.field))
    wanted = StartPoseSettings(restore_pose=True, pose_file=str(path))
    begin = start_of(replace(driven.config, start_pose=wanted), driven.field)
    assert begin.complaint is None
    assert begin.truth is None
    assert len(begin.hypotheses) == len(saved_pose(last, driven.field).hypotheses) > 0


def test_a_write_that_fails_leaves_the_old_file_whole(driven, tmp_path, monkeypatch):
    saved = saved_pose(last_of(driven), driven.field)
    path = tmp_path / "pose.json"
    write(path, saved)
    monkeypatch.setattr("os.fsync", _disk_full)
    with pytest.raises(OSError, match="full"):
        write(path, saved.model_copy(update={"map": "other"}))
    assert read(path, driven.field) == saved
    assert len(list(tmp_path.iterdir())) == 1


def _disk_full(number):
    raise OSError(28, "the disk is full")


def test_a_keeper_that_cannot_write_says_so_once_and_tries_again(driven, monkeypatch, caplog):
    keep = keeper(driven)
    with monkeypatch.context() as broken:
        broken.setattr("os.fsync", _disk_full)
        keep.save()
        keep.save()
    assert "full" in keep.failure
    assert caplog.text.count("cannot be saved") == 1
    keep.save()
    assert keep.failure is None


def test_a_robot_that_stands_is_not_saved_again(driven, monkeypatch):
    keep = keeper(driven)
    keep.save()
    monkeypatch.setattr("os.fsync", _disk_full)
    keep.save()
    assert keep.failure is None


def test_it_is_saved_while_the_robot_drives_and_once_more_at_the_end(tmp_path):
    path = tmp_path / "pose.json"
    run = program(pose_file=str(path), save_pose_rate=10.0)
    keep = keeper(run)
    step(run, 2)
    keep.start()
    until(path.exists)
    step(run, 50, DriveCommand(type="drive", v=0.15, omega=0.5))
    keep.close()
    keep.close()
    assert read(path, run.field) == saved_pose(last_of(run), run.field)


@pytest.mark.parametrize("rate", [0.0, -1.0])
def test_a_rate_of_zero_or_as_in_nav2_of_minus_one_saves_never(driven, tmp_path, rate):
    assert StartPoseSettings(save_pose_rate=rate).save_pose_rate == rate
    keep = keeper(driven, pose_file=str(tmp_path / "pose.json"), save_pose_rate=rate)
    keep.start()
    keep.save()
    keep.close()
    assert list(tmp_path.iterdir()) == []


def test_all_places_that_look_alike_are_kept_and_come_back(driven, tmp_path):
    run = program(pose_file=str(tmp_path / "pose.json"))
    step(run, 5)
    run.engine.commands.put(PauseCommand(type="pause"))
    poses = [(0.3, 0.3, 0.0)] * 3 + [(-0.3, -0.3, 3.0)]
    run.engine.commands.put(SetParticlesCommand(type="set_particles", poses=poses))
    step(run, 5)
    keeper(run).save()
    again = program(pose_file=str(tmp_path / "pose.json"), restore_pose=True)
    cloud = step(again, 1).filter.cloud
    assert (cloud.poses[:, 0] > 0).mean() == pytest.approx(0.75, abs=0.01)


def test_poses_are_drawn_by_weight_and_covariance():
    one = Hypothesis(3.0, Pose2(1, 0, 3.1), np.diag([1e-4, 4e-4, 1e-2]))
    two = Hypothesis(1.0, Pose2(-1, 0, 0), np.zeros((3, 3)))
    cloud = Cloud.drawn((one, two), 4000, np.random.default_rng(0))
    first = cloud.poses[cloud.poses[:, 0] > 0]
    assert len(first) == 3000
    assert first[:, :2].std(axis=0) == pytest.approx([0.01, 0.02], rel=0.1)
    assert np.abs(cloud.poses[:, 2]).max() <= np.pi


# --- a given pose ----------------------------------------------------------------------------


def test_a_given_pose_is_where_the_filter_starts_and_reset_returns_to():
    given_pose = InitialPose(0.2, -0.1, 1.0, sd_xy=0.02, sd_theta=0.1)
    run = program(set_initial_pose=True, initial_pose=given_pose)
    for _ in range(2):
        run.engine.commands.put(PauseCommand(type="pause"))
        poses = step(run, 1).filter.cloud.poses
        assert poses.mean(axis=0) == pytest.approx([0.2, -0.1, 1.0], abs=0.01)
        assert poses.std(axis=0) == pytest.approx([0.02, 0.02, 0.1], rel=0.1)
        run.engine.commands.put(ResetCommand(type="reset"))
    assert run.engine.latest.get().truth == run.field.start


def test_a_given_pose_that_is_off_the_map_is_refused():
    with pytest.raises(FieldError, match="not on the field"):
        program(set_initial_pose=True, initial_pose=InitialPose(5.0))


def test_the_configuration_takes_a_covariance(tmp_path):
    path = tmp_path / "config.toml"
    path.write_text(
        "[start_pose]\nset_initial_pose = true\n[start_pose.initial_pose]\nx = 0.1\n"
        "covariance = [1, 0, 0, 0, 2, 0, 0, 0, 0.5]\n"
    )
    given_pose = load_config(path).start_pose.initial_pose
    assert np.diag(given_pose.matrix()).tolist() == [1, 2, 0.5]
    path.write_text("[start_pose.initial_pose]\ncovariance = [1, 2]\n")
    with pytest.raises(SettingError, match=r"start_pose\.initial_pose.*has 2 numbers"):
        load_config(path)
    path.write_text("[start_pose.initial_pose]\ncovariance = [1, 'a']\n")
    with pytest.raises(SettingError, match=r"covariance\[1\] is 'a'; valid is a number"):
        load_config(path)


# --- the file and the options ----------------------------------------------------------------


def test_the_file_is_in_the_users_state_folder_by_robot_and_map(driven, monkeypatch, tmp_path):
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path))
    config = Config(robot="sim")
    assert pose_path(config, driven.field) == tmp_path / "brickpose" / "pose-sim-square.json"
    monkeypatch.setenv("XDG_STATE_HOME", "not/absolute")
    monkeypatch.setenv("HOME", "/home/somebody")
    here = pose_path(config, driven.field)
    assert str(here) == "/home/somebody/.local/state/brickpose/pose-sim-square.json"


def test_options_reach_the_start_pose(monkeypatch, tmp_path):
    seen = []
    monkeypatch.setattr(
        "app.page.run_options._run", lambda parsed: seen.append(config_from(parsed)) or 0
    )
    main(["run", "--restore-pose", "--pose-file", "here.json"])
    main(["run"])
    wanted = StartPoseSettings(restore_pose=True, pose_file="here.json")
    assert [one.start_pose for one in seen] == [wanted, StartPoseSettings()]
    assert seen[1] == replace(seen[0], start_pose=StartPoseSettings())


def test_the_file_is_plain_json(driven):
    content = json.loads(file_of(driven).read_text())
    assert content["map"] == "square"
    assert len(content["hypotheses"][0]["covariance"]) == 9
