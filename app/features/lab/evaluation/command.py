"""``brickpose evaluate``: the experiment, or recorded trajectories, and the files it writes."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

from app.console import say
from app.engine.robots import resolve_robot
from app.features.lab.evaluation.experiment import Experiment, RunPair, engine_of_worlds, run
from app.features.lab.evaluation.recorded import RUN, evaluate_recording, reading_of
from app.features.lab.evaluation.recorded_words import asker, recorded_lines
from app.features.lab.evaluation.report import Evaluation, figure3, report
from app.features.lab.evaluation.results import condition_table, trajectory
from app.features.lab.evaluation.runs import SHOWN, Run
from app.features.lab.report_page import millimetres, seconds
from app.features.lab.workers import Workers, workers_from_options
from app.options import config_of
from app.result_files import RESULTS, atomic_folder, write_json
from app.settings.config import MAPS, Config
from app.settings.provenance import changed_settings, versions
from app.trajectories.tum_file import write_tum
from robot.fields.field_loading import load_field

WITHOUT, WITH = "known", "offset"
Given = dict[str, Any]
"""The options that the user gave on the command line."""
OUT = Path("evaluation")


def evaluate(experiment: Experiment, workers: Workers, folder: Path) -> dict[str, Any]:
    """Run the experiment and write ``results.json``, ``report.html``, ``figure3.svg``, ``runs/``.

    Args:
        experiment: which robots drive, where and for how long.
        workers: the processes that do the work.
        folder: where the results go; created if it does not exist.

    Returns:
        The content of ``results.json``; the same for the same seeds, with any workers.

    Raises:
        EvaluationError: a drive cannot be made or followed.
        OSError: the folder cannot be written.
    """
    field = load_field(experiment.config.map, MAPS)
    with atomic_folder(folder) as new:
        outcomes_by_world = run(experiment, workers)
        conditions = {
            (world, given): [getattr(outcome, given) for outcome in outcomes]
            for world, outcomes in outcomes_by_world.items()
            for given in (WITHOUT, WITH)
        }
        results = results_of(experiment, conditions)
        if experiment.calibrate is not None:
            results["calibration"] = _calibrations(experiment, outcomes_by_world, new)
        evaluation = Evaluation(experiment, field, conditions, results)
        (new / "figure3.svg").write_text(figure3(evaluation), encoding="utf-8")
        (new / "report.html").write_text(report(evaluation), encoding="utf-8")
        for (world, condition), runs in conditions.items():
            for seed, item in zip(experiment.all_seeds, runs, strict=True):
                place = new / "runs" / _place(experiment, world, condition) / str(seed)
                _write_run(place, item, f"{RUN} seed {seed} in the world {world}")
        write_json(new / RESULTS, results)
    return results


def results_of(
    experiment: Experiment, conditions: dict[tuple[str, str], list[Run]]
) -> dict[str, Any]:
    """Return the content of ``results.json``."""
    tables = {key: condition_table(runs) for key, runs in conditions.items()}
    first = experiment.worlds[0]
    return {
        "experiment": {
            "seeds": experiment.seeds,
            "first_seed": experiment.first_seed,
            "laps": experiment.laps,
            "map": experiment.config.map,
            "duration_s": experiment.duration,
            "world": first,
            "engine": engine_of_worlds(experiment.config, experiment.worlds),
            "worlds": list(experiment.worlds),
            "offset": list(experiment.offset),
            "rpe_over": SHOWN,
            "settings": changed_settings(experiment.config),
            "versions": versions(),
        },
        "methods": tables[first, WITHOUT]["methods"],
        "recovery": tables[first, WITH]["convergence"],
        "conditions": [
            {
                "world": world,
                "offset": list(experiment.offset) if given == WITH else None,
                "runs": f"runs/{_place(experiment, world, given)}".rstrip("/."),
            }
            | table
            for (world, given), table in tables.items()
        ],
    }


def _calibrations(
    experiment: Experiment, outcomes: dict[str, list[RunPair]], folder: Path
) -> dict[str, Any]:
    """Write the robots' profiles; return what ``results.json`` says of the calibrations."""
    failed: dict[str, dict[str, str]] = {}
    for world, robots in outcomes.items():
        failed[world] = {}
        for seed, robot in zip(experiment.all_seeds, robots, strict=True):
            place = folder / "runs" / _place(experiment, world, WITHOUT) / str(seed)
            place.mkdir(parents=True, exist_ok=True)
            if robot.profile is None:
                failed[world][str(seed)] = robot.not_calibrated
            else:
                (place / "profile.toml").write_text(robot.profile.to_toml(), encoding="utf-8")
    return {"seconds": experiment.calibrate, "not_calibrated": failed}


def _place(experiment: Experiment, world: str, given: str) -> str:
    """Return a condition's folder under ``runs/``: for the first condition ``runs/`` itself."""
    if (world, given) == (experiment.worlds[0], WITHOUT):
        return "."
    return world if given == WITHOUT else f"{world}-offset"


def _write_run(folder: Path, run: Run, note: str) -> None:
    folder.mkdir(parents=True, exist_ok=True)
    for method in ("truth", "odometry", "amcl"):
        about = f"{method}, map frame"
        write_tum(folder / f"{method}.tum", trajectory(run, method), notes=(about, note))


def evaluate_command(given: Given) -> int:
    """Run the experiment, or compare a recording with the truth."""
    folder = given.get("out", OUT)
    if "recording" in given:
        files = given["recording"], given["truth"]
        results = evaluate_recording(*files, folder, reading_of(given), asker())
        for line in recorded_lines(results):
            say(line)
    else:
        results = _experiment(given, folder)
        for condition in results["conditions"]:
            say(_line(condition))
        for world, failed in results.get("calibration", {}).get("not_calibrated", {}).items():
            for seed, why in failed.items():
                say(f"{world}, seed {seed} is not calibrated: {why}")
    say(f"the report is {folder / 'report.html'}")
    return 0


def worlds_from_options(given: Given, config: Config) -> tuple[str, ...]:
    """Return the worlds of the command line, or the default ones that this machine can simulate.

    Raises:
        PackageError: the configuration names an engine that is not installed.
    """
    named = tuple(dict.fromkeys(given.get("world", ())))
    if named:
        return named
    _, missing = resolve_robot(replace(config, robot="auto"))
    if missing:
        say(f"In the kinematic world, without forces: {missing}")
        return ("kinematic",)
    return ("sim", "as-real")


def _experiment(given: Given, folder: Path) -> dict[str, Any]:
    named = ("first_seed", "seeds", "laps")
    options: dict[str, Any] = {name: given[name] for name in named if name in given}
    if "offset" in given:
        options["offset"] = tuple(given["offset"])
    if "calibrate" in given:
        options["calibrate"] = given["calibrate"]
    config = config_of(given)
    experiment = Experiment(config, worlds_from_options(given, config), **options)
    crew = workers_from_options(given)
    try:
        return evaluate(experiment, crew, folder)
    finally:
        crew.close()


def _line(condition: dict[str, Any]) -> str:
    given = "known start" if condition["offset"] is None else "wrong start"
    ate = {name: item["ate_rmse_m"]["mean"] for name, item in condition["methods"].items()}
    after = condition["convergence"]
    median = after["seconds"]["median"]
    return (
        f"{condition['world']}, {given}: "
        f"odometry {millimetres(ate['odometry'])}, AMCL {millimetres(ate['amcl'])}; "
        f"{after['converged']} of {after['of']} right, after {seconds(median)}; "
        f"{after['right_to_the_end']} right to the end, {after['lost_again']} lost again; "
        f"once right {millimetres(after['steady_ate_rmse_m']['mean'])}"
    )
