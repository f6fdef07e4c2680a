"""``brickpose evaluate``: runs the experiment and writes its folder of results."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from app.files import RESULTS, atomic_folder, write_json
from app.lab.evaluation.experiment import Experiment, run
from app.lab.evaluation.recorded import RUN
from app.lab.evaluation.report.report import Evaluation, figure3, report
from app.lab.evaluation.results import condition_table, trajectory
from app.lab.evaluation.runs import Run
from app.lab.evaluation.scores import SHOWN
from app.lab.trajectories.files.tum import write_tum
from app.lab.workers import Workers
from app.settings.config import MAPS
from app.settings.provenance import changed_settings, versions
from robot.fields.field_loading import load_field

WITHOUT, WITH = "known", "offset"


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
        conditions = {
            (world, given): [getattr(outcome, given) for outcome in outcomes]
            for world, outcomes in run(experiment, workers).items()
            for given in (WITHOUT, WITH)
        }
        results = results_of(experiment, conditions)
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
