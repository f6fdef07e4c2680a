"""The report of a drive: what it measured, along which path, and how well all of it fits."""

from __future__ import annotations

import math

import numpy as np
from matplotlib.figure import Figure

from app.features.lab.calibrate.calibrated_robot import CalibratedRobot
from app.features.lab.report_page import BLUE, GREY, RED, page, picture_frame, svg_figure
from robot.calibration.calibrate import LEARNT
from robot.description.unknowns import ROBOT, UNKNOWNS
from robot.geometry import Array

TEMPLATE = "drive.html.jinja"
LENGTHENED = 300.0
"""Errors are drawn this many times as long."""
CELL, LEAST_IN_CELL = 40, 20
"""Side of the picture's parts [px], and how many edges have to be seen in one."""
MOST_POINTS = 2000
"""Points that are drawn, of the edges that were seen."""


def drive_report(result: CalibratedRobot) -> str:
    """Return the report as HTML, with all figures in it."""
    calibration = result.calibration
    place = 1.96e3 * calibration.position_sd
    return page(
        TEMPLATE,
        robot=result.spec.name,
        source=result.source,
        place=None if math.isnan(place) else place,
        remarks=calibration.remarks,
        facts=calibration.quality.facts,
        advice=calibration.advice,
        rows=_rows(result),
        shares=_draw_shares(result),
        path=_draw_path(result),
        times=_draw_times(result),
        picture=_draw_picture(result),
        lengthened=LENGTHENED,
    )


def _rows(result: CalibratedRobot) -> list[dict[str, object]]:
    calibration = result.calibration
    return [
        {
            "name": unknown.name.replace("_", " "),
            "value": unknown.scale * calibration.values[index],
            "unit": unknown.unit,
            "interval": _rounded(1.96 * unknown.scale * calibration.sd[index]),
            "prior": _rounded(1.96 * unknown.scale * unknown.prior),
            "note": "not learnt" if unknown.name in calibration.not_learnt else "",
        }
        for index, unknown in enumerate(UNKNOWNS[: ROBOT + 1])
    ]


def _rounded(interval: float) -> str:
    """Format an interval with two digits or more."""
    return f"{interval:.{max(0, 1 - math.floor(math.log10(interval)))}f}"


@svg_figure(6.4, 2.8)
def _draw_shares(figure: Figure, result: CalibratedRobot) -> None:
    axes = figure.add_subplot()
    known = UNKNOWNS[:ROBOT]
    shares = [sd / unknown.prior for sd, unknown in zip(result.calibration.sd, known, strict=False)]
    names = [unknown.name.replace("_", " ") for unknown in known]
    axes.barh(names, shares, color=[RED if share > LEARNT else BLUE for share in shares])
    axes.axvline(LEARNT, color=GREY, lw=1, ls="--")
    axes.set(xscale="log", xlim=(5e-4, 1.2), xlabel="interval, as a share of the one before")
    axes.invert_yaxis()


@svg_figure(6.4, 6.0)
def _draw_path(figure: Figure, result: CalibratedRobot) -> None:
    axes = figure.add_subplot()
    edges = result.taped.edges
    axes.plot(edges[:, ::2].T, edges[:, 1::2].T, color=GREY, lw=1)
    seen = result.calibration.solution.misses.ends
    axes.plot(*seen[:: max(1, len(seen) // MOST_POINTS)].T, ".", color=BLUE, ms=2)
    poses = result.calibration.solution.state.poses
    axes.plot(*poses[:, :2].T, color=RED, lw=1.2)
    axes.plot(*poses[0, :2], "o", color=RED, ms=5)
    axes.annotate("start", (poses[0, 0], poses[0, 1]), xytext=(6, 6), textcoords="offset points")
    axes.set(aspect="equal", xlabel="x [m]", ylabel="y [m]")


@svg_figure(6.4, 4.0)
def _draw_times(figure: Figure, result: CalibratedRobot) -> None:
    above, below = figure.subplots(2, 1, sharex=True)
    state, seen = result.calibration.solution.state, result.calibration.solution.misses
    times = result.stamps - result.stamps[0]
    counts = np.bincount(seen.picture, minlength=len(times))
    squares = np.bincount(seen.picture, seen.residuals**2, minlength=len(times))
    some = counts > 0
    above.plot(times[some], np.sqrt(squares[some] / counts[some]), ".", color=BLUE, ms=3)
    above.set(ylabel="errors of edges [sd]", ylim=(0, None))
    for slip, colour, name in zip(state.slip.T, (BLUE, RED), ("left", "right"), strict=True):
        below.plot(times, 100 * slip, color=colour, lw=1, label=name)
    below.set(xlabel="time [s]", ylabel="slip [%]")
    below.legend(frameon=False, ncols=2)


@svg_figure(6.4, 5.0)
def _draw_picture(figure: Figure, result: CalibratedRobot) -> None:
    axes = picture_frame(figure, result.spec.lens)
    places, errors = mean_errors(result)
    arrows = axes.quiver(
        *places.T, *errors.T, angles="xy", scale_units="xy", scale=1 / LENGTHENED,
        width=0.003, color=BLUE,
    )  # fmt: skip
    axes.quiverkey(arrows, 0.85, 0.06, 0.1, "0.1 px")


def mean_errors(result: CalibratedRobot) -> tuple[Array, Array]:
    """Return the middles (n, 2) of parts of the picture, and the mean error (n, 2) in each [px]."""
    seen = result.calibration.solution.misses
    # Only the error across an edge is seen.
    size = np.square(seen.by_pixel).sum(axis=1, keepdims=True)
    errors = seen.residuals[:, None] * seen.by_pixel / size
    cells, cell = np.unique(seen.seen_at // CELL, axis=0, return_inverse=True)
    counts = np.bincount(cell.ravel())
    sums = np.column_stack([np.bincount(cell.ravel(), part) for part in errors.T])
    some = counts >= LEAST_IN_CELL
    return (cells[some] + 0.5) * CELL, sums[some] / counts[some, None]
