"""What the filter believes, for the wire: estimate, hypotheses, cloud, and how many look alike."""

from __future__ import annotations

import base64
import math

import numpy as np

from app.covariance import by_rows
from app.engine.snapshot import Snapshot
from app.messages.telemetry import (
    EstimateMessage,
    FilterMessage,
    HypothesisMessage,
    ParticlesMessage,
)
from robot.fields.floor_picture import Extent
from robot.geometry import Array
from robot.localization.estimate import Hypothesis
from robot.localization.filter import Cloud

MOST_PARTICLES = 2000
"""More are not sent: a map view shows no difference."""

AMBIGUOUS = 0.2
"""A second hypothesis with this share of the weight makes the place ambiguous."""

SURE = 0.95
"""A hypothesis above this share of the weight stands alone."""

TOLD = 0.5
"""Hypotheses with less weight than this together are no answer: the rest may be anywhere."""


WIDEST_XY, WIDEST_THETA = 0.2, 0.7
"""A hypothesis that is spread farther, as standard deviations [m] and [rad], is no place."""


def alike(hypotheses: tuple[Hypothesis, ...]) -> int:
    """How many places look alike; 1 if one stands out, 0 while nothing can be said."""
    if sum(one.weight for one in hypotheses) < TOLD or _is_wide(hypotheses[0].covariance):
        return 0
    heaviest = hypotheses[0].weight
    if heaviest > SURE:
        return 1
    return sum(one.weight >= heaviest / 2 for one in hypotheses)


def _is_wide(covariance: Array) -> bool:
    across = float(np.linalg.eigvalsh(covariance[:2, :2])[-1])
    return across > WIDEST_XY**2 or float(covariance[2, 2]) > WIDEST_THETA**2


def estimate_message(snapshot: Snapshot) -> EstimateMessage | None:
    """The estimate, carried forward to the snapshot's stamp."""
    if snapshot.pose is None or snapshot.estimate is None:
        return None
    pose = snapshot.pose
    covariance = by_rows(snapshot.estimate.covariance)
    return EstimateMessage(x=pose.x, y=pose.y, theta=pose.theta, covariance=covariance)


def particles_message(snapshot: Snapshot, extent: Extent) -> ParticlesMessage:
    """Cloud and hypotheses; the latter carried forward to the snapshot's stamp."""
    estimate, cloud = snapshot.estimate, snapshot.cloud
    return ParticlesMessage(
        count=len(cloud.weights),
        effective=estimate.effective if estimate else float(len(cloud.weights)),
        hypotheses=[
            HypothesisMessage(
                x=pose.x, y=pose.y, theta=pose.theta, weight=weight, covariance=by_rows(covariance)
            )
            for pose, weight, covariance in snapshot.hypotheses()
        ],
        extent=list(extent),
        cloud=packed(cloud, extent),
    )


def filter_message(snapshot: Snapshot) -> FilterMessage:
    """What the filter does."""
    hypotheses = snapshot.estimate.hypotheses if snapshot.estimate else ()
    return FilterMessage(
        paused=snapshot.paused,
        updates=snapshot.updates,
        ambiguous=len(hypotheses) > 1 and hypotheses[1].weight >= AMBIGUOUS,
        alike=alike(hypotheses),
        broken=snapshot.fault,
    )


def packed(cloud: Cloud, extent: Extent) -> str:
    """The cloud as ``ParticlesMessage.cloud`` says."""
    step = max(1, math.ceil(len(cloud.weights) / MOST_PARTICLES))
    poses, weights = cloud.poses[::step], cloud.weights[::step]
    xmin, ymin, xmax, ymax = extent
    part = (poses[:, :2] - (xmin, ymin)) / (xmax - xmin, ymax - ymin)
    cells = np.zeros(
        len(poses), dtype=[("x", "<u2"), ("y", "<u2"), ("t", "<i2"), ("w", "u1"), ("zero", "u1")]
    )
    cells["x"], cells["y"] = np.rint(np.clip(part, 0, 1) * 65535).T
    cells["t"] = np.rint(np.clip(poses[:, 2] * (32768 / math.pi), -32768, 32767))
    # Nothing, or nothing but zeros, has no heaviest.
    cells["w"] = np.rint(weights * (255 / max(weights.max(initial=0.0), 1e-300)))
    return base64.b64encode(cells.tobytes()).decode("ascii")
