"""The page on integrity, with all figures embedded, so that it opens without a network."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from app.lab.evaluation.convergence import Mask
from app.lab.evaluation.integrity.claims_file import STATE, read_numbers
from app.lab.evaluation.integrity.drives import CARRY_STAMP
from app.lab.evaluation.integrity.experiment import CARRIED, IntegrityExperiment
from app.lab.evaluation.integrity.report import stanford_figures
from app.lab.evaluation.integrity.stanford import Stanford
from app.lab.evaluation.integrity.summary import NO_ALERT, Row
from app.lab.evaluation.report.report import embedded, page
from app.settings.provenance import settings_of
from robot.localization.integrity import Cause, State

TEMPLATE = "integrity.html.jinja"
WORST = 12
"""Number of runs that are listed as the worst; half of them have a plot."""


@dataclass(frozen=True)
class IntegrityResults:
    """Everything that the report shows."""

    experiment: IntegrityExperiment
    results: dict[str, Any]
    diagrams: dict[str, Stanford]
    """By condition."""
    folder: Path
    """The folder of the runs."""


def report(shown: IntegrityResults) -> str:
    """Return the page as HTML."""
    results = shown.results
    whole = sum(shown.diagrams.values(), Stanford.empty())
    conditions = shown.experiment.conditions
    ordered = {name: shown.diagrams[name] for name in conditions if name in shown.diagrams}
    worst = worst_runs(results["runs"])
    return page(
        TEMPLATE,
        experiment=results["experiment"],
        summary=results["summary"],
        failures=results["failures"],
        groups=results["summary"]["groups"],
        causes=results["summary"]["causes"],
        cause_names=[*map(str, Cause), NO_ALERT],
        place=embedded(stanford_figures.place_diagram(whole)),
        heading=embedded(stanford_figures.heading_diagram(whole)),
        panels=embedded(stanford_figures.condition_diagrams(ordered)),
        trade=embedded(stanford_figures.trade_curve(ordered)),
        unavailable=whole.unavailable,
        worst=[_worst_row(shown.folder, row, place < WORST / 2) for place, row in enumerate(worst)],
        settings=settings_of(shown.experiment.config),
        percent=percent,
    )


def percent(value: float | None, digits: int = 1) -> str:
    """Format a share as a percentage with some digits behind the point."""
    return "-" if value is None else f"{100 * value:.{digits}f} %"


def worst_runs(rows: list[Row]) -> list[Row]:
    """Return the runs to look at first.

    They are sorted by the longest misleading time, then lost again, not right to the end and the
    share of misleading pictures; runs without any of these follow by error.
    """
    bad = [row for row in rows if _badness(row) > (0.0, 0, 0, 0.0)]
    far = [row for row in rows if row["ate_rmse_m"] is not None]
    far.sort(key=lambda row: -row["ate_rmse_m"])
    some = sorted(bad, key=_badness, reverse=True)
    return (some + [row for row in far if row not in some])[:WORST]


def _badness(row: Row) -> tuple[float, int, int, float]:
    return (
        row["misleading_longest_s"],
        int(row["lost_again"]),
        int(not row["right_to_the_end"]),
        row["misleading"],
    )


def _worst_row(folder: Path, row: Row, is_plotted: bool) -> Row:
    path = f"runs/{row['map']}-{row['condition']}-{row['start']}/{row['seed']}.csv"
    carry_stamp = CARRY_STAMP if row["start"] == CARRIED else None
    plot = None
    if is_plotted:
        numbers = read_numbers(folder / path)
        certain = _certain(folder / path)
        plot = embedded(stanford_figures.drive_plot(numbers, certain, carry_stamp))
    return row | {"path": path, "plot": plot}


def _certain(path: Path) -> Mask:
    states = np.loadtxt(path, delimiter=",", skiprows=1, usecols=[STATE], dtype=str, ndmin=1)
    certain: Mask = states == str(State.CERTAIN)
    return certain
