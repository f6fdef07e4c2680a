"""A recording against truth: published figures, clocks, and what is refused."""

import json
import math
from dataclasses import replace

import numpy as np
import pytest
from places import SHARED
from recorded_runs import eight, evaluate, mean, motive

from app.command_line import main
from app.features.lab.trajectories.reading import read_trajectory
from app.trajectories.trajectory import Trajectory
from app.trajectories.tum_file import write_tum

TUM = SHARED / "tum_ate"


@pytest.mark.data
@pytest.mark.skipif(not TUM.exists(), reason="needs recorded trajectories")
def test_published_figures_of_freiburg1_xyz(tmp_path):
    out = tmp_path / "out"
    files = (
        "--recording", str(TUM / "freiburg1_xyz-rgbdslam.txt"),
        "--truth", str(TUM / "freiburg1_xyz-groundtruth.txt"),
    )  # fmt: skip
    assert main(["evaluate", *files, "--out", str(out)]) == 0
    results = json.loads((out / "results.json").read_text())
    assert results["experiment"]["poses"] == 785
    assert mean(results) == pytest.approx(0.020079, abs=1e-6)
    assert mean(results, "ate_aligned_rmse_m") == pytest.approx(0.013470, abs=1e-6)
    assert "http" not in (out / "report.html").read_text()


def test_a_clock_that_is_off_is_found_and_set(tmp_path):
    write_tum(tmp_path / "truth.tum", eight(rate=120))
    write_tum(tmp_path / "estimate.tum", eight(offset=4321.37, noise=0.001))
    code, results = evaluate(tmp_path, "--truth", str(tmp_path / "truth.tum"))
    assert code == 0
    assert results["experiment"]["clock_offset_added_s"] == pytest.approx(-4321.37, abs=0.002)
    assert mean(results) == pytest.approx(0.001 * math.sqrt(2), rel=0.2)


def test_truth_with_a_repeated_stamp_is_read(tmp_path):
    true = eight(rate=120)
    stamps = np.array(true.stamps)
    stamps[1000] = stamps[999]
    write_tum(tmp_path / "truth.tum", replace(true, stamps=stamps, repeats=True))
    write_tum(tmp_path / "estimate.tum", eight(offset=5, noise=0.001))
    code, results = evaluate(tmp_path, "--truth", str(tmp_path / "truth.tum"))
    assert code == 0
    assert mean(results) == pytest.approx(0.001 * math.sqrt(2), rel=0.2)


@pytest.mark.slow
@pytest.mark.data
@pytest.mark.skipif(not TUM.exists(), reason="needs recorded trajectories")
@pytest.mark.parametrize("scale", [0.1, 0.4, 6.0])
def test_a_single_cameras_estimate_of_freiburg1_xyz(tmp_path, capsys, scale):
    found = read_trajectory(TUM / "freiburg1_xyz-rgbdslam.txt")
    found = replace(found, positions=found.positions * scale).shifted(777.0)
    write_tum(tmp_path / "estimate.tum", found)
    truth = ("--truth", str(TUM / "freiburg1_xyz-groundtruth.txt"))
    code, results = evaluate(tmp_path, *truth)
    assert code == 0, capsys.readouterr().err
    similarity = results["experiment"]["similarity"]
    assert similarity["is_free"]
    assert similarity["scale"] == pytest.approx(1 / scale, rel=0.02)
    assert similarity["ate_rmse_m"] == pytest.approx(0.0134, abs=5e-4)
    assert results["experiment"]["clock_offset_added_s"] == pytest.approx(-777, abs=0.02)


@pytest.mark.slow
@pytest.mark.parametrize("scale", [0.21, 1.0, 1.03, 4.2])
def test_a_free_scale_is_hinted_at_with_both_figures(tmp_path, capsys, scale):
    write_tum(tmp_path / "truth.tum", eight(rate=120))
    found = eight(noise=0.001)
    write_tum(tmp_path / "estimate.tum", replace(found, positions=found.positions / scale))
    code, results = evaluate(tmp_path, "--truth", str(tmp_path / "truth.tum"))
    assert code == 0
    similarity = results["experiment"]["similarity"]
    assert similarity["scale"] == pytest.approx(scale, rel=1e-3)
    assert similarity["ate_rmse_m"] == pytest.approx(0.0014, abs=2e-4)
    free = scale in (0.21, 4.2)
    assert similarity["is_free"] == free
    said, report = capsys.readouterr(), (tmp_path / "out" / "report.html").read_text()
    assert (f"multiplied by {similarity['scale']:.4g}" in said.out + said.err) == free
    assert ("Is the scale free?" in report) == free


@pytest.mark.parametrize("late", [0.008, 0.012])
def test_a_clock_that_is_off_by_less_than_stamps_may_be_is_set_where_it_shows(tmp_path, late):
    write_tum(tmp_path / "truth.tum", eight(rate=120))
    write_tum(tmp_path / "estimate.tum", eight(offset=late))
    code, results = evaluate(tmp_path, "--truth", str(tmp_path / "truth.tum"))
    assert code == 0
    assert results["experiment"]["clock_offset_added_s"] == pytest.approx(-late, abs=0.001)
    assert mean(results) < 0.0005


def test_truth_of_motive_is_seen_from_above(tmp_path, capsys):
    motive(tmp_path / "take.csv", eight(rate=120))
    write_tum(tmp_path / "estimate.tum", eight(offset=5.0))
    code, results = evaluate(tmp_path, "--truth", str(tmp_path / "take.csv"))
    assert code == 0, capsys.readouterr().err
    assert mean(results) < 0.001
    assert mean(results, "heading_rmse_rad") < 0.01


def test_one_of_several_bodies_is_named(tmp_path, capsys):
    motive(tmp_path / "take.csv", eight(rate=60), bodies=("cup", "robot"))
    write_tum(tmp_path / "estimate.tum", eight())
    truth = ("--truth", str(tmp_path / "take.csv"))
    assert evaluate(tmp_path, *truth)[0] == 2
    assert "cup" in (error := capsys.readouterr().err)
    assert "robot" in error
    assert evaluate(tmp_path, *truth, "--body", "robot")[0] == 0


@pytest.mark.parametrize(
    ("truth", "message"),
    [
        ("", "empty"),
        ("1 0 0 0 0 0 0 1\n", "1 pose"),
        ("1 0 0 0 0 0 0 1\n0.5 0 0 0 0 0 0 1\n", "line 2: "),
        ("1 0 0 0 0 0 0 1\n2 nan 0 0 0 0 0 1\n", "line 2: "),
        ("1 0 0 0 0 0 0 1\n2 0 0 0 0 1\n", "line 2"),
    ],
)
def test_a_bad_file_is_refused_by_name_and_line(tmp_path, capsys, truth, message):
    (tmp_path / "truth.tum").write_text(truth)
    write_tum(tmp_path / "estimate.tum", eight())
    assert evaluate(tmp_path, "--truth", str(tmp_path / "truth.tum"))[0] == 2
    error = capsys.readouterr().err
    assert "truth.tum" in error
    assert message in error
    assert error.count("\n") == 1
    assert not (tmp_path / "out" / "results.json").exists()


def test_truth_of_another_run_is_refused(tmp_path, capsys):
    rng = np.random.default_rng(1)
    turns = np.cumsum(rng.normal(0, 0.2, 960)) / 30
    way = np.cumsum(0.005 * np.stack([np.cos(turns), np.sin(turns)], 1), 0)
    stamps = np.arange(960) / 30
    write_tum(tmp_path / "truth.tum", Trajectory.of_poses(stamps, np.column_stack([way, turns])))
    write_tum(tmp_path / "estimate.tum", eight())
    assert evaluate(tmp_path, "--truth", str(tmp_path / "truth.tum"))[0] == 2
    assert "another run" in capsys.readouterr().err


def test_truth_of_another_robot_on_the_same_path_is_refused_where_files_say_so(tmp_path, capsys):
    for name, seed in (("truth.tum", 1), ("estimate.tum", 0)):
        write_tum(tmp_path / name, eight(), [f"run: seed {seed} in the world sim"])
    assert evaluate(tmp_path, "--truth", str(tmp_path / "truth.tum"))[0] == 2
    assert "of seed 1 in the world sim, and of seed 0" in capsys.readouterr().err


def test_stamps_that_do_not_overlap_are_refused_when_the_clock_is_given(tmp_path, capsys):
    write_tum(tmp_path / "truth.tum", eight())
    write_tum(tmp_path / "estimate.tum", eight(offset=100.0))
    truth = ("--truth", str(tmp_path / "truth.tum"))
    assert evaluate(tmp_path, *truth, "--clock-offset", "0")[0] == 2
    assert "truth.tum" in capsys.readouterr().err
    assert evaluate(tmp_path, *truth, "--clock-offset", "-100")[0] == 0
    assert evaluate(tmp_path, *truth, "--clock-offset", "soon")[0] == 2
    assert "valid is auto or a number of seconds" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("given", "message"),
    [
        (["--recording", "a", "--truth", "b", "--laps", "1"], "--laps does not go with experiment"),
        (["--body", "cup"], "--body does not go with experiment of a simulation"),
        (["models", "--laps", "1"], "--laps does not go with models of a simulation"),
        (["--repeats", "3"], "--repeats does not go with experiment"),
        (["--workers", "2", "--cluster", "tcp://127.0.0.1:1"], "--workers is for this machine"),
        (["models", "--world", "sim", "--world", "as-real"], "one --world"),
    ],
)
def test_options_without_effect_are_refused(given, message, capsys):
    assert main(["evaluate", *given]) == 2
    assert message in capsys.readouterr().err


def test_what_is_no_folder_is_refused_before_the_work(tmp_path, capsys):
    (tmp_path / "file").write_text("")
    assert main(["evaluate", "--seeds", "1", "--out", str(tmp_path / "file")]) == 2
    assert "valid is a folder" in capsys.readouterr().err


def test_half_a_pair_is_refused(tmp_path, capsys):
    assert main(["evaluate", "--recording", "a.tum", "--out", str(tmp_path / "out")]) == 2
    assert "--recording and --truth are given together" in capsys.readouterr().err
