"""Sweeps: a row for each point whatever happens, and nothing is done twice."""

import csv
import re
import textwrap

import cv2
import numpy as np
import pytest
from pyarrow import parquet

from app.batch.workers import LocalWorkers, WorkerError
from app.command_line import main
from app.config import Config, with_settings
from app.sweep.points import AT_ONCE, _map_digest, at_once, jobs_of, key_of, points_of
from app.sweep.sweep import sweep
from app.sweep.sweep_file import load_sweep
from app.sweep.table import TableError, require_format, write_table
from app.sweep.work import MEASURES
from robot.settings import SettingError

QUICK = with_settings(
    Config(), {"camera.frame_rate": 4.0, "localization.filter.filter": "particles"}
)
KINEMATIC = """
    [sweep]
    seeds = 2
    worlds = ["kinematic"]

    [settings]
    localization.sensor.sigma_hit = [0.003, 5.0]
    localization.filter.min_particles = [100, 200]
"""


class Here:
    """Does jobs in this process, in order, and keeps them."""

    count = 1

    def __init__(self):
        self.jobs = []

    def each(self, work, jobs):
        for place, job in enumerate(jobs):
            self.jobs.append(job)
            yield place, work(job)

    def close(self):
        pass


class Told(Here):
    """Is told what is measured, and may be interrupted after some jobs."""

    def __init__(self, most=1000):
        super().__init__()
        self.most = most

    def each(self, work, jobs):
        def told(job):
            if len(self.jobs) > self.most:
                raise KeyboardInterrupt
            measured = {key: 0.001 * config.seed + 0.001 for key, config in job.configs.items()}
            return {key: dict.fromkeys(MEASURES, v) | {"error": ""} for key, v in measured.items()}

        return super().each(told, jobs)


def write(tmp_path, text):
    path = tmp_path / "trial.toml"
    path.write_text(textwrap.dedent(text))
    return path


def rows_of(folder):
    with (folder / "results.csv").open() as file:
        return list(csv.DictReader(file))


def test_each_point_is_a_row_and_bad_ones_say_why(tmp_path):
    file = load_sweep(write(tmp_path, KINEMATIC))
    here = Here()
    swept = sweep(file, QUICK, here, tmp_path / "out")
    rows = rows_of(tmp_path / "out")
    assert len(rows) == len(swept.rows) == 2 * 2 * 2
    assert len(here.jobs) == 2, "points of one robot share its drive"
    for row in rows:
        bad = row["localization.sensor.sigma_hit"] == "5.0"
        assert bool(row["error"]) == bad
        assert bool(row["ate_rmse_m"]) != bad
    assert "sigma_hit is 5 m; valid is 0.0005 to 0.5 m" in rows[-1]["error"]
    good = [float(row["ate_rmse_m"]) for row in rows if row["ate_rmse_m"]]
    assert all(0 < ate < 0.01 for ate in good)
    assert sorted(path.name for path in (tmp_path / "out" / "plots").iterdir()) == [
        "localization.filter.min_particles.svg",
        "localization.sensor.sigma_hit.svg",
    ]


def test_an_interrupted_sweep_goes_on_where_it_was(tmp_path):
    file = load_sweep(write(tmp_path, KINEMATIC))
    with pytest.raises(KeyboardInterrupt):
        sweep(file, QUICK, Told(most=1), tmp_path / "out")
    assert not (tmp_path / "out" / "results.csv").exists()
    rest, again = Told(), Told()
    swept = sweep(file, QUICK, rest, tmp_path / "out")
    assert (sum(len(job.configs) for job in rest.jobs), swept.done_before) == (2, 2)
    rows = rows_of(tmp_path / "out")
    assert sweep(file, QUICK, again, tmp_path / "out").done_before == 4
    assert (again.jobs, rows_of(tmp_path / "out")) == ([], rows)


def test_a_damaged_file_of_a_point_is_no_result(tmp_path):
    file = load_sweep(write(tmp_path, KINEMATIC.replace("seeds = 2", "seeds = 1")))
    sweep(file, QUICK, Told(), tmp_path / "out")
    points = sorted((tmp_path / "out" / "points").iterdir())
    points[0].write_text(points[0].read_text()[:20])
    here = Told()
    sweep(file, QUICK, here, tmp_path / "out")
    assert [len(job.configs) for job in here.jobs] == [1]


def test_a_worker_that_is_killed_repeats_its_own_task_only(tmp_path):
    """One model kills its process at its first use, once; another counts its drives."""
    (tmp_path / "count.py").write_text(
        textwrap.dedent(f"""
            import numpy as np

            class Count:
                first = True

                def log_likelihood(self, poses, scan):
                    if self.first:
                        self.first = False
                        with open({str(tmp_path / "counted")!r}, "a") as file:
                            file.write("1")
                    return np.zeros(len(poses))
        """)
    )
    (tmp_path / "killer.py").write_text(
        textwrap.dedent(f"""
            import os, signal
            from pathlib import Path
            import numpy as np

            class Killer:
                def log_likelihood(self, poses, scan):
                    mark = Path({str(tmp_path / "killed")!r})
                    if not mark.exists():
                        mark.write_text("")
                        os.kill(os.getpid(), signal.SIGKILL)
                    return np.zeros(len(poses))
        """)
    )
    file = load_sweep(
        write(
            tmp_path,
            f"""
            [sweep]
            seeds = 3
            worlds = ["kinematic"]
            [settings]
            sensor_model = ["{tmp_path}/count.py:Count", "{tmp_path}/killer.py:Killer"]
            """,
        )
    )
    crew = LocalWorkers(2)
    swept = sweep(file, QUICK, crew, tmp_path / "out")
    crew.close()
    assert (tmp_path / "killed").exists()
    assert len(swept.rows) == 6
    assert not any(row["error"] for row in swept.rows)
    counted = len((tmp_path / "counted").read_text())
    # For each drive a model is made twice: to be tried, and to be used.
    assert counted == 2 * (3 + 1), "three drives, one of them twice"


def test_a_point_that_always_ends_its_worker_takes_no_other_with_it(tmp_path):
    class Deadly(Told):
        """Ends whenever the point with 5 mm is among a job's."""

        def each(self, work, jobs):
            for place, outcome in super().each(work, jobs):
                sigmas = [c.localization.sensor.sigma_hit for c in jobs[place].configs.values()]
                yield place, WorkerError("it ended its worker") if 0.005 in sigmas else outcome

    text = KINEMATIC.replace("5.0", "0.005, 0.006")
    file = load_sweep(write(tmp_path, text))
    for _ in range(2):
        swept = sweep(file, QUICK, Deadly(), tmp_path / "out")
        bad = {row["localization.sensor.sigma_hit"] for row in swept.rows if row["error"]}
        good = {row["localization.sensor.sigma_hit"] for row in swept.rows if not row["error"]}
        assert (bad, good) == ({0.005}, {0.003, 0.006})


def test_what_failed_is_tried_again_the_next_time(tmp_path):
    class Broken(Told):
        """A machine on which nothing works."""

        def each(self, work, jobs):
            for place, job in enumerate(jobs):
                yield (
                    place,
                    {key: dict.fromkeys(MEASURES) | {"error": "no disk"} for key in job.configs},
                )

    file = load_sweep(write(tmp_path, KINEMATIC))
    assert all(row["error"] for row in sweep(file, QUICK, Broken(), tmp_path / "out").rows)
    assert sum(not row["error"] for row in sweep(file, QUICK, Told(), tmp_path / "out").rows) == 4


def test_an_interrupted_sweep_leaves_no_table_of_before(tmp_path):
    file = load_sweep(write(tmp_path, KINEMATIC))
    sweep(file, QUICK, Told(), tmp_path / "out")
    more = load_sweep(write(tmp_path, KINEMATIC.replace("seeds = 2", "seeds = 3")))
    with pytest.raises(KeyboardInterrupt):
        sweep(more, QUICK, Told(most=0), tmp_path / "out")
    assert [path.name for path in (tmp_path / "out").iterdir()] == ["points"]


def test_many_workers_share_a_drive_less():
    assert [at_once(points, 1) for points in (1, 8, 16, 100)] == [1, 4, 8, AT_ONCE]
    assert at_once(8, 8) == at_once(8, 100) == 1


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
    monkeypatch.setattr("app.sweep.points.versions", lambda: {"code": "other"})
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
            {"imperfections.slip_sd": slip, "localization.sensor.likelihood_weight": weight},
        )
        for slip in (0.01, 0.02)
        for weight in [0.01 * n for n in range(1, AT_ONCE + 2)]
    }
    jobs = jobs_of(configs, 16.0, ())
    assert sorted(len(job.configs) for job in jobs) == [1, 1, AT_ONCE, AT_ONCE]
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
        ("[sweep]\nsteps = 1", "line 2: steps is unknown; valid are first_seed"),
        ("[sweep]\nworlds = ['moon']", "worlds has 'moon'; valid are sim, as-real, kinematic"),
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
