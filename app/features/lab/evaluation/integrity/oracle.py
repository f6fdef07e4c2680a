"""Find when the field has decided: from then on, scans tell the true place from all rivals.

The oracle knows the truth. It follows each rival along the robot's true motion and lays it on the
edges scan by scan, as it does with the truth itself. It adds up how much better the rays fit at
the truth. Until the sum is beyond doubt for all rivals, and stays so, nobody could know the true
place; a claim of certain before that is unfounded.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from app.features.lab.evaluation.drives import Drive
from app.features.lab.evaluation.integrity.claims import Claims
from app.features.lab.evaluation.integrity.drives import TrialDrive
from app.features.lab.evaluation.integrity.measures import certain, right
from app.features.lab.evaluation.integrity.rivals import (
    DriveSegment,
    field_rivals,
    rivals_of,
    setup_over,
)
from app.features.lab.evaluation.runs import PLACE_THETA, PLACE_XY, Mask
from app.settings.config import Config
from robot.geometry import Array, Pose2
from robot.localization.filter import Setup
from robot.localization.ray_evidence import RayEvidence

REACH, SD = 1.0, 0.01
"""The largest range of the oracle's sensor, and the standard deviation of its ranges [m]."""
WORTH, MOST = 4.5, 3.0
"""Independent rays that a scan is worth, and the largest log-likelihood ratio of one scan."""
DECIDED = 3.0
"""Log-likelihood ratio above which one place is told from another."""
SETTLED = 20.0
"""Log-likelihood ratio above which a rival is no longer followed."""
NUDGE_XY, NUDGE_THETA = 0.04, math.radians(6)
"""Largest move of a rival when it is laid on the edges of one scan [m], [rad]."""


def decided_stamp(trial: TrialDrive, claims: Claims, config: Config, start: str) -> float:
    """Return the stamp [s] from which on the field has decided; inf if it never does.

    Args:
        trial: the drive; if the robot is carried off, only the part after that counts.
        claims: the filter's claims on the drive: places that it claimed are rivals.
        config: settings of the search for places.
        start: what was known at the start; a known start is decided from the beginning.
    """
    if start == "known":
        return float(claims.stamps[0])
    field = trial.drive.field
    carry = trial.carry_stamp
    way = DriveSegment.since(trial.drive, -math.inf if carry is None else carry)
    if len(way.stamps) == 0:
        return math.inf
    setup = setup_over(field, config)
    before = None if carry is None else trial.drive.truth_at(carry)
    rivals = rivals_of(way, claims, start, before, setup)
    return decision_stamp(way, rivals, RayEvidence.of(field, REACH, SD), setup)


def field_decides(drive: Drive, since: float) -> float:
    """Return when the field has decided, without a filter.

    Rivals are the quarter turns of the true pose and the places that a search finds.

    Args:
        drive: what the robot saw and where it was.
        since: the stamp from which on nothing was known [s].

    Returns:
        The stamp [s]; inf if the field never decides.
    """
    way = DriveSegment.since(drive, since)
    setup = setup_over(drive.field, Config())
    return decision_stamp(
        way, field_rivals(way, setup), RayEvidence.of(drive.field, REACH, SD), setup
    )


def decision_stamp(
    way: DriveSegment, rivals: list[Pose2], evidence: RayEvidence, setup: Setup
) -> float:
    """Return the stamp [s] from which on scans tell the truth from all rivals; inf if never.

    Args:
        way: the scans and the truth.
        rivals: poses at the first scan.
        evidence: weighs poses by their rays.
        setup: its matcher lays rays on edges.
    """
    last_doubt = 0
    current = [
        max(
            evidence.log_likelihood(truth, way.rays(index)),
            evidence.log_likelihood(_refined(truth, way.rays(index), setup), way.rays(index)),
        )
        for index, truth in enumerate(way.truths)
    ]
    for rival in rivals:
        last_doubt = max(last_doubt, _last_doubt(way, rival, current, evidence, setup))
    return float(way.stamps[last_doubt]) if last_doubt < len(way.stamps) else math.inf


def _last_doubt(
    way: DriveSegment, rival: Pose2, current: list[float], evidence: RayEvidence, setup: Setup
) -> int:
    """Return the index of the scan from which on a rival is out; 0 if it becomes the truth."""
    total, out = 0.0, 0
    for index, truth in enumerate(way.truths):
        rival = rival @ way.step(index)
        rays = way.rays(index)
        target = evidence.log_likelihood(rival, rays)
        laid = _refined(rival, rays, setup)
        fits = evidence.log_likelihood(laid, rays)
        if fits > target:
            rival, target = laid, fits
        if rival.distance_to(truth) < PLACE_XY and abs(rival.turn_to(truth)) < PLACE_THETA:
            return 0
        total += float(np.clip(WORTH * (current[index] - target), -MOST, MOST))
        if total <= DECIDED:
            out = index + 1
        if total > SETTLED:
            break
    return out


def _refined(pose: Pose2, rays: Array, setup: Setup) -> Pose2:
    """Lay a pose on the edges; return it unchanged if that would move it too far."""
    laid = setup.fine_matcher.match(pose, rays).pose
    near = laid.distance_to(pose) < NUDGE_XY and abs(laid.turn_to(pose)) < NUDGE_THETA
    return laid if near else pose


def decision_measures(claims: Claims, stamp: float) -> dict[str, Any]:
    """Return when the field decided, and what was claimed before and after, as shares of pictures.

    Args:
        claims: of one robot; if it is carried off, only the part after that counts.
        stamp: when the field decided [s]; inf if it never did.
    """
    since = -math.inf if claims.carry_stamp is None else claims.carry_stamp + 1e-6
    counted = claims.stamps > since
    before, after = counted & (claims.stamps < stamp), counted & (claims.stamps >= stamp)
    is_sure, is_right = certain(claims), right(claims)
    first = claims.stamps[counted][0] if counted.any() else math.nan
    result = after & is_right
    return {
        "decided_s": float(stamp - first) if math.isfinite(stamp) else None,
        "unfounded": float((is_sure & before).sum() / max(counted.sum(), 1)),
        "right_after_decided": float(is_right[after].mean()) if after.any() else None,
        "sure_after_decided": float(is_sure[result].mean()) if result.any() else None,
        "right_after_decided_s": _seconds_to_right(claims, after),
    }


def _seconds_to_right(claims: Claims, after: Mask) -> float | None:
    """Return the time [s] from the decision until the estimate stays right.

    0 if it is right from the decision on; None if it is wrong at the end.
    """
    is_right, stamps = right(claims)[after], claims.stamps[after]
    if not len(stamps) or not is_right[-1]:
        return None
    wrong = np.flatnonzero(~is_right)
    return float(stamps[wrong[-1] + 1] - stamps[0]) if len(wrong) else 0.0
