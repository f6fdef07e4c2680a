"""Statistics of the models: from drives to a file of parameters that the program takes."""

import json
from dataclasses import replace

import numpy as np
import pytest
from in_process import Here
from places import SHARED

from app.command_line import main
from app.features.lab.model_fits.command import ModelsJob, evaluate_models
from app.features.lab.model_fits.fitted_file import toml_of
from app.features.lab.model_fits.motion_statistics import recorded_motion
from app.settings.config import Config, load_config, with_settings
from app.trajectories.trajectory import Trajectory
from robot.settings import SettingError
from sim.floor_camera import CameraSettings
from sim.simulated import SimSettings

pytestmark = pytest.mark.slow

MRCLAM = SHARED / "mrclam"


@pytest.fixture(scope="module")
def done(tmp_path_factory):
    folder = tmp_path_factory.mktemp("models")
    config = Config(sim=SimSettings(camera=CameraSettings(frame_rate=15)))
    job = ModelsJob(config, "sim", robot=103, repeats=2, seeds=1, laps=1, drives=1, seconds=12.0)
    return folder, evaluate_models(job, Here(), folder)


def test_results_are_written_and_open_without_a_network(done):
    folder, results = done
    assert json.loads((folder / "results.json").read_text()) == results
    page = (folder / "report.html").read_text()
    assert page.count("data:image/svg+xml;base64,") == 2
    assert "http" not in page


def test_wheels_come_near_the_true_ones(done):
    motion = done[1]["motion"]
    for name, true in motion["true_multipliers"].items():
        assert motion["multipliers"][name] == pytest.approx(true, abs=0.008)
    assert abs(motion["true_multipliers"]["left_radius"] - 1) > 0.01
    ends = {one["motion"]: one for one in motion["ends"]}
    assert len(ends) == 10
    assert all(one["fitted"]["distance"] < 10 for one in ends.values())
    as_set = sum(one["distance"] for one in ends.values())
    assert as_set > 2 * sum(one["fitted"]["distance"] for one in ends.values())


def test_the_scanner_is_as_good_as_it_is(done):
    sensor = done[1]["sensor"]
    assert abs(sensor["all"]["bias"]) < 0.0002
    assert sensor["all"]["sd"] < 0.001
    assert 0.00005 < sensor["fit"]["sigma_hit"]["value"] < 0.0005
    assert sensor["usable"]["sigma_hit"] == 0.002
    assert 2 < sensor["correlation"]["rays_worth"] < 20


def test_the_program_takes_the_fitted_file(done):
    folder, results = done
    config = load_config(folder / "fitted.toml")
    assert config.sim.imperfections.robot == 103
    fitted = results["fitted"]
    assert config.localization.motion.alpha1 == fitted["localization.motion.alpha1"]
    assert config.localization.sensor.sigma_hit == 0.002
    left = fitted["drive.left_wheel_radius_multiplier"]
    assert config.drive.multipliers.left_radius == left != 1.0
    assert replace(config, drive=Config().drive) != Config()


def test_fitted_wheels_make_odometry_better(done):
    ate = {
        name: one["known"]["methods"]["odometry"]["ate_rmse_m"]["mean"]
        for name, one in done[1]["compared"].items()
    }
    assert ate["fitted"] < 0.8 * ate["default"]
    for one in done[1]["compared"].values():
        assert one["known"]["methods"]["amcl"]["ate_rmse_m"]["max"] < 0.002
        assert one["offset"]["convergence"]["converged"] == 1


def test_wheels_that_were_corrected_are_corrected_further():
    odometry = Trajectory.of_poses(STAMPS, path(1.0))
    truth = Trajectory.of_poses(STAMPS, path(1.01))
    before = with_settings(
        Config(),
        {
            "drive.left_wheel_radius_multiplier": 1.02,
            "drive.right_wheel_radius_multiplier": 1.02,
            "sim.camera.frame_rate": 10.0,
        },
    )
    left, right, separation = recorded_motion(odometry, truth, 0.0, before).multipliers
    assert left == pytest.approx(1.02 * 1.01, abs=0.002)
    assert right == pytest.approx(1.02 * 1.01, abs=0.002)
    assert separation == pytest.approx(1.01, abs=0.003)


def path(longer):
    """Poses (n, 3) of a robot that goes and turns, with some noise; each way is longer by that."""
    rng = np.random.default_rng(0)
    turn = 0.8 * np.sin(np.cumsum(rng.normal(0, 0.1, len(STAMPS)))) * 0.1
    theta = np.cumsum(turn)
    # The same wheels and noise each time; the truth alone is longer.
    way = longer * 0.015 + (rng.normal(0, 0.0005, len(STAMPS)) if longer != 1 else 0)
    steps = np.stack([way * np.cos(theta - turn / 2), way * np.sin(theta - turn / 2)], 1)
    return np.column_stack([np.cumsum(steps, axis=0), theta + rng.normal(0, 1e-3, len(STAMPS))])


STAMPS = 0.1 * np.arange(4000)


def test_what_the_program_would_refuse_is_not_written():
    with pytest.raises(SettingError, match="alpha1 is 11"):
        toml_of({"localization.motion.alpha1": 11.0})


@pytest.mark.data
@pytest.mark.skipif(not MRCLAM.exists(), reason="needs recorded odometry")
@pytest.mark.parametrize("robot", [1, 2])
def test_regions_fitted_to_half_a_recording_hold_the_other(robot, tmp_path):
    files = (
        "--recording", str(MRCLAM / f"ds6_Robot{robot}_Odometry.dat.gz"),
        "--truth", str(MRCLAM / f"ds6_Robot{robot}_Groundtruth.dat.gz"),
    )  # fmt: skip
    assert main(["evaluate", "models", *files, "--out", str(tmp_path)]) == 0
    motion = json.loads((tmp_path / "results.json").read_text())["motion"]
    assert motion["clock_offset_s"] == pytest.approx(0.2, abs=0.03)
    assert [region["horizon"] for region in motion["regions"]] == [1.0, 5.0, 20.0]
    for region in motion["regions"]:
        assert 0.92 <= region["held"] <= 0.98
        low, high = region["held_interval"]
        assert low < region["held"] < high
        assert region["judgement"] == "honest"
    load_config(tmp_path / "fitted.toml")


@pytest.mark.parametrize(
    ("given", "message"),
    [
        (["--repeats", "1"], "--repeats is 1; valid is 2 to 10000"),
        (["--seeds", "0"], "--seeds is 0"),
        (["--first-seed", "-2"], "--first-seed is -2"),
    ],
)
def test_too_little_is_refused(given, message, tmp_path, capsys):
    assert main(["evaluate", "models", *given, "--out", str(tmp_path / "out")]) == 2
    assert message in capsys.readouterr().err
