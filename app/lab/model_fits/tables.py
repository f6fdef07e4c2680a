"""Convert the models' statistics to the tables of ``results.json``."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import asdict
from typing import Any

import numpy as np

from app.lab.model_fits.likelihood import Interval
from app.lab.model_fits.motion_statistics import EndSpread, MotionStatistics
from app.lab.model_fits.sensor_statistics import SensorStatistics

Table = dict[str, Any]


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
                (f"alpha{place}" for place in range(1, 5)), alphas.alphas, alphas.intervals
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
