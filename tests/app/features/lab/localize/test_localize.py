"""``brickpose localize``: any robot's bag through the filter."""

import json
import math

import cv2
import numpy as np
import pytest
from laser_office import BEGAN, LASER, drive, office_map, true_pose, write_bag, write_map
from localize_runs import run

from app.command_line import main
from app.features.lab.trajectories.reading import parse_tum
from benchmarks.lasers.laser_bags import KINDS, LaserBag
from robot.geometry import Pose2

NAMES = {"ros1": "drive.bag", "sqlite3": "drive_sqlite3", "mcap": "drive_mcap"}


def refused(capsys, *arguments):
    """The code, and the one line that tells why."""
    code = main(["localize", *map(str, arguments)])
    lines = capsys.readouterr().err.strip().splitlines()
    assert len(lines) == 1, lines
    return code, lines[0]


def off(way):
    """Distance [m] of each pose from the truth at its stamp."""
    truth = {round(BEGAN + one.stamp, 6): true_pose(one) for one in drive()}
    at = [truth[round(float(stamp), 6)] for stamp in way.stamps]
    return np.hypot(*(way.poses[:, :2] - [[p.x, p.y] for p in at]).T)


@pytest.fixture(scope="module")
def one_bag(tmp_path_factory):
    return write_bag(tmp_path_factory.mktemp("bag") / "drive")


@pytest.mark.slow
def test_a_robot_anywhere_on_the_floor_is_found_and_followed(tmp_path, one_bag):
    found, way = run(tmp_path, one_bag)
    assert found["known"]
    assert off(way)[-20:].max() < 0.1
    last = true_pose(drive()[-1])
    pose, covariance = found["final"]["pose"], np.reshape(found["final"]["covariance"], (3, 3))
    wrong = np.array([pose["x"] - last.x, pose["y"] - last.y, pose["theta"] - last.theta])
    assert wrong @ np.linalg.solve(covariance + 1e-4 * np.eye(3), wrong) < 30
    assert found["scans"]["used"] == len(drive())
    assert found["settings"]["localization.filter.max_particles"] == 10_000
    assert {"numpy", "code"} <= found["versions"].keys()
    assert (tmp_path / "out/path.png").read_bytes().startswith(b"\x89PNG")


@pytest.mark.slow
def test_a_robot_whose_place_is_told_is_followed_from_the_first_scan(tmp_path, one_bag):
    start = true_pose(drive()[0])
    told = [str(start.x + 0.2), str(start.y - 0.2), str(start.theta + 0.1)]
    found, way = run(tmp_path, one_bag, "--initial-pose", *told, "--sd-xy", "0.3")
    assert len(way) == len(drive())
    assert off(way).max() < 0.25
    assert found["initial_pose"]["x"] == pytest.approx(start.x + 0.2)


@pytest.mark.slow
def test_a_place_that_turns_out_wrong_is_withdrawn_in_the_files(tmp_path, capsys):
    seen = drive(seconds=30.0, seed=4)
    bag = write_bag(tmp_path / "drive", seen=seen)
    elsewhere = office_map().pose_in_map(Pose2(8.5, 2.0, 1.5))
    told = [str(value) for value in elsewhere.to_array()]
    found, way = run(tmp_path, bag, "--initial-pose", *told, "--sd-xy", "0.3", "--sd-theta", "0.2")
    wrong = parse_tum((tmp_path / "out/localized_withdrawn.tum").read_text(), "withdrawn")
    assert found["state"] == "certain"
    assert found["scans"]["withdrawn"] == len(wrong)
    assert found["withdrawn"][0]["from"] == pytest.approx(wrong.stamps[0])
    assert sum(found["scans"]["by_state"].values()) == len(seen)
    truth = {round(BEGAN + one.stamp, 6): true_pose(one) for one in seen}
    last = truth[round(float(wrong.stamps[0]), 6)]
    assert math.hypot(wrong.poses[0, 0] - last.x, wrong.poses[0, 1] - last.y) > 1
    assert not set(wrong.stamps) & set(way.stamps)
    assert "s that were told as certain are withdrawn" in capsys.readouterr().out


@pytest.mark.slow
def test_every_kind_of_bag_gives_the_same_result(tmp_path):
    ways = []
    for kind in KINDS:
        (tmp_path / kind).mkdir()
        bag = write_bag(tmp_path / NAMES[kind], kind)
        _, way = run(tmp_path / kind, bag, "--seed", "3")
        ways.append(np.column_stack([way.stamps, way.poses]))
    assert (ways[0] == ways[1]).all()
    assert (ways[0] == ways[2]).all()


@pytest.mark.slow
def test_an_upside_down_laser_that_counts_the_other_way_round_sees_the_same(tmp_path, one_bag):
    _, upright = run(tmp_path, one_bag)
    path = tmp_path / "turned"
    with LaserBag(path, "mcap") as bag:
        bag.transform(BEGAN, "base_link", "/laser", LASER.place, rolled=True, topic="/tf_static")
        for one in drive():
            bag.odometry(BEGAN + one.stamp, one.odometry)
            first = -LASER.bearings[0]
            bag.scan(BEGAN + one.stamp, one.ranges, first=first, step=-LASER.step, frame="laser")
    _, turned = run(tmp_path, path)
    assert upright.stamps == pytest.approx(turned.stamps)
    assert upright.poses == pytest.approx(turned.poses, abs=0.05)


@pytest.mark.slow
def test_transforms_alone_tell_odometry(tmp_path, one_bag):
    path = write_bag(tmp_path / "tf_only", odometry="tf")
    found, way = run(tmp_path, path)
    assert found["topics"]["odometry"] == "tf"
    _, same = run(tmp_path, one_bag)
    assert way.poses == pytest.approx(same.poses, abs=1e-6)


@pytest.mark.slow
def test_where_the_laser_sits_is_told_or_assumed(tmp_path, capsys):
    path = write_bag(tmp_path / "bare", mounted=False)
    found, _ = run(tmp_path, path, "--laser-pose", "0.1", "0", "0")
    assert found["frames"]["laser_pose_from"] == "--laser-pose"
    capsys.readouterr()
    found, _ = run(tmp_path, path)
    assert found["frames"]["laser_pose_from"].startswith("nothing")
    assert "taken to sit at the robot's middle" in capsys.readouterr().out


@pytest.mark.slow
def test_a_bag_without_metadata_is_read_all_the_same(tmp_path, one_bag):
    path = write_bag(tmp_path / "drive", "sqlite3")
    (path / "metadata.yaml").unlink()
    _, way = run(tmp_path, path)
    _, same = run(tmp_path, one_bag)
    assert (way.poses == same.poses).all()


@pytest.mark.slow
def test_how_many_threads_opencv_has_changes_nothing(tmp_path, one_bag):
    ways, before = [], cv2.getNumThreads()
    try:
        for threads in (1, 2):
            cv2.setNumThreads(threads)
            ways.append(run(tmp_path, one_bag)[1].poses)
    finally:
        cv2.setNumThreads(before)
    assert (ways[0] == ways[1]).all()


@pytest.mark.slow
def test_clocks_that_differ_are_told_of_and_got_over(tmp_path, capsys):
    path = tmp_path / "clocks"
    with LaserBag(path, "mcap") as bag:
        for one in drive():
            bag.odometry(one.stamp + 5e5, one.odometry, logged=BEGAN + one.stamp)
            form = {"first": LASER.bearings[0], "step": LASER.step}
            bag.scan(BEGAN + one.stamp, one.ranges, **form)
    code, told = refused(capsys, path, "--map", write_map(tmp_path), "--out", tmp_path / "out")
    assert code == 1
    assert "scans without odometry around them" in told
    assert "--clock log" in told
    _, way = run(tmp_path, path, "--clock", "log", "--laser-pose", "0.1", "0", "0")
    assert off(way)[-20:].max() < 0.15


def test_several_lasers_are_listed(tmp_path, capsys):
    path = tmp_path / "two"
    with LaserBag(path, "mcap") as bag:
        bag.odometry(1.0, Pose2())
        for topic in ("/front/scan", "/rear/scan"):
            bag.scan(1.0, [1.0, 2.0], first=0.0, step=0.1, topic=topic)
    code, told = refused(capsys, path, "--map", write_map(tmp_path))
    assert code == 2
    assert (
        "--scan-topic, several times if they are one robot's lasers: /front/scan, /rear/scan"
        in told
    )
    code, told = refused(capsys, path, "--map", write_map(tmp_path), "--scan-topic", "/side")
    assert code == 2
    assert "/front/scan, /rear/scan" in told


def test_a_bag_without_a_laser_lists_what_it_has(tmp_path, capsys):
    path = tmp_path / "blind"
    with LaserBag(path, "mcap") as bag:
        bag.odometry(1.0, Pose2())
    code, told = refused(capsys, path, "--map", write_map(tmp_path))
    assert code == 1
    assert "has no sensor_msgs/msg/LaserScan; it has /odom (nav_msgs/msg/Odometry, 1)" in told


def test_a_bag_without_odometry_lists_what_it_has(tmp_path, capsys):
    path = tmp_path / "lost"
    with LaserBag(path, "mcap") as bag:
        bag.scan(1.0, [1.0, 2.0], first=0.0, step=0.1)
    code, told = refused(capsys, path, "--map", write_map(tmp_path))
    assert code == 1
    assert "no nav_msgs/msg/Odometry and no tf2_msgs/msg/TFMessage" in told
    assert "/scan (sensor_msgs/msg/LaserScan, 1)" in told


@pytest.mark.parametrize("kind", KINDS)
def test_a_bag_cut_short_is_one_clear_line(tmp_path, capsys, kind):
    path = write_bag(tmp_path / NAMES[kind], kind)
    file = path if path.is_file() else next(one for one in path.iterdir() if one.suffix != ".yaml")
    content = file.read_bytes()
    file.write_bytes(content[: len(content) // 2])
    code, told = refused(capsys, path, "--map", write_map(tmp_path), "--out", tmp_path / "out")
    assert code == 1
    assert str(path) in told
    assert ("no message in it can be read" if kind == "mcap" else "mends it") in told


@pytest.mark.parametrize(
    ("arguments", "valid"),
    [
        (["--initial-pose", "0", "nan", "0"], "three finite numbers"),
        (["--initial-pose", "1e5", "0", "0"], "not on the map"),
        (["--sd-xy", "0.1"], "--initial-pose"),
        (["--clock", "wall"], "header, log"),
        (["--seed", "-1"], "0 to 4294967295"),
        (["--filter-config", "absent.toml"], "cannot be read"),
    ],
)
def test_a_wrong_argument_names_what_is_valid(tmp_path, capsys, one_bag, arguments, valid):
    code, told = refused(capsys, one_bag, "--map", write_map(tmp_path), *arguments)
    assert code == 2
    assert valid in told


@pytest.mark.parametrize(
    ("text", "valid"),
    [
        ("[localization.filter]\nmin_partikels = 3\n", "localization.filter.min_partikels"),
        ("[laser]\nknown_share = 2.0\n", "0.1 to 1"),
        ('[localization.filter]\nfilter = "grid"\n', "valid is particles"),
        ("= 3", "no TOML"),
    ],
)
def test_settings_of_a_file_are_checked(tmp_path, capsys, one_bag, text, valid):
    (tmp_path / "filter.toml").write_text(text)
    options = "--filter-config", tmp_path / "filter.toml"
    code, told = refused(capsys, one_bag, "--map", write_map(tmp_path), *options)
    assert code == 2
    assert valid in told


@pytest.mark.slow
def test_settings_of_a_file_are_used(tmp_path, one_bag):
    text = "[localization.filter]\nmin_particles = 2000\nmax_particles = 2000\n"
    (tmp_path / "filter.toml").write_text(text)
    found, _ = run(tmp_path, one_bag, "--filter-config", str(tmp_path / "filter.toml"))
    assert found["settings"]["localization.filter.min_particles"] == 2000
    assert found["rates"]["particles_at_end"] == 2000
    assert found["settings"]["localization.sensor.laser_max_range"] == 80.0


@pytest.mark.parametrize("name", ["absent.bag", "text.bag", "text.mcap", "text.txt", "empty"])
def test_what_is_no_bag_is_told(tmp_path, capsys, name):
    path = tmp_path / name
    if name == "empty":
        path.mkdir()
    elif name != "absent.bag":
        path.write_text("this is no recording, whatever its name says\n")
    code, told = refused(capsys, path, "--map", write_map(tmp_path))
    assert code == 1
    assert name in told


def test_help_shows_the_settings_for_lasers(capsys):
    with pytest.raises(SystemExit):
        main(["localize", "--help"])
    told = capsys.readouterr().out
    assert "sigma_hit = 0.2 m" in told
    assert "global_density = 250.0 1/m²" in told


def test_a_mistake_is_told_without_the_settings(capsys):
    with pytest.raises(SystemExit) as ended:
        main(["localize", "office.bag"])
    assert ended.value.code == 2
    told = capsys.readouterr().err
    assert told.endswith("the following arguments are required: --map\n")
    assert "sigma_hit" not in told


def test_a_bag_in_which_the_robot_never_moves_ends_without_a_guess(tmp_path):
    """One scan is not enough to be sure: then no way is told, but where it may be."""
    path = write_bag(tmp_path / "stands", seen=drive()[:1] * 1)
    out = tmp_path / "out"
    assert main(["localize", str(path), "--map", str(write_map(tmp_path)), "--out", str(out)]) == 0
    found = json.loads((out / "results.json").read_text())
    assert not found["known"]
    assert found["hypotheses"]
    assert not (out / "localized.tum").exists()
    assert all(math.isfinite(one["weight"]) for one in found["hypotheses"])


def test_results_replace_earlier_ones_and_no_file_of_somebody_else(tmp_path, capsys):
    path = write_bag(tmp_path / "stands", seen=drive()[:1] * 1)
    out = tmp_path / "out"
    command = ["localize", str(path), "--map", str(write_map(tmp_path)), "--out", str(out)]
    out.mkdir()
    precious = out / "path.png"
    precious.write_text("precious")
    assert main(command) == 2
    assert f"{precious} would be overwritten; valid is another name" in capsys.readouterr().err
    assert precious.read_text() == "precious"
    assert main([*command, "--force"]) == 0
    assert main(command) == 0
