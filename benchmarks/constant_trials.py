"""Trials of a constant: robots that are scattered, carried off and moved; figures of their claims.

Their drives, in each condition, are recorded once, as long as the constant is of the localization.
"""

from __future__ import annotations

import math
import pickle
import zlib
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from app.features.lab.evaluation.drives import NO_PICTURE
from app.features.lab.evaluation.integrity.claims import Claims, claims_csv, follow_claims
from app.features.lab.evaluation.integrity.drives import TrialDrive
from app.features.lab.evaluation.integrity.experiment import KIDNAPPED
from app.features.lab.evaluation.integrity.measures import (
    FIRST,
    certain,
    measures,
    misleading,
    right,
)
from app.features.lab.evaluation.integrity.summary import EXPECTED
from app.settings.conditions import apply_condition
from app.settings.config import Config

MAP = "stub"
"""A field without symmetry: each place can be found."""
CONDITIONS = ("default", "cluttered", "slippery", "late", "hand-built")
SEEDS = range(100, 102)
"""Of those by which constants were chosen; the benchmarks report others."""


@dataclass(frozen=True)
class ConstantTrial:
    """A recorded drive, and how it is followed."""

    config: Config
    condition: str
    start: str
    drive: TrialDrive


def recorded(kept: Path | None) -> list[ConstantTrial]:
    """Return all trials; from a file, or to it if it is not there yet."""
    if kept is not None and kept.exists():
        trials: list[ConstantTrial] = pickle.loads(kept.read_bytes())  # our own, of a minute ago
        return trials
    trials = []
    for condition in CONDITIONS:
        for seed in SEEDS:
            config = apply_condition(Config(robot="sim", map=MAP, seed=seed), condition)
            trials += [
                ConstantTrial(config, condition, start, without_pictures(make(config)))
                for start, make in KIDNAPPED.items()
            ]
    if kept is not None:
        kept.write_bytes(pickle.dumps(trials))
    return trials


def few(trials: list[ConstantTrial]) -> list[ConstantTrial]:
    """Return a drive in each condition: a robot that is carried off."""
    return [t for t in trials if t.config.seed == SEEDS[0] and t.start == "carried"]


def without_pictures(trial: TrialDrive) -> TrialDrive:
    """Return a drive without the pictures of its line scans, which would be gigabytes."""
    ticks = [
        tick if seen is None else replace(tick, line_scan=replace(seen, picture=NO_PICTURE))
        for tick in trial.drive.ticks
        for seen in [tick.line_scan]
    ]
    return replace(trial, drive=replace(trial.drive, ticks=ticks))


def tried(trials: list[ConstantTrial], other_numbers: int) -> dict[str, Any]:
    """Follow all drives; return figures by their names, and a number for each picture's claim.

    Args:
        other_numbers: added to the seeds of the filters.
    """
    followed = []
    for trial in trials:
        config = replace(trial.config, seed=trial.config.seed + other_numbers)
        followed.append((trial, follow_claims(trial.drive, config, trial.start)))
    lines = [line for _, claims in followed for line in claims_csv(claims).splitlines()]
    return figures(followed) | {"each": [zlib.crc32(line.encode()) for line in lines]}


def figures(followed: list[tuple[ConstantTrial, Claims]]) -> dict[str, float]:
    """Return what a constant is judged by."""
    distances = np.concatenate([claims.distances[right(claims)] for _, claims in followed])
    known, wrong = [], []
    false: list[bool] = []
    named: list[bool] = []
    for trial, claims in followed:
        since = claims.stamps - (claims.carry_stamp or 0.0)
        known.append(certain(claims))
        wrong.append(misleading(claims) & ~((since > 0) & (since <= FIRST)))
        expected = EXPECTED.get(trial.condition, ())
        before = [c for c, s in zip(claims.causes, since, strict=True) if s <= 0]
        false += [cause is not None and cause not in expected for cause in before]
        if expected:
            named += [cause in expected for cause in before]
    rows = [(trial.start, measures(claims)) for trial, claims in followed]
    first = [row["time_to_right_before_carry_s"] for start, row in rows if start == "carried"]
    later = [row["time_to_right_s"] for _, row in rows]
    return {
        "error [mm]": 1e3 * float(np.median(distances)),
        "99 % [mm]": 1e3 * float(np.percentile(distances, 99)),
        "right [%]": 100 * _share([right(claims) for _, claims in followed]),
        "certain [%]": 100 * _share(known),
        "misleading [%]": 100 * _share(wrong),
        "false alarm [%]": 100 * _share([false]),
        "cause named [%]": 100 * _share([named]),
        "found [s]": _median(first),
        "again [s]": _median(later),
        "not found": sum(time is None for time in first + later),
    }


def _share(some: Sequence[ArrayLike]) -> float:
    joined = np.concatenate(some)
    return float(joined.mean()) if len(joined) else math.nan


def _median(times: list[float | None]) -> float:
    return float(np.median([np.inf if time is None else time for time in times]))
