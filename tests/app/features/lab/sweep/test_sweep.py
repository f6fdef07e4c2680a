"""Sweeps: a row for each point whatever happens, and nothing is done twice."""

import csv
import textwrap

import pytest
from in_process import Here
from sweep_files import KINEMATIC, write

from app.features.lab.sweep.command import sweep
from app.features.lab.sweep.points import MEASURES
from app.features.lab.sweep.report import plot_setting
from app.features.lab.sweep.sweep_file import load_sweep
from app.features.lab.workers import LocalWorkers, WorkerError
from app.settings.config import Config, with_settings

pytestmark = pytest.mark.slow

QUICK = with_settings(
    Config(), {"sim.camera.frame_rate": 4.0, "localization.filter.filter": "particles"}
)


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


def test_a_figure_of_files_far_down_in_folders_tells_them_apart_by_their_ends(tmp_path):
    models = [f"/{'far/' * 40}{name}.py:Model" for name in ("one", "other")]
    about = {"world": "sim", "condition": "default", "ate_rmse_m": 0.01}
    rows = [about | {"sensor_model": model} for model in models]
    plot_setting(tmp_path / "figure.svg", "sensor_model", rows, steady=False)
    drawing = (tmp_path / "figure.svg").read_text(encoding="utf-8")
    assert "/one.py:Model" in drawing
    assert "/other.py:Model" in drawing
