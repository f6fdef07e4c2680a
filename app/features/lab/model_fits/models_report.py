"""The report on the models: tables and a page."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import asdict
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from matplotlib.patches import Ellipse
from scipy.stats import chi2

from app.features.lab.model_fits.likelihood import Interval
from app.features.lab.model_fits.motion_statistics import EndSpread, MotionStatistics
from app.features.lab.model_fits.regions import Held
from app.features.lab.model_fits.sensor_statistics import SensorStatistics
from app.features.lab.report_page import BLUE, RED, page, svg_figure
from app.settings.config import Config
from app.settings.provenance import settings_of
from robot.geometry import Array

Table = dict[str, Any]
AS_SET, FITTED = RED, BLUE
"""The lines also differ: dashed and solid."""
MM = 1e3


def motion_table(motion: MotionStatistics) -> Table:
    """Return odometry's errors, the fitted values and their tests."""
    fit, alphas, squares = motion.fit, motion.fit.motion, motion.umbmark
    correction = fit.correction
    steady = correction.distance, correction.turn, correction.curvature
    table: Table = _plain(
        {
            "clock_offset_s": motion.clock_offset,
            "correction": _with_intervals(("distance", "turn", "curvature"), steady, fit.intervals),
            "multipliers": motion.multipliers._asdict(),
            "true_multipliers": motion.true._asdict() if motion.true else None,
            "alphas": _with_intervals(
                (f"alpha{index}" for index in range(1, 5)), alphas.alphas, alphas.intervals
            ),
            "step_s": alphas.step,
            "floor": {"xy_m": alphas.floor_xy, "theta_rad": alphas.floor_theta},
            "umbmark": squares
            and asdict(squares)
            | {"worst": squares.worst, "multipliers": squares.wheel_multipliers()._asdict()},
            "ends": [
                {"motion": as_set.motion, "runs": len(as_set.errors)}
                | _ends_table(as_set)
                | {"fitted": _ends_table(corrected)}
                for as_set, corrected in motion.ends
            ],
            "regions": [
                asdict(held.region)
                | {
                    "stretch": held.region.stretch,
                    "held": held.share,
                    "held_interval": held.interval,
                    "held_independent": held.independent,
                    "judgement": held.judgement,
                }
                for held in motion.held
            ],
        }
    )
    return table


def sensor_table(sensor: SensorStatistics) -> Table:
    """Return the errors of ranges and the fitted values."""
    values = asdict(sensor.fit.values)
    table: Table = _plain(
        {
            "rays": len(sensor.pairs),
            "all": asdict(sensor.all),
            "by_distance": [asdict(item) for item in sensor.distances],
            "by_bearing": [asdict(item) for item in sensor.bearings],
            "fit": _with_intervals(
                values, values.values(), [sensor.fit.intervals[item] for item in values]
            ),
            "iterations": sensor.fit.iterations,
            "converged": sensor.fit.converged,
            "usable": asdict(sensor.usable.values),
            "correlation": asdict(sensor.correlation),
        }
    )
    return table


def _with_intervals(
    names: Iterable[str], values: Iterable[float], intervals: Iterable[Interval]
) -> Table:
    return {
        name: {"value": value, "interval": interval}
        for name, value, interval in zip(names, values, intervals, strict=True)
    }


def _ends_table(ends: EndSpread) -> Table:
    return {
        "mean": ends.errors.mean(axis=0),
        "covariance": np.cov(ends.errors.T),
        "predicted": ends.predicted,
        "distance": float(ends.distances.mean()),
    }


def _plain(value: Any) -> Any:
    """Return a value made of lists and numbers for JSON; numbers that are not finite are None."""
    if isinstance(value, dict):
        return {name: _plain(item) for name, item in value.items()}
    if isinstance(value, np.ndarray):
        return _plain(value.tolist())
    if isinstance(value, list | tuple):
        return [_plain(item) for item in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


def models_report(
    results: dict[str, Any],
    motion: MotionStatistics,
    sensor: SensorStatistics | None,
    config: Config,
) -> str:
    """Return the page as HTML."""
    default = settings_of(config)
    return page(
        "models.html.jinja",
        experiment=results["experiment"],
        results=results,
        default={path: default[path] for path in results["fitted"]},
        ends=_motion_ends(motion.ends) if motion.ends else None,
        regions=_regions_held(motion.held) if motion.held else None,
        ranges=_range_errors(sensor) if sensor else None,
        settings=default,
    )


@svg_figure()
def _motion_ends(figure: Figure, ends: Sequence[tuple[EndSpread, EndSpread]]) -> None:
    """Draw the true ends seen from odometry's, along and across, with the model's ellipses."""
    columns = 4
    rows = -(-len(ends) // columns)
    figure.set_size_inches(2.3 * columns, 2.3 * rows + 0.4)
    grid: Any = figure.subplots(rows, columns, squeeze=False)
    for axes in grid.flat[len(ends) :]:
        axes.set_axis_off()
    for axes, (as_set, corrected) in zip(grid.flat, ends, strict=False):
        for spread, mark, colour, dashes, name in (
            (as_set, "x", AS_SET, "--", "as set"),
            (corrected, ".", FITTED, "-", "corrected and fitted"),
        ):
            x, y = MM * spread.errors[:, :2].T
            axes.plot(x, y, mark, color=colour, ms=4, alpha=0.7, label=name)
            axes.add_patch(_ellipse(MM**2 * spread.predicted[:2, :2], colour, dashes))
        axes.plot(0, 0, "+", color="black", ms=8)
        axes.set_title(as_set.motion.replace("_", " "))
        axes.autoscale_view()
        axes.tick_params(labelsize=7)
    figure.supxlabel("along [mm]")
    figure.supylabel("across [mm]")
    handles, labels = grid[0][0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside upper center", ncols=2, frameon=False)


@svg_figure(9.2, 2.8)
def _range_errors(figure: Figure, sensor: SensorStatistics) -> None:
    """Draw bias and spread, misses and false returns by distance, and correlation by lag."""
    spread, shares, lags = figure.subplots(1, 3)
    bins = [item for item in sensor.distances if item.count > 1]
    middle = [(item.low + item.high) / 2 for item in bins]
    bias, sd, robust = MM * np.array([(item.bias, item.sd, item.robust_sd) for item in bins]).T
    spread.errorbar(middle, bias, sd, fmt="o", color=FITTED, ms=4, label="mean, sd")
    spread.plot(middle, robust, "--", color=AS_SET, label="sd without the worst")
    spread.set(xlabel="exact range [m]", ylabel="error of a range [mm]")
    misses, false = 100 * np.array([(item.missed, item.false) for item in bins]).T
    shares.plot(middle, misses, "-o", color=FITTED, ms=4, label="missed")
    shares.plot(middle, false, "--x", color=AS_SET, ms=4, label="false")
    shares.set(xlabel="range [m]", ylabel="share [%]", ylim=(0, None))
    lags.plot(sensor.correlation.by_ray[:40], "-", color=FITTED, label="rays apart")
    lags.plot(sensor.correlation.by_scan[:40], "--", color=AS_SET, label="scans apart")
    lags.axhline(0, color="black", lw=0.6)
    lags.set(xlabel="apart by", ylabel="correlation of errors")
    for axes in (spread, shares, lags):
        axes.grid(alpha=0.3)
        axes.legend(frameon=False)


@svg_figure(4.6, 2.8)
def _regions_held(figure: Figure, held: Sequence[Held]) -> None:
    """Draw the shares that the 95 % regions held of drives that they were not fitted to."""
    axes = figure.add_subplot()
    places = np.arange(len(held))
    axes.axhline(95, color="#888888", lw=1, label="95 %")
    shares = np.array([item.share for item in held])
    low, high = np.array([item.interval for item in held]).T
    reach = 100 * np.maximum([shares - low, high - shares], 0)
    axes.errorbar(places, 100 * shares, reach, fmt="o", color=FITTED, capsize=3)
    axes.set_xticks(places, [f"{item.region.horizon:g} s" for item in held])
    bottom = min(80, 100 * float(low.min()) - 2)
    axes.set(ylabel="held [%]", ylim=(bottom, 100.5), xlim=(-0.5, len(held) - 0.5))
    axes.legend(frameon=False)


def _ellipse(covariance: Array, colour: str, dashes: str) -> Ellipse:
    """Return the ellipse that holds 95 % of a normal distribution in the plane."""
    values, axes = np.linalg.eigh(covariance)
    width, height = 2 * np.sqrt(np.maximum(values, 0) * chi2.ppf(0.95, 2))
    angle = float(np.degrees(np.arctan2(axes[1, 0], axes[0, 0])))
    return Ellipse(
        (0, 0), float(width), float(height), angle=angle, fill=False, ec=colour, ls=dashes, lw=1.2
    )
