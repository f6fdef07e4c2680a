"""Figures of the models' statistics, as SVG."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Ellipse
from scipy.stats import chi2

from app.lab.evaluation.report.figures import drawn
from app.lab.model_fits.motion.held import Held
from app.lab.model_fits.sensor_statistics import SensorStatistics
from app.lab.model_fits.trials.spread import EndSpread
from robot.geometry import Array

AS_SET, FITTED = "#d55e00", "#0072b2"
"""Colours of Okabe and Ito; dashed and full besides."""
MM = 1e3


def motion_ends(ends: Sequence[tuple[EndSpread, EndSpread]]) -> str:
    """True ends seen from odometry's, along and across, and where the model says that they are."""
    done: list[str] = []
    columns = 4
    rows = -(-len(ends) // columns)
    with drawn(2.3 * columns, 2.3 * rows + 0.4, done) as figure:
        grid: Any = figure.subplots(rows, columns, squeeze=False)
        for axes in grid.flat[len(ends) :]:
            axes.set_axis_off()
        for axes, (before, after) in zip(grid.flat, ends, strict=False):
            for spread, mark, colour, dashes, name in (
                (before, "x", AS_SET, "--", "as set"),
                (after, ".", FITTED, "-", "corrected and fitted"),
            ):
                x, y = MM * spread.errors[:, :2].T
                axes.plot(x, y, mark, color=colour, ms=4, alpha=0.7, label=name)
                axes.add_patch(_ellipse(MM**2 * spread.predicted[:2, :2], colour, dashes))
            axes.plot(0, 0, "+", color="black", ms=8)
            axes.set_title(before.motion.replace("_", " "))
            axes.autoscale_view()
            axes.tick_params(labelsize=7)
        figure.supxlabel("along [mm]")
        figure.supylabel("across [mm]")
        handles, labels = grid[0][0].get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside upper center", ncols=2, frameon=False)
    return done[0]


def range_errors(sensor: SensorStatistics) -> str:
    """Bias and spread, misses and false returns by distance; correlation by lag."""
    done: list[str] = []
    with drawn(9.2, 2.8, done) as figure:
        spread, shares, lags = figure.subplots(1, 3)
        bins = [one for one in sensor.distances if one.count > 1]
        middle = np.array([(one.low + one.high) / 2 for one in bins])
        bias = MM * np.array([one.bias for one in bins])
        sd = MM * np.array([one.sd for one in bins])
        robust = MM * np.array([one.robust_sd for one in bins])
        spread.errorbar(middle, bias, sd, fmt="o", color=FITTED, ms=4, label="mean, sd")
        spread.plot(middle, robust, "--", color=AS_SET, label="sd without the worst")
        spread.set(xlabel="exact range [m]", ylabel="error of a range [mm]")
        _shares(shares, middle, [one.missed for one in bins], FITTED, "-o", "missed")
        _shares(shares, middle, [one.false for one in bins], AS_SET, "--x", "false")
        shares.set(xlabel="range [m]", ylabel="share [%]", ylim=(0, None))
        correlation = sensor.correlation
        lags.plot(correlation.by_ray[:40], "-", color=FITTED, label="rays apart")
        lags.plot(correlation.by_scan[:40], "--", color=AS_SET, label="scans apart")
        lags.axhline(0, color="black", lw=0.6)
        lags.set(xlabel="apart by", ylabel="correlation of errors")
        for axes in (spread, shares, lags):
            axes.grid(alpha=0.3)
            axes.legend(frameon=False)
    return done[0]


def regions_held(held: Sequence[Held]) -> str:
    """What the 95 % regions held of drives that they were not fitted to."""
    done: list[str] = []
    with drawn(4.6, 2.8, done) as figure:
        axes = figure.add_subplot()
        places = np.arange(len(held))
        axes.axhline(95, color="#888888", lw=1, label="95 %")
        shares = np.array([one.share for one in held])
        low, high = np.array([one.interval for one in held]).T
        off = 100 * np.maximum([shares - low, high - shares], 0)
        axes.errorbar(places, 100 * shares, off, fmt="o", color=FITTED, capsize=3)
        axes.set_xticks(places, [f"{one.region.horizon:g} s" for one in held])
        axes.set(
            ylabel="held [%]",
            ylim=(min(80, 100 * float(low.min()) - 2), 100.5),
            xlim=(-0.5, len(held) - 0.5),
        )
        axes.legend(frameon=False)
    return done[0]


def _shares(
    axes: Axes, at: Array, shares: Sequence[float], colour: str, form: str, name: str
) -> None:
    axes.plot(at, [100 * one for one in shares], form, color=colour, ms=4, label=name)


def _ellipse(covariance: Array, colour: str, dashes: str) -> Ellipse:
    """What holds 95 % of a normal distribution in the plane."""
    values, axes = np.linalg.eigh(covariance)
    width, height = 2 * np.sqrt(np.maximum(values, 0) * chi2.ppf(0.95, 2))
    angle = float(np.degrees(np.arctan2(axes[1, 0], axes[0, 0])))
    return Ellipse(
        (0, 0), float(width), float(height), angle=angle, fill=False, ec=colour, ls=dashes, lw=1.2
    )
