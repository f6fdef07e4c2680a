"""Trials of a constant of other filters than the usual one: the grid filter and the Kalman filter.

Robots are carried off. The grid filter knows nothing at the start, the Kalman filter the pose.
"""

from __future__ import annotations

import math
import pickle
import zlib
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from app.features.lab.evaluation.integrity.claims import claims_csv, follow_claims
from app.features.lab.evaluation.integrity.drives import carried_drive
from app.features.lab.evaluation.integrity.measures import FIRST, right
from app.settings.conditions import apply_condition
from app.settings.config import Config
from benchmarks.constant_trials import MAP, ConstantTrial, without_pictures

FILTERS = {"grid": "carried", "kalman": "known-carried"}
"""How each filter starts."""
DRIVES = (("default", 60500), ("cluttered", 60501))
"""Conditions and seeds."""


def recorded(kept: Path | None, seed: int = 0) -> list[ConstantTrial]:
    """Return all trials; from a file, or to it if it is not there yet."""
    if kept is not None and kept.exists():
        trials: list[ConstantTrial] = pickle.loads(kept.read_bytes())  # our own, of a minute ago
        return trials
    trials = []
    for condition, number in DRIVES:
        config = apply_condition(Config(robot="sim", map=MAP, seed=seed + number), condition)
        drive = without_pictures(carried_drive(config))
        trials.append(ConstantTrial(config, condition, "carried", drive))
    if kept is not None:
        kept.write_bytes(pickle.dumps(trials))
    return trials


def few(trials: list[ConstantTrial]) -> list[ConstantTrial]:
    """Return all: they are few."""
    return trials


def tried(trials: list[ConstantTrial], other_numbers: int) -> dict[str, Any]:
    """Follow all drives with each filter; return figures by name, and a number for each claim.

    Args:
        other_numbers: if not 0, added to the seeds of other drives: the grid filter draws nothing.
    """
    if other_numbers:
        trials = recorded(None, other_numbers)
    figures: dict[str, Any] = {}
    each: list[int] = []
    for name, start in FILTERS.items():
        distances, is_found = [], []
        for trial in trials:
            kind = replace(trial.config.localization.filter, filter=name)
            settings = replace(trial.config.localization, filter=kind)
            config = replace(trial.config, localization=settings)
            claims = follow_claims(trial.drive, config, start)
            late = claims.stamps > FIRST
            is_found.append(right(claims)[late])
            distances.append(claims.distances[late][is_found[-1]])
            each += [zlib.crc32(line.encode()) for line in claims_csv(claims).splitlines()]
        near = np.concatenate(distances)
        figures |= {
            f"{name}: error [mm]": 1e3 * float(np.median(near)) if len(near) else math.inf,
            f"{name}: 99 % [mm]": 1e3 * float(np.percentile(near, 99)) if len(near) else math.inf,
            f"{name}: wrong [%]": 100 * float(1 - np.concatenate(is_found).mean()),
        }
    return figures | {"each": each}
