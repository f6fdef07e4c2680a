"""The report: one page with all figures embedded, so that it opens without a network."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import cv2
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from app.features.lab.evaluation.experiment import Experiment
from app.features.lab.evaluation.results import METHODS, poses_of
from app.features.lab.evaluation.runs import Run, errors
from app.features.lab.report_page import RED, SKY, STROKES, LineStyle, page, svg_figure
from app.settings.provenance import settings_of
from app.trajectories.trajectory import Trajectory
from robot.fields.field import Field
from robot.geometry import Array

TEMPLATE = "report.html.jinja"
STARTS = {"known": "known start", "offset": "wrong start"}

PAPER = {
    ("sim", "known", "amcl"): "9.6 mm",
    ("sim", "known", "odometry"): "above 50 mm",
    ("sim", "offset", "amcl"): "recovers",
}
"""Results that "ROS with LEGO Spike" reports, by world, start and method."""
LEAST_MM = 0.02
"""Smaller errors are not drawn: the error of odometry begins at zero."""
FLOOR_PX = 400
"""Longest side of the floor's picture [px]."""


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
    return paths(evaluation.field, panels)


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
        spans=[f"over {span}" for span in next(iter(titled.values()))["methods"]["amcl"]["rpe"]],
        figure3=figure3(evaluation),
        over_time=errors_over_time(over_time),
        boxes=boxes(ate, "absolute error, rms [mm]"),
        settings=settings_of(evaluation.experiment.config),
    )


def _title(world: str, given: str) -> str:
    return f"{world}, {STARTS[given]}"


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


@svg_figure()
def paths(figure: Figure, field: Field, panels: dict[str, Run]) -> None:
    """Draw truth, odometry and estimate over the tape, one titled panel for each run (Fig. 3)."""
    columns = min(len(panels), 2)
    rows = -(-len(panels) // columns)
    figure.set_size_inches(3.6 * columns, 3.9 * rows + 0.6)
    grid: Any = figure.subplots(rows, columns, squeeze=False, sharex=True, sharey=True)
    for axes, (title, run) in zip(grid.flat, panels.items(), strict=False):
        _floor(axes, field)
        for method, stroke in STROKES.items():
            stroke.draw(axes, poses_of(run, method))
        axes.set(title=title, aspect="equal")
        axes.tick_params(labelsize=8)
    for axes in grid[-1]:
        axes.set_xlabel("x [m]")
    for row in grid:
        row[0].set_ylabel("y [m]")
    handles, labels = grid[0][0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside upper center", ncols=3, frameon=False)


@svg_figure()
def errors_over_time(figure: Figure, conditions: Mapping[str, Sequence[Run]]) -> None:
    """Draw the distance from the truth over time: median and range (min to max) of the robots."""
    figure.set_size_inches(7.2, 2.1 * len(conditions) + 0.5)
    grid: Any = figure.subplots(len(conditions), 1, squeeze=False, sharex=True)
    for axes, (title, runs) in zip(grid.flat, conditions.items(), strict=True):
        for method in METHODS:
            stroke = STROKES[method]
            offset = 1e3 * np.array([errors(run, poses_of(run, method))[0] for run in runs])
            stamps = runs[0].stamps
            axes.plot(
                stamps, np.median(offset, axis=0), stroke.dashes, color=stroke.colour, lw=1.4,
                label=f"{stroke.label}, median",
            )  # fmt: skip
            axes.fill_between(
                stamps,
                offset.min(axis=0),
                offset.max(axis=0),
                color=stroke.colour,
                alpha=0.2,
                lw=0,
            )
        axes.set(title=title, yscale="log", ylabel="error [mm]")
        axes.set_ylim(bottom=LEAST_MM)
        axes.grid(alpha=0.3)
    grid[-1][0].set_xlabel("time [s]")
    handles, labels = grid[0][0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside upper center", ncols=2, frameon=False)


@svg_figure(7.2, 2.9)
def boxes(figure: Figure, conditions: dict[str, dict[str, Sequence[float]]], label: str) -> None:
    """Draw boxes by condition and method, with a point for each robot [mm]; logarithmic."""
    axes = figure.add_subplot()
    places = np.arange(len(conditions))
    for shift, method in zip((-0.18, 0.18), METHODS, strict=True):
        stroke = STROKES[method]
        values = [[1e3 * v for v in condition[method]] for condition in conditions.values()]
        where = places + shift
        box = axes.boxplot(
            values, positions=where, widths=0.28, showfliers=False, manage_ticks=False,
            patch_artist=True, label=stroke.label,
        )  # fmt: skip
        for patch in box["boxes"]:
            patch.set(facecolor=stroke.colour, alpha=0.35)
        for place, each in zip(where, values, strict=True):
            beside = np.linspace(-0.1, 0.1, len(each)) if len(each) > 1 else [0.0]
            axes.plot(place + np.asarray(beside), each, ".", color=stroke.colour, ms=4)
    axes.set(yscale="log", ylabel=label, xticks=places, xticklabels=list(conditions))
    axes.grid(axis="y", alpha=0.3)
    axes.legend(frameon=False)


def _floor(axes: Axes, field: Field) -> None:
    """Draw the floor's picture, pale enough for lines on top of it."""
    image = field.floor.image
    shrink = min(1.0, FLOOR_PX / max(image.shape))
    small = cv2.resize(image, None, fx=shrink, fy=shrink, interpolation=cv2.INTER_AREA)
    xmin, ymin, xmax, ymax = field.floor.extent
    axes.imshow(
        small, cmap="gray", vmin=-500, vmax=255, extent=(xmin, xmax, ymin, ymax), aspect="equal"
    )


@svg_figure(6, 5.4)
def recorded_paths(
    figure: Figure, truth: Trajectory, estimate: Trajectory, aligned: Trajectory
) -> None:
    """Draw a recording from above: truth, and the estimate before and after alignment."""
    strokes = (
        (truth, STROKES["truth"]),
        (estimate, LineStyle("estimate as it is", RED, "--", 1.0)),
        (aligned, LineStyle("estimate, aligned", SKY, "-", 1.1)),
    )
    axes = figure.add_subplot()
    for trajectory, stroke in strokes:
        stroke.draw(axes, trajectory.positions)
    axes.set(aspect="equal", xlabel="x [m]", ylabel="y [m]")
    figure.legend(loc="outside upper center", ncols=3, frameon=False)


@svg_figure(7.2, 2.4)
def recorded_errors(figure: Figure, stamps: Array, errors: dict[str, Array]) -> None:
    """Draw distances [m] from the truth over time [s], one line for each name."""
    axes = figure.add_subplot()
    for (name, each), dashes, colour in zip(errors.items(), ("--", "-"), (RED, SKY), strict=True):
        axes.plot(stamps, 1e3 * each, dashes, color=colour, lw=1.1, label=name)
    axes.set(xlabel="time [s]", ylabel="error [mm]", ylim=(0, None))
    axes.grid(alpha=0.3)
    axes.legend(frameon=False, ncols=2)
