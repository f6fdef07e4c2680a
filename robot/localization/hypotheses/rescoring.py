"""Replays the recent scans for a new hypothesis, to weigh it fairly.

The scans of a short map are joined by odometry, which errs by some degrees over such a path. So the
map as a whole does not quite fit even at the right place. A place is therefore judged by an
extended Kalman filter that follows the path back from the newest scan, where it is known best.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from robot import ray_columns as column
from robot.compiling import compiled
from robot.geometry import Array, Pose2
from robot.localization.ray_evidence import (
    BACKGROUND_LOSS,
    RayEvidence,
    ends_of_seen,
    ray_log_likelihoods,
)
from robot.localization.scan_matching import ScanMatcher, fit_rays

START_INFORMATION = np.diag(1 / np.square([0.02, 0.02, 0.08]))
"""Information on the pose of a newly found place [1/m², 1/m², 1/rad²]."""


@dataclass(frozen=True, slots=True, eq=False)
class ScanHistory:
    """Scans along the path, the newest first, and the steps between them."""

    moves: Array = field(repr=False)
    """(m, 3) [m, m, rad] step back to each scan from the newer one, seen from the step's start."""
    noise: Array = field(repr=False)
    """(m, 3, 3) covariance of each step, seen from its start."""
    rays: Array = field(repr=False)
    """(m, k, 9) rays of each scan, as ``rays_of`` returns them."""


@dataclass(frozen=True, slots=True, eq=False)
class Rescored:
    """A hypothesis after the recent scans were replayed for it."""

    pose: Pose2
    """Pose at the newest scan."""
    covariance: Array = field(repr=False)
    """(3, 3) [m, m, rad]"""
    fits: Array = field(repr=False)
    """(m,) mean log-likelihood of the rays of each scan."""
    unseen: Array = field(repr=False)
    """(m,) how much larger it would be, if what unseen floor returned there fitted exactly."""


def rescore(
    start: Pose2, past: ScanHistory, matcher: ScanMatcher, evidence: RayEvidence
) -> Rescored:
    """Replay the scans of ``past`` for a hypothesis that has pose ``start`` at the newest one."""
    pose, information, fits, unseen = _rescore(
        start.to_array(), past.moves, past.noise, past.rays, matcher, evidence
    )
    covariance: Array = np.linalg.inv(information).astype(np.float64)
    return Rescored(Pose2(*pose.tolist()), covariance, fits, unseen)


@compiled()
def _rescore(
    start: Array,
    moves: Array,
    noise: Array,
    rays: Array,
    matcher: ScanMatcher,
    evidence: RayEvidence,
) -> tuple[Array, Array, Array, Array]:
    """Return pose (3,) and information (3, 3) at the newest scan, fits (m,), and ``unseen``."""
    fits, unseen = np.empty(len(moves)), np.zeros(len(moves))
    newest, known, _ = fit_rays(start, START_INFORMATION, rays[0], matcher)
    pose, information = newest, known
    for k in range(len(moves)):
        if k > 0:
            pose, information = _moved(pose, information, moves[k], noise[k])
            pose, information, _ = fit_rays(pose, information, rays[k], matcher)
        fits[k] = ray_log_likelihoods(pose.reshape(1, 3), rays[k], evidence, 0.0)[0]
        counted = max((~np.isnan(rays[k, :, column.NEAR])).sum(), 1)
        ends = ends_of_seen(pose, rays[k], evidence)
        unseen[k] = BACKGROUND_LOSS * np.isfinite(ends).sum() / counted
    return newest, known, fits, unseen


@compiled()
def _moved(pose: Array, information: Array, move: Array, noise: Array) -> tuple[Array, Array]:
    """Return pose and information after a step: G Sigma G^T + V M V^T."""
    c, s = math.cos(pose[2]), math.sin(pose[2])
    dx, dy = c * move[0] - s * move[1], s * move[0] + c * move[1]
    G = np.array([[1.0, 0.0, -dy], [0.0, 1.0, dx], [0.0, 0.0, 1.0]])
    V = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    covariance = G @ np.linalg.inv(information) @ G.T + V @ np.ascontiguousarray(noise) @ V.T
    return pose + np.array([dx, dy, move[2]]), np.linalg.inv(covariance)
