"""``brickpose evaluate models``: statistics, fitted parameters, and how well these perform."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from app.console import say
from app.features.lab.evaluation.command import Given, worlds_from_options
from app.features.lab.evaluation.experiment import Experiment, run
from app.features.lab.evaluation.recorded import clock_of
from app.features.lab.evaluation.results import condition_table
from app.features.lab.localize.reading.bag_trajectory import read_any
from app.features.lab.model_fits.fitted_file import fitted_settings, toml_of
from app.features.lab.model_fits.likelihood import FitError
from app.features.lab.model_fits.models_report import (
    Table,
    models_report,
    motion_table,
    sensor_table,
)
from app.features.lab.model_fits.motion_statistics import (
    MotionStatistics,
    recorded_motion,
    repeated_motions,
)
from app.features.lab.model_fits.sensor_statistics import SensorStatistics, scanned_drives
from app.features.lab.report_page import millimetres
from app.features.lab.trajectories.clock_offset import require_same_run
from app.features.lab.workers import Workers, workers_from_options
from app.options import config_of
from app.result_files import RESULTS, atomic_folder, write_json
from app.settings.config import Config, with_settings
from app.settings.provenance import changed_settings, versions
from app.trajectories.trajectory import TrajectoryError
from robot.settings import SettingError

FITTED = "fitted.toml"
OUT = Path("evaluation") / "models"
LIMITS = {"repeats": (2, 10_000), "seeds": (2, 10_000), "first_seed": (0, 2**31)}


@dataclass(frozen=True)
class ModelsJob:
    """The measurements of one simulated robot."""

    config: Config
    world: str
    robot: int
    """Seed of the robot's dimensions."""
    repeats: int
    """Number of drives of each motion."""
    seeds: int
    """Number of runs that compare fitted and default settings."""
    laps: int = 2
    """Laps of the figure-eight in each of these runs."""
    drives: int = 3
    """Number of figure-eights whose scans are compared with exact ones."""
    seconds: float = 32.0
    """Duration of each of these figure-eights [s]."""


def evaluate_models(job: ModelsJob, workers: Workers, folder: Path) -> Table:
    """Measure one simulated robot; write ``results.json``, ``report.html``, ``fitted.toml``.

    Raises:
        EvaluationError, FitError: a drive cannot be made, or is not enough for a fit.
        OSError: the folder cannot be written.
    """
    config = with_settings(job.config, {"sim.imperfections.robot": job.robot, "seed": job.robot})
    with atomic_folder(folder) as new:
        motion = repeated_motions(config, job.world, job.repeats, workers)
        sensor = scanned_drives(config, job.world, job.drives, job.seconds, workers)
        settings, _ = fitted_settings(motion, sensor, config)
        facts = {name: getattr(job, name) for name in ("world", "robot", "repeats", "seeds")}
        comments = (
            f"Fitted to robot {job.robot} in the world {job.world} by brickpose evaluate models.",
            "Ranges spread by sigma_hit = "
            f"{sensor.fit.values.sigma_hit:.6f} m; a filter is set no narrower than here.",
        )
        comparison = _compared(config, settings, job, workers)
        facts["map"] = config.map
        return _written(new, config, facts, comments, motion, sensor, comparison)


def evaluate_recorded_models(
    recording: Path,
    truth: Path,
    folder: Path,
    body: str | None,
    clock: float | None,
    config: Config,
    topics: tuple[str | None, str | None] = (None, None),
) -> Table:
    """Evaluate recorded odometry with truth, and write the same files; only motion is evaluated.

    Args:
        folder: for ``results.json``, ``report.html`` and ``fitted.toml``.
        body: which rigid body of a motion capture's file.
        clock: what to add to odometry's stamps [s]; None estimates it.
        config: settings of the robot and the filter.
        topics: of odometry and truth that are bags.

    Raises:
        TrajectoryError: a file cannot be read, the files are not of one run, or the robot drives
            too little; says what is needed.
        OSError: the folder cannot be written.
    """
    odometry, true = read_any(recording, topic=topics[0]), read_any(truth, body, topics[1])
    offset = require_same_run(true, odometry).correction if clock is None else clock
    facts = {"recording": recording.name, "truth": truth.name, "clock_offset_s": offset}
    comment = f"Fitted to the first half of {recording.name} by brickpose evaluate models."
    with atomic_folder(folder) as new:
        try:
            motion = recorded_motion(odometry, true, offset, config)
        except FitError as error:
            raise TrajectoryError(f"{odometry.name}: {error}") from error
        return _written(new, config, facts, (comment,), motion, None, None)


def _written(
    folder: Path,
    config: Config,
    facts: Table,
    comments: tuple[str, ...],
    motion: MotionStatistics,
    sensor: SensorStatistics | None,
    comparison: Table | None,
) -> Table:
    """Write all files and return the results."""
    settings, excesses = fitted_settings(motion, sensor, config)
    results = {
        "experiment": facts | {"settings": changed_settings(config), "versions": versions()},
        "motion": motion_table(motion),
        "sensor": sensor_table(sensor) if sensor else None,
        "fitted": settings,
        "compared": comparison,
    }
    comments += tuple(
        f"{path} was fitted as {value:.6g}, which it may not be."
        for path, value in excesses.items()
    )
    # A simulated run with this file then has the robot that was measured.
    robot = {"sim.imperfections.robot": facts["robot"]} if "robot" in facts else {}
    (folder / FITTED).write_text(toml_of(settings | robot, comments), encoding="utf-8")
    page = models_report(results, motion, sensor, config)
    (folder / "report.html").write_text(page, encoding="utf-8")
    write_json(folder / RESULTS, results)
    return results


def _compared(config: Config, settings: Table, job: ModelsJob, workers: Workers) -> Table:
    """Run the experiment with the default and with the fitted settings, for the same robot."""
    summary = {}
    for name, config_used in (("default", config), ("fitted", with_settings(config, settings))):
        experiment = Experiment(config_used, (job.world,), job.robot + 1000, job.seeds, job.laps)
        outcomes = run(experiment, workers)[job.world]
        summary[name] = {
            "known": condition_table([outcome.known for outcome in outcomes]),
            "offset": condition_table([outcome.offset for outcome in outcomes]),
        }
    return summary


def models_command(given: Given) -> int:
    """Measure one simulated robot, or evaluate a recording."""
    folder = given.get("out", OUT)
    if "recording" in given:
        files = given["recording"], given["truth"]
        clock = clock_of(given.get("clock_offset", "auto"))
        results = evaluate_recorded_models(
            *files,
            folder,
            given.get("body"),
            clock,
            config_of(given),
            (given.get("recording_topic"), given.get("truth_topic")),
        )
        for region in results["motion"]["regions"]:
            say(_region_line(region))
    else:
        results = _simulated(given, folder)
        for name, tables in results["compared"].items():
            ate = tables["known"]["methods"]
            say(
                f"{name} settings: odometry {millimetres(ate['odometry']['ate_rmse_m']['mean'])}, "
                f"AMCL {millimetres(ate['amcl']['ate_rmse_m']['mean'])}"
            )
    alphas = results["motion"]["alphas"]
    say(", ".join(f"{name} {fit['value']:.4g}" for name, fit in alphas.items()))
    say(f"fitted parameters are in {folder / FITTED}, for --config")
    say(f"the report is {folder / 'report.html'}")
    return 0


def _region_line(region: dict[str, Any]) -> str:
    low, high = region["held_interval"]
    return (
        f"the 95 % region over {region['horizon']:g} s held {region['held']:.1%} of the second "
        f"half ({low:.1%} to {high:.1%}, as of {region['held_independent']:.0f} independent "
        f"windows): {region['judgement']}"
    )


def _simulated(given: Given, folder: Path) -> dict[str, Any]:
    for name, (low, high) in LIMITS.items():
        if name in given and not low <= given[name] <= high:
            option = "--" + name.replace("_", "-")
            raise SettingError(f"{option} is {given[name]}; valid is {low} to {high}")
    config = config_of(given)
    worlds = worlds_from_options(given, config)
    if len(given.get("world", ())) > 1:
        raise SettingError("models are measured in one --world")
    job = ModelsJob(
        config,
        worlds[0],
        given.get("first_seed", 0),
        given.get("repeats", 20),
        given.get("seeds", 6),
    )
    crew = workers_from_options(given)
    try:
        return evaluate_models(job, crew, folder)
    finally:
        crew.close()
