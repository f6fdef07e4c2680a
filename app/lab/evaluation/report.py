"""The report: one page with all figures embedded, so that it opens without a network."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from app.lab.evaluation import figures
from app.lab.evaluation.experiment import Experiment
from app.lab.evaluation.results import METHODS
from app.lab.evaluation.runs import Run
from app.lab.report_page import STROKES, embedded, page
from app.settings.provenance import settings_of
from robot.fields.field import Field

TEMPLATE = "report.html.jinja"
TOLD = {"known": "start known", "offset": "start told wrong"}

PAPER = {
    ("sim", "known", "amcl"): "9.6 mm",
    ("sim", "known", "odometry"): "above 50 mm",
    ("sim", "offset", "amcl"): "recovers",
}
"""Results that "ROS with LEGO Spike" reports, by world, start and method."""


@dataclass(frozen=True)
class Evaluation:
    """Everything that a report shows."""

    experiment: Experiment
    field: Field
    conditions: dict[tuple[str, str], list[Run]]
    """Runs by world and start ("known" or "offset"), in the order of the seeds."""
    results: dict[str, Any]


def figure3(evaluation: Evaluation) -> str:
    """Draw the paper's figure 3 for the first robot, as SVG."""
    seed = evaluation.experiment.first_seed
    panels = {
        f"{_title(*key)} (seed {seed})": runs[0] for key, runs in evaluation.conditions.items()
    }
    return figures.paths(evaluation.field, panels)


def report(evaluation: Evaluation) -> str:
    """Return the report as HTML."""
    tables = dict(zip(evaluation.conditions, evaluation.results["conditions"], strict=True))
    titled = {_title(*key): table for key, table in tables.items()}
    ate = {
        title: {method: _each(table, method) for method in METHODS}
        for title, table in titled.items()
    }
    over_time = {_title(*key): runs for key, runs in evaluation.conditions.items()}
    return page(
        TEMPLATE,
        experiment=evaluation.results["experiment"],
        rows=[_row(key, table, method) for key, table in tables.items() for method in METHODS],
        conditions=titled,
        methods=METHODS,
        figure3=embedded(figure3(evaluation)),
        over_time=embedded(figures.errors_over_time(over_time)),
        boxes=embedded(figures.boxes(ate, "absolute error, rms [mm]")),
        settings=settings_of(evaluation.experiment.config),
    )


def _title(world: str, given: str) -> str:
    return f"{world}, {TOLD[given]}"


def _each(table: dict[str, Any], method: str) -> Sequence[float]:
    result: list[float] = table["methods"][method]["ate_rmse_m"]["per_seed"]
    return result


def _row(key: tuple[str, str], table: dict[str, Any], method: str) -> dict[str, Any]:
    return {
        "title": _title(*key),
        "method": STROKES[method].label,
        "paper": PAPER.get((*key, method), "-"),
        "ate": table["methods"][method]["ate_rmse_m"],
        "aligned": table["methods"][method]["ate_aligned_rmse_m"],
        "heading": table["methods"][method]["heading_rmse_rad"],
    }
