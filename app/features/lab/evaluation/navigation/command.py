"""``brickpose evaluate navigation``: drives, and writes what it found."""

from __future__ import annotations

import csv
from dataclasses import asdict
from pathlib import Path
from typing import Any

from app.console import say
from app.engine.robots import resolve_robot
from app.features.lab.evaluation.drives import EvaluationError
from app.features.lab.evaluation.integrity.experiment import Failure
from app.features.lab.evaluation.navigation.experiment import (
    NavigationExperiment,
    each_robot,
    summary_of,
)
from app.features.lab.evaluation.navigation.trials import COLUMNS, NavigationRun, Row
from app.features.lab.report_page import page
from app.features.lab.workers import Workers, workers_from_options
from app.options import config_file
from app.result_files import RESULTS, atomic_folder, write_json
from app.settings.config import Config
from app.settings.provenance import changed_settings, settings_of, versions

OUT = Path("evaluation") / "navigation"
TEMPLATE = "navigation.html.jinja"
SEVERAL = {"map": "maps", "condition": "conditions", "trial": "trials"}
SINGLE = ("first_seed", "seeds", "goals", "minutes", "calibrate")
WORST = 12
"""Number of journeys that are listed as the worst."""


def evaluate_navigation(
    experiment: NavigationExperiment, workers: Workers, folder: Path
) -> dict[str, Any]:
    """Run the experiment and write ``results.json``, ``report.html`` and ``runs/``.

    Args:
        experiment: the robots, fields, conditions and trials.
        workers: the processes that do the work.
        folder: where the results go; created if it does not exist.

    Returns:
        The content of ``results.json``; the same for the same seeds, with any workers.

    Raises:
        EvaluationError: no robot could drive.
        OSError: the folder cannot be written.
    """
    with atomic_folder(folder) as new:
        rows: list[Row] = []
        failures: list[Failure] = []
        for each in each_robot(experiment.jobs(), workers):
            if isinstance(each, Failure):
                failures.append(each)
            else:
                rows.extend(each.rows)
                _write_run(new, experiment, each)
        if not rows:
            raise EvaluationError(f"no robot could drive: {failures[0].error}")
        results = _results(experiment, _in_order(rows, experiment), failures)
        (new / "report.html").write_text(_report(experiment, results), encoding="utf-8")
        write_json(new / RESULTS, results)
    return results


def _write_run(folder: Path, experiment: NavigationExperiment, run: NavigationRun) -> None:
    """Write a robot's ticks; only what there are several of is in the name of its file."""
    row = run.rows[0]
    name = row["map"]
    if len(experiment.conditions) > 1:
        name += f"-{row['condition']}"
    if len(experiment.trials) > 1:
        name += f"-{row['trial']}"
    path = folder / "runs" / f"{name}-{row['seed']}.csv"
    path.parent.mkdir(exist_ok=True)
    with path.open("w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(COLUMNS)
        writer.writerows(run.ticks)


def _results(
    experiment: NavigationExperiment, rows: list[Row], failures: list[Failure]
) -> dict[str, Any]:
    return {
        "experiment": {
            "maps": list(experiment.maps),
            "conditions": list(experiment.conditions),
            "trials": list(experiment.trials),
            "first_seed": experiment.first_seed,
            "seeds": experiment.seeds,
            "goals": experiment.goals,
            "minutes": experiment.minutes,
            "calibrate": experiment.calibrate,
            "engine": experiment.engine,
            "settings": changed_settings(experiment.config),
            "versions": versions(),
        },
        "journeys": rows,
        "failures": [asdict(failure) for failure in failures],
        "summary": summary_of(rows),
    }


def _in_order(rows: list[Row], experiment: NavigationExperiment) -> list[Row]:
    """Sort rows as the experiment lists them, not by when they were done."""
    maps = [Path(name).stem for name in experiment.maps]
    conditions, trials = list(experiment.conditions), list(experiment.trials)

    def place(row: Row) -> tuple[int, int, int, int, int]:
        where, how = maps.index(row["map"]), conditions.index(row["condition"])
        return where, how, trials.index(row["trial"]), row["seed"], row["number"]

    return sorted(rows, key=place)


def _report(experiment: NavigationExperiment, results: dict[str, Any]) -> str:
    arrived = [row for row in results["journeys"] if row["state"] == "arrived"]
    worst = sorted(arrived, key=lambda row: -max(row["error_m"] / 0.003, row["turn_rad"] / 0.017))
    curves = ("figure-eight", "open-loop")
    groups = results["summary"]
    return page(
        TEMPLATE,
        experiment=results["experiment"],
        failures=results["failures"],
        journeys=[group for group in groups if group["trial"] not in curves],
        curves=[group for group in groups if group["trial"] in curves],
        worst=worst[:WORST],
        settings=settings_of(experiment.config),
    )


def navigation_command(given: dict[str, Any]) -> int:
    """Run the experiment."""
    folder = given.get("out", OUT)
    options: dict[str, Any] = {name: given[name] for name in SINGLE if name in given}
    for option, name in SEVERAL.items():
        if option in given:
            options[name] = tuple(dict.fromkeys(given[option]))
    experiment = NavigationExperiment(_config(given), **options)
    crew: Workers = workers_from_options(given)
    try:
        results = evaluate_navigation(experiment, crew, folder)
    finally:
        crew.close()
    for group in results["summary"]:
        say(_line(group))
    for result in results["failures"]:
        say(
            f"failed: seed {result['seed']} on {result['map']}, {result['condition']}: "
            f"{result['error']}"
        )
    say(f"the report is {folder / 'report.html'}")
    return 0


def _config(given: dict[str, Any]) -> Config:
    config, missing = resolve_robot(config_file(given))
    if missing:
        say(f"In the kinematic world, without forces: {missing}")
    return config


def _line(group: dict[str, Any]) -> str:
    about = f"{group['map']}, {group['condition']}, {group['trial']}: "
    if group["least_room_m"] is None:
        return f"{about}no goal was found to which there is a way"
    tape = f"over tape {group['over_tape']}, least room {1000 * group['least_room_m']:.1f} mm"
    if "rms_m" in group:
        left = group["left_after_median_s"]
        return (
            f"{about}rms {1000 * group['rms_m']:.2f} mm (first minute "
            f"{1000 * group['first_minute_m']:.2f}, last {1000 * group['last_minute_m']:.2f}); "
            f"left the field {group['left_the_field']} of {group['robots']}"
            + (f", after {left:.0f} s; " if left else "; ")
            + tape
        )
    line = f"{about}reached {group['reached']} of {group['journeys']}; "
    if group["reached"]:
        line += (
            f"error {1000 * group['error_median_m']:.2f} mm median, "
            f"{1000 * group['error_worst_m']:.2f} worst; {group['turn_median_deg']:.2f} and "
            f"{group['turn_worst_deg']:.2f} degrees; time {group['over_fastest_median']:.2f} of "
            "the fastest; "
        )
    others = "".join(f"\n  {count} {reason}" for reason, count in group["not_reached"].items())
    return line + tape + others
