"""``brickpose evaluate integrity``: drives, judges, and writes what it found."""

from __future__ import annotations

from collections import defaultdict
from dataclasses import asdict
from pathlib import Path
from typing import Any

from app.console import say
from app.engine.robots import resolve_robot
from app.features.lab.evaluation.drives import EvaluationError
from app.features.lab.evaluation.integrity.experiment import (
    Failure,
    IntegrityExperiment,
    IntegrityRun,
    each_run,
    map_stem,
)
from app.features.lab.evaluation.integrity.integrity_report import IntegrityResults, report
from app.features.lab.evaluation.integrity.summary import Row, Stanford, summary_of
from app.features.lab.workers import Workers, workers_from_options
from app.options import config_file
from app.result_files import RESULTS, atomic_folder, write_json
from app.settings.config import Config
from app.settings.provenance import changed_settings, versions

OUT = Path("evaluation") / "integrity"
SEVERAL = {"map": "maps", "condition": "conditions", "start": "starts"}
SINGLE = ("first_seed", "seeds", "laps")


def evaluate_integrity(
    experiment: IntegrityExperiment, workers: Workers, folder: Path
) -> dict[str, Any]:
    """Run the experiment and write ``results.json``, ``report.html`` and ``runs/``.

    Args:
        experiment: the robots, fields, conditions and starts.
        workers: the processes that do the work.
        folder: where the results go; created if it does not exist.

    Returns:
        The content of ``results.json``; the same for the same seeds, with any workers.

    Raises:
        EvaluationError: no drive could be followed.
        OSError: the folder cannot be written.
    """
    with atomic_folder(folder) as new:
        rows: list[Row] = []
        diagrams: defaultdict[str, Stanford] = defaultdict(Stanford.empty)
        failures: list[Failure] = []
        for run in each_run(experiment.jobs(), workers):
            if isinstance(run, Failure):
                failures.append(run)
                continue
            _write_run(new, run)
            rows.append(run.row)
            diagrams[run.row["condition"]] += run.stanford
        if not rows:
            raise EvaluationError(f"no drive could be followed: {failures[0].error}")
        rows = _in_order(rows, experiment)
        results = _results(experiment, rows, failures)
        shown = IntegrityResults(experiment, results, dict(diagrams), new)
        (new / "report.html").write_text(report(shown), encoding="utf-8")
        write_json(new / RESULTS, results)
    return results


def run_path(row: Row) -> str:
    """Return the path of a robot's claims in the folder."""
    return f"runs/{row['map']}-{row['condition']}-{row['start']}/{row['seed']}.csv"


def _results(
    experiment: IntegrityExperiment, rows: list[Row], failures: list[Failure]
) -> dict[str, Any]:
    return {
        "experiment": {
            "maps": list(experiment.maps),
            "conditions": list(experiment.conditions),
            "starts": list(experiment.starts),
            "first_seed": experiment.first_seed,
            "seeds": experiment.seeds,
            "laps": experiment.laps,
            "engine": experiment.engine,
            "settings": changed_settings(experiment.config),
            "versions": versions(),
        },
        "runs": rows,
        "failures": [asdict(failure) for failure in failures],
        "summary": summary_of(rows),
    }


def _in_order(rows: list[Row], experiment: IntegrityExperiment) -> list[Row]:
    """Sort rows as the experiment lists them, not by when they were done."""
    conditions, starts = list(experiment.conditions), list(experiment.starts)
    maps = [map_stem(name) for name in experiment.maps]

    def place(row: Row) -> tuple[int, int, int, int]:
        where = maps.index(row["map"])
        return where, conditions.index(row["condition"]), starts.index(row["start"]), row["seed"]

    return sorted(rows, key=place)


def _write_run(folder: Path, run: IntegrityRun) -> None:
    path = folder / run_path(run.row)
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(run.csv, encoding="utf-8")


def integrity_command(given: dict[str, Any]) -> int:
    """Run the experiment."""
    folder = given.get("out", OUT)
    options: dict[str, Any] = {name: given[name] for name in SINGLE if name in given}
    for option, name in SEVERAL.items():
        if option in given:
            options[name] = tuple(dict.fromkeys(given[option]))
    experiment = IntegrityExperiment(_config(given), **options)
    crew: Workers = workers_from_options(given)
    try:
        results = evaluate_integrity(experiment, crew, folder)
    finally:
        crew.close()
    for group in results["summary"]["groups"]:
        say(_line(group))
    for result in results["failures"]:
        say(
            f"failed: seed {result['seed']} on {result['map']}, {result['condition']}: "
            f"{result['error']}"
        )
    say(f"the report is {folder / 'report.html'}")
    return 0


def _config(given: dict[str, Any]) -> Config:
    config = config_file(given)
    config, missing = resolve_robot(config)
    if missing:
        say(f"In the kinematic world, without forces: {missing}")
    return config


def _line(group: dict[str, Any]) -> str:
    drives = group["drives"]
    return (
        f"{group['condition']}, {group['start']}: misleading {100 * group['misleading']:.3f} %, "
        f"of the certain ones {100 * (group['misleading_of_certain'] or 0):.3f} %, "
        f"longest {group['misleading_longest_s']:.1f} s; sure {100 * group['sure']:.1f} %, "
        f"as given {100 * group['given']:.1f} %, "
        f"while right {100 * (group.get('sure_while_right') or 0):.1f} %; "
        f"lost again {group['lost_again_drives']}, "
        f"right to the end {group['right_to_the_end_drives']} of {drives}"
    )
