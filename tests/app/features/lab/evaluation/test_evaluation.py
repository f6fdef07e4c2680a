"""The experiment: it is the program that is evaluated, and the same seeds give the same results."""

import json
import re
from dataclasses import replace

import numpy as np
import pytest
from in_process import Here

from app.engine.build import build_program
from app.features.lab.evaluation.command import evaluate
from app.features.lab.evaluation.drives import EvaluationError, follow_drive, record
from app.features.lab.evaluation.experiment import Experiment, in_world
from app.features.lab.evaluation.results import METHODS, condition_table, spread
from app.features.lab.evaluation.runs import Run, follow, settled, time_to_converge
from app.features.lab.trajectories.reading import read_trajectory
from app.features.lab.workers import LocalWorkers
from app.messages.commands import SetPoseCommand
from app.messages.driving_commands import FigureEightCommand
from app.result_files import atomic_folder
from app.settings.config import Config
from robot.settings import SettingError
from sim.floor_camera import CameraSettings
from sim.imperfections import Imperfections
from sim.simulated import SimSettings

pytestmark = pytest.mark.slow

QUICK = Config(sim=SimSettings(camera=CameraSettings(frame_rate=8)), map="stub")
"""Few pictures: what is tested here is not how exact they are."""
SMALL = Experiment(QUICK, ("sim",), seeds=2, laps=1)


@pytest.fixture(scope="module")
def done(tmp_path_factory):
    """A folder of results and what was returned."""
    folder = tmp_path_factory.mktemp("evaluation")
    return folder, evaluate(SMALL, Here(), folder)


def test_odometry_that_looks_at_pictures_is_the_same_when_a_drive_is_followed():
    config = replace(QUICK, robot="kinematic", added={"picture_odometry": {"fuse": True}})
    drive = record(config, 2.0)
    following = list(follow_drive(drive, config, lambda localization: None))
    seen = [tick for tick in drive.ticks if tick.scan is not None]
    assert len(following) == len(seen) > 10
    for (tick, odometry, _), recorded in zip(following, seen, strict=True):
        assert odometry == recorded.odometry_at_scan
        assert tick is recorded


@pytest.mark.parametrize("filter_name", ["hypotheses", "particles"])
def test_what_is_evaluated_is_what_the_engine_shows(filter_name):
    config = replace(QUICK, robot="sim", seed=5)
    config = replace(
        config,
        localization=replace(
            config.localization, filter=replace(config.localization.filter, filter=filter_name)
        ),
    )
    drive = record(config, 4.0)
    start = drive.ticks[0].truth
    wrong = SetPoseCommand(type="set_pose", x=start.x - 0.1, y=start.y - 0.1, theta=start.theta)
    run = follow(drive, config, replace(start, x=wrong.x, y=wrong.y))

    program = build_program(config)
    program.engine.commands.put(wrong)
    shown = {}
    for tick in drive.ticks:
        program.engine.commands.put(FigureEightCommand(type="figure_eight"))
        snapshot = program.engine.step()
        assert snapshot.truth == tick.truth
        if snapshot.scan_pose is not None:
            shown[snapshot.frame.stamp] = snapshot.scan_pose.to_array()
    program.robot.close()
    assert len(shown) > 20
    for stamp, estimate in zip(run.stamps, run.estimate, strict=True):
        np.testing.assert_array_equal(estimate, shown[stamp])


def test_the_same_seeds_give_the_same_files_whoever_does_the_work(done, tmp_path):
    folder, _ = done
    crew = LocalWorkers(2)
    evaluate(SMALL, crew, tmp_path)
    crew.close()
    files = sorted(p.relative_to(folder) for p in folder.rglob("*") if p.is_file())
    assert files == sorted(p.relative_to(tmp_path) for p in tmp_path.rglob("*") if p.is_file())
    for name in files:
        assert (folder / name).read_bytes() == (tmp_path / name).read_bytes(), name


def test_results_have_the_promised_form(done):
    folder, returned = done
    results = json.loads((folder / "results.json").read_text())
    assert results == returned
    assert results["experiment"] | {"seeds": 2, "laps": 1, "map": "stub"} == results["experiment"]
    assert results["experiment"]["duration_s"] == pytest.approx(15.9, abs=0.05)
    for method in METHODS:
        for measure in (
            "ate_rmse_m",
            "ate_aligned_rmse_m",
            "rpe_trans_rmse_m",
            "rpe_rot_rmse_rad",
        ):
            one = results["methods"][method][measure]
            assert len(one["per_seed"]) == 2
            assert one["mean"] == pytest.approx(np.mean(one["per_seed"]))
            assert one["median"] == pytest.approx(np.median(one["per_seed"]))
            assert one["max"] == max(one["per_seed"])
            assert one["ci95"][0] <= one["mean"] <= one["ci95"][1]
    assert results["recovery"]["of"] == 2
    assert [(c["world"], c["offset"]) for c in results["conditions"]] == [
        ("sim", None),
        ("sim", [-0.1, -0.1, 0.3]),
    ]
    assert set(results["conditions"][0]["methods"]["amcl"]["rpe"]) == {
        "0.1 s", "0.5 s", "1 s", "0.1 m", "0.5 m", "1 m",
    }  # fmt: skip
    assert results["experiment"]["settings"] == {"sim.camera.frame_rate": 8.0, "map": "stub"}


def test_written_trajectories_give_the_figures_of_the_results_in_evo(done, tmp_path, monkeypatch):
    monkeypatch.setenv("HOME", str(tmp_path))
    from evo.core import metrics, sync
    from evo.tools import file_interface

    folder, results = done
    for condition in results["conditions"]:
        for place, seed in enumerate((0, 1)):
            run = folder / condition["runs"] / str(seed)
            for method in METHODS:
                pair = sync.associate_trajectories(
                    *(
                        file_interface.read_tum_trajectory_file(str(run / f"{name}.tum"))
                        for name in ("truth", method)
                    )
                )
                for key, align in (("ate_rmse_m", False), ("ate_aligned_rmse_m", True)):
                    if align:
                        pair[1].align(pair[0])
                    peer = metrics.APE(metrics.PoseRelation.translation_part)
                    peer.process_data(pair)
                    ours = condition["methods"][method][key]["per_seed"][place]
                    assert ours == pytest.approx(
                        peer.get_statistic(metrics.StatisticsType.rmse), abs=1e-9
                    )


def test_trajectories_say_of_which_run_they_are(done):
    truths = sorted((done[0] / "runs").rglob("truth.tum"))
    notes = [read_trajectory(path).notes for path in truths]
    assert len(truths) == 4
    assert len({note for one in notes for note in one if note.startswith("run:")}) == 2


def test_the_report_opens_without_a_network(done):
    page = (done[0] / "report.html").read_text()
    assert page.count("data:image/svg+xml;base64,") == 3
    assert not re.search(r"(src|href)=\"(?!data:)", page)
    assert "http" not in page
    assert "9.6 mm" in page
    assert "9.6 mm" not in re.sub(r"<td>9\.6 mm</td>", "", page, count=1)


def test_odometry_is_off_and_the_estimate_is_not(done):
    sim = done[1]["conditions"][0]["methods"]
    assert sim["odometry"]["ate_rmse_m"]["mean"] > 0.01
    assert sim["amcl"]["ate_rmse_m"]["max"] < 0.002


def test_with_perfect_wheels_odometry_is_right():
    perfect = replace(QUICK.sim, imperfections=Imperfections.none())
    drive = record(replace(QUICK, robot="kinematic", sim=perfect), 4.0)
    run = follow(drive, QUICK, drive.ticks[0].truth)
    assert np.abs(run.odometry - run.truth).max() < 1e-4


def test_a_run_that_fails_leaves_the_old_results_as_they_were(done):
    folder, _ = done
    before = {p: p.read_bytes() for p in folder.rglob("*") if p.is_file()}
    broken = replace(SMALL, config=replace(QUICK, sensor_model="missing.py:Model"))
    with pytest.raises((EvaluationError, SettingError, OSError)):
        evaluate(broken, Here(), folder)
    assert {p: p.read_bytes() for p in folder.rglob("*") if p.is_file()} == before


def test_files_of_a_former_run_do_not_stay(tmp_path):
    for runs in (("0", "1"), ("0",)):
        with atomic_folder(tmp_path) as new:
            for run in runs:
                (new / "runs" / run).mkdir(parents=True)
            (new / "results.json").write_text(str(len(runs)))
    assert [path.name for path in (tmp_path / "runs").iterdir()] == ["0"]
    assert (tmp_path / "results.json").read_text() == "1"


def test_what_is_interrupted_leaves_nothing(tmp_path):
    with pytest.raises(KeyboardInterrupt), atomic_folder(tmp_path) as new:
        (new / "results.json").write_text("half")
        raise KeyboardInterrupt
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"seeds": 0}, "seeds is 0; valid is 1 or more"),
        ({"laps": 0}, "laps is 0"),
        ({"worlds": ("moon",)}, "no world 'moon'; valid are sim, as-real, hand-built, kinematic"),
        ({"offset": (0.0, float("nan"), 0.0)}, "not finite"),
        ({"first_seed": -1}, "first seed is -1"),
    ],
)
def test_what_cannot_be_evaluated_is_refused(wrong, message):
    with pytest.raises(SettingError, match=re.escape(message)):
        replace(SMALL, **wrong)


def test_the_world_as_real_is_what_it_says():
    real = in_world(Config(), "as-real")
    assert real.sim.imperfections.slip_sd == 2 * Config().sim.imperfections.slip_sd
    assert (real.sim.imperfections.camera_angle_sd, real.sim.imperfections.camera_position_sd) == (
        0.3,
        0.001,
    )
    assert real.sim.camera.stamp_error == 0.02
    assert real.sim.camera.uneven_light == 0.5
    assert real.localization == Config().localization


def run_of(distances, period=0.1):
    count = len(distances)
    estimate = np.zeros((count, 3))
    estimate[:, 0] = distances
    zeros = np.zeros((count, 3))
    covariance = np.tile(np.eye(3), (count, 1, 1))
    return Run(
        period * np.arange(count),
        zeros,
        zeros,
        estimate,
        covariance,
        np.zeros(count),
        np.ones(count, dtype=bool),
    )


def test_convergence_is_being_right_for_a_second():
    off = np.array([0.1] * 5 + [0.0] * 8 + [0.1] * 2 + [0.01] * 20)
    run = run_of(off)
    assert time_to_converge(run.stamps, off, 0 * off) == pytest.approx(1.5)
    assert run.stamps[settled(run)][0] == pytest.approx(2.5)
    assert time_to_converge(run.stamps, off, 0 * off + 0.2) == np.inf
    assert time_to_converge(run.stamps[:20], off[:20], 0 * off[:20]) == np.inf


def test_a_loss_is_not_hidden_by_having_been_right():
    kept, lost = run_of([0.2] * 5 + [0.0] * 30), run_of([0.0] * 20 + [0.06] + [0.0] * 20)
    table = condition_table([kept, lost])["convergence"]
    assert (table["converged"], table["right_to_the_end"], table["lost_again"]) == (2, 1, 1)
    assert table["right_to_the_end_per_seed"] == [True, False]
    assert table["lost_again_per_seed"] == [False, True]
    unsure = replace(lost, certain=np.zeros(41, dtype=bool))
    assert condition_table([kept, unsure])["convergence"]["lost_again"] == 0


def test_robots_that_never_converge_are_counted_and_not_averaged():
    table = condition_table([run_of([0.0] * 30), run_of([0.1] * 30)])["convergence"]
    assert (table["converged"], table["of"]) == (1, 2)
    assert table["seconds"]["per_seed"] == [0.0, None]
    assert table["seconds"]["mean"] == 0.0
    assert spread([np.nan])["mean"] is None


def test_covariances_are_compared_with_errors_by_chi_square():
    rng = np.random.default_rng(0)
    honest, sure = [], []
    for _ in range(12):
        run = run_of(np.zeros(4000))
        errors = rng.normal(0, 0.01, (4000, 3))
        run = replace(run, estimate=errors, covariance=np.tile(1e-4 * np.eye(3), (4000, 1, 1)))
        honest.append(run)
        sure.append(replace(run, covariance=run.covariance / 4))
    assert condition_table(honest)["nees"]["within"] == pytest.approx(0.95, abs=0.015)
    assert condition_table(honest)["nees"]["mean"] == pytest.approx(3, abs=0.05)
    assert condition_table(sure)["nees"]["too_sure"] > 0.99
