"""The work of one worker in a sweep: drive once, and follow at several settings."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from app.lab.evaluation.drives import Drive, record
from app.lab.evaluation.experiment import KNOWN, follow_from_offset
from app.lab.evaluation.results import trajectory
from app.lab.evaluation.runs import follow
from app.lab.evaluation.scores import SHOWN, errors, score, steady_error, time_to_converge
from app.lab.sweep.points import SweepJob
from app.settings.config import Config

MEASURES = (
    "ate_rmse_m",
    "ate_aligned_rmse_m",
    "heading_rmse_rad",
    "rpe_trans_rmse_m",
    "rpe_rot_rmse_rad",
    "odometry_ate_rmse_m",
    "seconds_to_converge",
    "steady_ate_rmse_m",
    "filter_ms",
)
"""Columns of the table, besides settings, world, seed and error; None means no value. All but the
last are the same in each run; the last is a measured time."""

Measured = dict[str, Any]


def follow_all(job: SweepJob) -> dict[str, Measured]:
    """Return the measures of each point by its key; a point that failed has an ``error``."""
    try:
        drive = record(job.drive, job.duration)
    except Exception as error:
        return dict.fromkeys(job.configs, _failed(error))
    return {key: _measured(drive, config, job.offset) for key, config in job.configs.items()}


def _measured(drive: Drive, config: Config, offset: tuple[float, ...]) -> Measured:
    try:
        if offset:
            run = follow_from_offset(drive, config, offset)
        else:
            run = follow(drive, config, drive.ticks[0].truth, KNOWN)
    except Exception as error:
        return _failed(error)
    truth = trajectory(run, "truth")
    result, reckoned = (score(truth, trajectory(run, method)) for method in ("amcl", "odometry"))
    offsets, turns = errors(run, run.estimate)
    translation, rotation = result.relative[SHOWN]
    values = (
        result.ate,
        result.ate_aligned,
        result.heading,
        translation,
        rotation,
        reckoned.ate,
        time_to_converge(run.stamps, offsets, turns),
        steady_error(run),
        1e3 * float(np.mean(run.cpu)),
    )
    numbers = (value if math.isfinite(value) else None for value in values)
    return dict(zip(MEASURES, numbers, strict=True)) | {"error": ""}


def _failed(error: Exception) -> Measured:
    """Return the row of a point that failed; whatever the error, the sweep goes on."""
    text = str(error) or type(error).__name__
    return dict.fromkeys(MEASURES) | {"error": " ".join(text.split())}
