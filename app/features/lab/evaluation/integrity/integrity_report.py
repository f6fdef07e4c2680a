"""The page on integrity, with all figures embedded, so that it opens without a network."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import LogNorm
from matplotlib.figure import Figure

from app.features.lab.evaluation.integrity.claims import STATE, read_numbers
from app.features.lab.evaluation.integrity.drives import CARRY_STAMP
from app.features.lab.evaluation.integrity.experiment import KIDNAPPED, IntegrityExperiment
from app.features.lab.evaluation.integrity.summary import (
    HEADING_BINS,
    NO_ALERT,
    PLACE_BINS,
    Row,
    Stanford,
    trade,
)
from app.features.lab.evaluation.runs import PLACE_XY, Mask
from app.features.lab.report_page import BLUE, GREEN, OKABE_ITO, ORANGE, RED, page, svg_figure
from app.settings.provenance import settings_of
from robot.geometry import Array
from robot.localization.estimate import Cause, State
from robot.localization.monitoring.claims import NARROW

COLUMNS = 3
"""Number of columns of small diagrams."""
TEMPLATE = "integrity.html.jinja"
WORST = 12
"""Number of runs that are listed as the worst; half of them have a plot."""


@svg_figure(4.8, 4.4)
def stanford_diagram(
    figure: Figure, counts: Array, bins: Array, unit: str, scale: float, quantity: str
) -> None:
    """Draw error against bound of all pictures that claim one place; logarithmic.

    Args:
        counts: (k, k) pictures by error and bound.
        bins: (k + 1,) borders of the bins.
        scale: factor from the bins' unit to the unit that is shown.
        quantity: whose error it is: "place" or "heading".
    """
    axes = figure.add_subplot()
    mesh = _diagram(axes, counts, scale * bins, quantity == "place")
    axes.set(xlabel=f"error of the {quantity} [{unit}]", ylabel=f"claimed bound [{unit}]")
    _name_regions(axes, scale * bins)
    if mesh is not None:
        figure.colorbar(mesh, ax=axes, label="pictures", shrink=0.8)


@svg_figure()
def condition_diagrams(figure: Figure, diagrams: Mapping[str, Stanford]) -> None:
    """Draw a small diagram of the position for each condition."""
    rows = math.ceil(len(diagrams) / COLUMNS)
    figure.set_size_inches(2.5 * COLUMNS, 2.3 * rows + 0.4)
    grid: Any = figure.subplots(rows, COLUMNS, squeeze=False, sharex=True, sharey=True)
    for axes in grid.flat[len(diagrams) :]:
        axes.set_visible(False)
    for axes, (name, item) in zip(grid.flat, diagrams.items(), strict=False):
        _diagram(axes, item.place, 1e3 * PLACE_BINS, True)
        axes.set_title(name)
    figure.supxlabel("error [mm]", fontsize=9)
    figure.supylabel("claimed bound [mm]", fontsize=9)


@svg_figure(5.6, 3.2)
def trade_curve(figure: Figure, diagrams: Mapping[str, Stanford]) -> None:
    """Draw the pictures that claim a radius below a limit, against those outside their radius."""
    axes = figure.add_subplot()
    for index, (name, item) in enumerate(diagrams.items()):
        pictures = int(item.place.sum()) + item.unavailable
        available, outside = trade(item, pictures)
        dashes = ("-", "--", ":")[index // len(OKABE_ITO) % 3]
        axes.plot(
            100 * outside, 100 * available, dashes, lw=1.3, label=name,
            color=OKABE_ITO[index % len(OKABE_ITO)],
        )  # fmt: skip
    axes.set(xlabel="truth outside of the bound [%]", ylabel="bound below the limit [%]")
    axes.set_xlim(left=0)
    axes.grid(alpha=0.3)
    figure.legend(loc="outside right upper", frameon=False, fontsize=7)


@svg_figure(5.6, 2.0)
def drive_plot(
    figure: Figure, numbers: Mapping[str, Array], certain: Mask, carry_stamp: float | None
) -> None:
    """Draw error and bound of one drive over time, and mark where it is misleading."""
    offset = 1e3 * np.hypot(numbers["x"] - numbers["true_x"], numbers["y"] - numbers["true_y"])
    bound = 1e3 * np.where(np.isfinite(numbers["radius"]), numbers["radius"], np.nan)
    stamps = numbers["stamp"]
    axes = figure.add_subplot()
    axes.plot(stamps, np.maximum(offset, 0.05), color=BLUE, lw=1.2, label="error")
    axes.plot(stamps, bound, "--", color=ORANGE, lw=1.2, label="bound")
    bad = certain & (offset > np.nan_to_num(bound, nan=np.inf))
    axes.plot(stamps[bad], offset[bad], ".", color=RED, ms=4, label="misleading")
    axes.fill_between(
        stamps, 0, 1, where=certain, transform=axes.get_xaxis_transform(),
        color=GREEN, alpha=0.12, lw=0, label="says certain",
    )  # fmt: skip
    axes.axhline(1e3 * PLACE_XY, color="#888888", lw=0.7)
    if carry_stamp is not None:
        axes.axvline(carry_stamp, color="#888888", lw=0.7, ls=":")
    axes.set(yscale="log", xlabel="time [s]", ylabel="[mm]")
    figure.legend(frameon=False, ncols=4, fontsize=7, loc="outside upper center")


def _diagram(axes: Axes, counts: Array, borders: Array, is_place: bool) -> Any:
    """Draw the counts in colours over the diagonal; return None if there are no counts."""
    low, high = float(borders[0]), float(borders[-1])
    axes.fill_between([low, high], [low, low], [low, high], color=RED, alpha=0.12, lw=0)
    axes.plot([low, high], [low, high], color=RED, lw=1)
    if is_place:
        axes.axhline(1e3 * NARROW, color="#888888", lw=0.7, ls="--")
    mesh = None
    if counts.any():
        shown = np.ma.masked_equal(counts.T, 0)
        norm = LogNorm(1, max(float(counts.max()), 10.0))
        mesh = axes.pcolormesh(borders, borders, shown, norm=norm, cmap="viridis", rasterized=True)
    axes.set(xscale="log", yscale="log", xlim=(low, high), ylim=(low, high), aspect="equal")
    return mesh


def _name_regions(axes: Axes, borders: Array) -> None:
    low, high = np.log10(borders[0]), np.log10(borders[-1])

    def quantile(share: float) -> float:
        return float(10 ** (low + share * (high - low)))

    axes.text(quantile(0.97), quantile(0.10), "misleading where certain", color=RED, ha="right")
    axes.text(quantile(0.03), quantile(0.93), "the bound holds", color="#444444")


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
        place=stanford_diagram(whole.place, PLACE_BINS, "mm", 1e3, "place"),
        heading=stanford_diagram(
            whole.heading, HEADING_BINS, "degrees", math.degrees(1.0), "heading"
        ),
        panels=condition_diagrams(ordered),
        trade=trade_curve(ordered),
        unavailable=whole.unavailable,
        worst=[_worst_row(shown.folder, row, index < WORST / 2) for index, row in enumerate(worst)],
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
    carry_stamp = CARRY_STAMP if row["start"] in KIDNAPPED else None
    plot = None
    if is_plotted:
        numbers = read_numbers(folder / path)
        certain = _certain(folder / path)
        plot = drive_plot(numbers, certain, carry_stamp)
    return row | {"path": path, "plot": plot}


def _certain(path: Path) -> Mask:
    states = np.loadtxt(path, delimiter=",", skiprows=1, usecols=[STATE], dtype=str, ndmin=1)
    certain: Mask = states == str(State.CERTAIN)
    return certain
