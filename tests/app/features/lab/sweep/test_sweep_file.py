"""Sweep files, their points and keys, and tables."""

import re

import cv2
import numpy as np
import pytest
from pyarrow import parquet
from sweep_files import KINEMATIC, write

from app.command_line import main
from app.features.lab.sweep.points import (
    MOST_POINTS,
    _map_digest,
    jobs_of,
    key_of,
    points_of,
    points_per_job,
)
from app.features.lab.sweep.report import TableError, require_format, write_table
from app.features.lab.sweep.sweep_file import load_sweep
from app.settings.config import Config, with_settings
from robot.settings import SettingError


def test_many_workers_share_a_drive_less():
    assert [points_per_job(points, 1) for points in (1, 8, 16, 100)] == [1, 4, 8, MOST_POINTS]
    assert points_per_job(8, 8) == points_per_job(8, 100) == 1


def test_a_random_sample_is_the_same_with_the_same_seed(tmp_path):
    file = load_sweep(
        write(
            tmp_path,
            """
            [sweep]
            sample = 40
            [settings]
            localization.sensor.sigma_hit = { low = 0.001, high = 0.1, log = true }
            localization.filter.min_particles = { low = 100, high = 500 }
            localization.sensor.laser_model_type = ["beam", "likelihood_field"]
            """,
        )
    )
    points = file.points(Config())
    assert points == load_sweep(tmp_path / "trial.toml").points(Config())
    assert len(points) == 40
    sigmas = [point["localization.sensor.sigma_hit"] for point in points]
    assert all(0.001 <= sigma <= 0.1 for sigma in sigmas)
    assert sum(sigma < 0.01 for sigma in sigmas) == pytest.approx(20, abs=8)
    assert {type(point["localization.filter.min_particles"]) for point in points} == {int}
    assert len({point["localization.sensor.laser_model_type"] for point in points}) == 2
    assert all(point.config for point in points_of(file, Config()))


def test_the_key_of_a_point_is_of_all_that_it_depends_on(tmp_path, monkeypatch):
    model = tmp_path / "mine.py"
    model.write_text("1")
    config = with_settings(Config(), {"sensor_model": f"{model}:Mine"})
    keys = {key_of(config, 16.0, ())}
    keys.add(key_of(with_settings(config, {"seed": 1}), 16.0, ()))
    keys.add(key_of(with_settings(config, {"localization.sensor.z_hit": 0.9}), 16.0, ()))
    keys.add(key_of(config, 32.0, ()))
    keys.add(key_of(config, 16.0, (0.1, 0.0, 0.0)))
    model.write_text("2")
    keys.add(key_of(config, 16.0, ()))
    (tmp_path / "beside.py").write_text("1")
    keys.add(key_of(config, 16.0, ()))
    monkeypatch.setattr("app.features.lab.sweep.points.versions", lambda: {"code": "other"})
    keys.add(key_of(config, 16.0, ()))
    assert len(keys) == 8


def test_the_picture_of_a_map_is_part_of_the_key(tmp_path):
    """Also where the map's file only names it."""
    (tmp_path / "room.yaml").write_text(
        "image: room.png\nresolution: 0.05\norigin: [0, 0, 0]\nnegate: 0\n"
        "occupied_thresh: 0.65\nfree_thresh: 0.196\n"
    )
    keys = set()
    for wall in (5, 10):
        picture = np.full((40, 40), 254, dtype=np.uint8)
        picture[wall] = 0
        cv2.imwrite(str(tmp_path / "room.png"), picture)
        _map_digest.cache_clear()
        keys.add(key_of(with_settings(Config(), {"map": str(tmp_path / "room.yaml")}), 16.0, ()))
    assert len(keys) == 2


def test_drives_are_shared_by_what_follows_them_alone():
    configs = {
        f"{slip}{weight}": with_settings(
            Config(),
            {"sim.imperfections.slip_sd": slip, "localization.sensor.likelihood_weight": weight},
        )
        for slip in (0.01, 0.02)
        for weight in [0.01 * n for n in range(1, MOST_POINTS + 2)]
    }
    jobs = jobs_of(configs, 1, ())
    assert sorted(len(job.configs) for job in jobs) == [1, 1, MOST_POINTS, MOST_POINTS]
    assert sorted(key for job in jobs for key in job.configs) == sorted(configs)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("[settings]\nlocalization.sensor.sigma_hut = [1]", "line 2: .*sigma_hut is no setting"),
        ("[settings]\nsigma_hit = [1.0]", "line 2: .*valid are localization.sensor.sigma_hit"),
        ("[settings]\n\nmap = []", "line 3: map needs a list"),
        ("[settings]\nmap = 'tee'", "line 2: map needs a list"),
        ("[settings]\nseed = [1]", "line 2: seed is no setting that can be swept"),
        ("[sweep]\nseeds = 0\n[settings]\nmap=['tee']", "line 2: seeds is 0; valid is 1 to 10000"),
        ("[sweep]\nsteps = 1", "line 2: steps is unknown; valid are conditions"),
        (
            "[sweep]\nworlds = ['moon']",
            "worlds has 'moon'; valid are sim, as-real",
        ),
        ("[sweep]\nconditions = ['wet']", "no condition 'wet'; valid are default, noisy, dark"),
        ("[sweep]\noffset = [1.0]", "offset is not"),
        ("[swoop]\nseeds = 1", "line 1: swoop is unknown; valid are sweep, settings"),
        ("[sweep]\nseeds = 1", "no settings; valid is a table"),
        ("[settings]\nmap = [", "is no TOML"),
        (
            "[settings]\nlocalization.sensor.sigma_hit = [0.003, [1, 2]]",
            r"line 2: localization.sensor.sigma_hit has the value \[1, 2\]; valid are numbers",
        ),
        (
            "[settings.localization.sensor]\nz_hit = { low = 0.1, high = 0.2 }",
            "line 2: localization.sensor.z_hit is an interval; that needs sample",
        ),
        (
            "[sweep]\nsample = 2\n[settings]\nlocalization.sensor.z_hit = {low = 0.2, high = 0.1}",
            "line 4: localization.sensor.z_hit low is 0.2, high is 0.1",
        ),
        (
            "[sweep]\nsample = 2\n[settings]\nlocalization.sensor.z_hit = {low = 0.2, hi = 0.1}",
            "line 4: localization.sensor.z_hit hi is unknown; valid are high, log, low",
        ),
    ],
)
def test_a_bad_sweep_file_is_refused_by_line(tmp_path, text, message):
    with pytest.raises(SettingError, match=message) as refused:
        load_sweep(write(tmp_path, text))
    assert str(tmp_path / "trial.toml") in str(refused.value)


def test_the_command_refuses_with_two_and_one_line(tmp_path, capsys):
    assert main(["sweep", str(write(tmp_path, "[settings]\nmop = ['tee']"))]) == 2
    assert capsys.readouterr().err.count("\n") == 1
    assert main(["sweep", str(tmp_path / "none.toml")]) == 2
    path = str(write(tmp_path, KINEMATIC))
    assert main(["sweep", path, "--format", "xls"]) == 2
    assert "valid are csv, parquet" in capsys.readouterr().err


def test_a_table_in_parquet_has_the_same_values(tmp_path):
    rows = [
        {"a": 1, "b": "x", "c": None, "d": True},
        {"a": 2.5, "b": 3, "c": 0.5, "d": False},
    ]
    write_table(tmp_path / "t.parquet", rows)
    assert parquet.read_table(tmp_path / "t.parquet").to_pylist() == [
        {"a": 1.0, "b": "x", "c": None, "d": True},
        {"a": 2.5, "b": "3", "c": 0.5, "d": False},
    ]
    with pytest.raises(TableError, match=re.escape("valid are csv, parquet")):
        require_format("xls")
