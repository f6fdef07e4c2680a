"""``brickpose evaluate models``: statistics, fitted parameters, and what they are worth."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from app.files import RESULTS, write_json, written_whole
from app.lab.evaluation.experiment import Experiment, run
from app.lab.evaluation.results import condition_table
from app.lab.model_fits.fit_error import FitError
from app.lab.model_fits.fitted_file import clipped, fitted_settings, toml_of
from app.lab.model_fits.motion.held import Held
from app.lab.model_fits.motion_statistics import MotionStatistics, recorded_motion, repeated_motions
from app.lab.model_fits.report.models_report import models_report
from app.lab.model_fits.sensor.range_statistics import RangeStatistics
from app.lab.model_fits.sensor_statistics import SensorStatistics, scanned_drives
from app.lab.model_fits.trials.spread import EndSpread
from app.lab.trajectories.clock_offset import require_same_run
from app.lab.trajectories.files.reading import read_trajectory
from app.lab.trajectories.trajectory import TrajectoryError
from app.lab.workers import Workers
from app.settings.config import Config, with_settings
from app.settings.provenance import changed_settings, versions

FITTED = "fitted.toml"

Table = dict[str, Any]


@dataclass(frozen=True)
class ModelsJob:
    """What is measured with one simulated robot."""

    config: Config
    world: str
    robot: int
    """Seed of its dimensions."""
    repeats: int
    """Of each motion."""
    seeds: int
    """Runs in which fitted and default settings are compared."""
    laps: int = 2
    """Of the figure-eight in each of them."""
    drives: int = 3
    """Of the figure-eight whose scans are compared with exact ones."""
    seconds: float = 32.0
    """How long each takes [s]."""


def evaluate_models(job: ModelsJob, workers: Workers, folder: Path) -> Table:
    """Measure one simulated robot; write ``results.json``, ``report.html``, ``fitted.toml``.

    Raises:
        EvaluationError, FitError: a drive cannot be made, or tells too little.
        OSError: the folder cannot be written.
    """
    one_robot = {"sim.imperfections.robot": job.robot, "seed": job.robot}
    config = with_settings(job.config, one_robot)
    with written_whole(folder) as new:
        motion = repeated_motions(config, job.world, job.repeats, workers)
        sensor = scanned_drives(config, job.world, job.drives, job.seconds, workers)
        settings = fitted_settings(motion, sensor, config)
        compared = _compared(config, settings, job, workers)
        about = {
            "world": job.world,
            "robot": job.robot,
            "map": config.map,
            "repeats": job.repeats,
            "seeds": job.seeds,
            "settings": changed_settings(config),
            "versions": versions(),
        }
        results = {
            "experiment": about,
            "motion": motion_table(motion),
            "sensor": sensor_table(sensor),
            "fitted": settings,
            "compared": compared,
        }
        comments: tuple[str, ...] = (
            f"Fitted to robot {job.robot} in the world {job.world} by brickpose evaluate models.",
            "Ranges spread by sigma_hit = "
            f"{sensor.fit.values.sigma_hit:.6f} m; a filter is set no narrower than here.",
        )
        # So that a simulated run has the robot that was measured.
        written = settings | {"sim.imperfections.robot": job.robot}
        (new / FITTED).write_text(
            toml_of(written, (*comments, *_told_of(clipped(motion, sensor, config)))),
            encoding="utf-8",
        )
        page = models_report(results, motion, sensor, config)
        (new / "report.html").write_text(page, encoding="utf-8")
        write_json(new / RESULTS, results)
    return results


def evaluate_recorded_models(
    recording: Path,
    truth: Path,
    folder: Path,
    body: str | None,
    clock: float | None,
    config: Config,
) -> Table:
    """The same of recorded odometry with truth, for what that tells: motion.

    Args:
        recording: odometry.
        truth: the true trajectory.
        folder: for ``results.json``, ``report.html`` and ``fitted.toml``.
        body: which rigid body of a Motive file.
        clock: what to add to odometry's stamps [s]; None estimates it.
        config: the robot's and the filter's settings.

    Raises:
        TrajectoryError: a file cannot be read, they are not of one run, or too little was driven;
            says what is needed.
        OSError: the folder cannot be written.
    """
    odometry, true = read_trajectory(recording), read_trajectory(truth, body)
    offset = require_same_run(true, odometry).seconds if clock is None else clock
    with written_whole(folder) as new:
        try:
            motion = recorded_motion(odometry, true, offset, config)
        except FitError as error:
            raise TrajectoryError(f"{odometry.name}: {error}") from error
        settings = fitted_settings(motion, None, config)
        results = {
            "experiment": {
                "recording": recording.name,
                "truth": truth.name,
                "clock_offset_s": offset,
                "settings": changed_settings(config),
                "versions": versions(),
            },
            "motion": motion_table(motion),
            "sensor": None,
            "fitted": settings,
            "compared": None,
        }
        comments: tuple[str, ...] = (
            f"Fitted to the first half of {recording.name} by brickpose evaluate models.",
        )
        (new / FITTED).write_text(
            toml_of(settings, (*comments, *_told_of(clipped(motion, None, config)))),
            encoding="utf-8",
        )
        page = models_report(results, motion, None, config)
        (new / "report.html").write_text(page, encoding="utf-8")
        write_json(new / RESULTS, results)
    return results


def _write(folder: Path, fitted: str, page: str) -> None:
    (folder / FITTED).write_text(fitted, encoding="utf-8")
    (folder / "report.html").write_text(page, encoding="utf-8")


def _told_of(beyond: dict[str, float]) -> tuple[str, ...]:
    """A comment for each value that was brought into its range."""
    return tuple(
        f"{path} was fitted as {value:.6g}, which it may not be." for path, value in beyond.items()
    )


def motion_table(motion: MotionStatistics) -> Table:
    """As in ``results.json``."""
    fit, alphas = motion.fit, motion.fit.motion
    return {
        "clock_offset_s": motion.clock_offset,
        "correction": {
            name: {"value": getattr(fit.correction, name), "interval": list(interval)}
            for name, interval in zip(("distance", "turn", "curvature"), fit.intervals, strict=True)
        },
        "multipliers": motion.multipliers._asdict(),
        "true_multipliers": motion.true._asdict() if motion.true else None,
        "alphas": {
            f"alpha{place}": {"value": value, "interval": [_finite(end) for end in interval]}
            for place, (value, interval) in enumerate(
                zip(alphas.alphas, alphas.intervals, strict=True), 1
            )
        },
        "step_s": alphas.step,
        "floor": {"xy_m": alphas.floor_xy, "theta_rad": alphas.floor_theta},
        "umbmark": _umbmark_table(motion),
        "ends": [_ends_table(*pair) for pair in motion.ends],
        "regions": [_region_table(held) for held in motion.held],
    }


def _region_table(held: Held) -> Table:
    return asdict(held.region) | {
        "stretch": held.region.stretch,
        "held": held.share,
        "held_interval": list(held.interval),
        "held_independent": held.independent,
        "judgement": held.judgement,
    }


def _umbmark_table(motion: MotionStatistics) -> Table | None:
    squares = motion.umbmark
    if squares is None:
        return None
    return asdict(squares) | {
        "centre_cw": list(squares.centre_cw),
        "centre_ccw": list(squares.centre_ccw),
        "worst": squares.worst,
        "multipliers": squares.wheel_multipliers()._asdict(),
    }


def _ends_table(before: EndSpread, after: EndSpread) -> Table:
    return {
        "motion": before.motion,
        "runs": len(before.errors),
        "mean": before.mean.tolist(),
        "covariance": before.covariance.tolist(),
        "predicted": before.predicted.tolist(),
        "distance": float(before.distances.mean()),
        "fitted": {
            "mean": after.mean.tolist(),
            "covariance": after.covariance.tolist(),
            "predicted": after.predicted.tolist(),
            "distance": float(after.distances.mean()),
        },
    }


def sensor_table(sensor: SensorStatistics) -> Table:
    """As in ``results.json``."""
    correlation = sensor.correlation
    return {
        "rays": len(sensor.pairs),
        "all": _range_table(sensor.all),
        "by_distance": [_range_table(one) for one in sensor.distances],
        "by_bearing": [_range_table(one) for one in sensor.bearings],
        "fit": {
            name: {"value": value, "interval": [_finite(end) for end in sensor.fit.interval(name)]}
            for name, value in asdict(sensor.fit.values).items()
        },
        "iterations": sensor.fit.iterations,
        "converged": sensor.fit.converged,
        "usable": asdict(sensor.usable.values),
        "correlation": {
            "by_ray": [_finite(one) for one in correlation.by_ray.tolist()],
            "by_scan": [_finite(one) for one in correlation.by_scan.tolist()],
            "rays_used": correlation.used,
            "rays_worth": correlation.independent,
            "rays_worth_interval": list(correlation.independent_interval),
            "likelihood_weight": correlation.weight,
            "likelihood_weight_interval": list(correlation.weight_interval),
            "scans_a_new_one": correlation.scans_a_new_one,
            "scans_a_new_one_interval": list(correlation.scans_interval),
            "likelihood_weight_of_successive_scans": correlation.weight_of_successive,
            "likelihood_weight_of_successive_scans_interval": list(
                correlation.weight_of_successive_interval
            ),
        },
    }


def _range_table(one: RangeStatistics) -> Table:
    return {
        name: _finite(value) if isinstance(value, float) else value
        for name, value in asdict(one).items()
    }


def _finite(value: float) -> float | None:
    return value if math.isfinite(value) else None


def _compared(config: Config, settings: Table, job: ModelsJob, workers: Workers) -> Table:
    """The experiment with the same robot, as it is set and as it was fitted."""
    found = {}
    for name, chosen in (("default", config), ("fitted", with_settings(config, settings))):
        experiment = Experiment(chosen, (job.world,), job.robot + 1000, job.seeds, job.laps)
        outcomes = run(experiment, workers)[job.world]
        found[name] = {
            "known": condition_table([one.known for one in outcomes]),
            "offset": condition_table([one.offset for one in outcomes]),
        }
    return found
