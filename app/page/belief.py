"""Messages of the filter's belief: estimate, integrity, hypotheses and cloud."""

from __future__ import annotations

import base64
import math
from collections.abc import Sequence
from functools import lru_cache

import numpy as np

from app.engine.snapshot import Snapshot
from app.engine.steps_by_hand import HandState
from app.messages.telemetry import (
    EstimateMessage,
    FilterMessage,
    HandMessage,
    HypothesisMessage,
    IntegrityMessage,
    ParticlesMessage,
    PoseMessage,
)
from app.page.thresholds import ALIKE, LIKELY
from robot.covariance import by_rows
from robot.fields.floor_picture import Extent
from robot.localization.estimate import Integrity, State
from robot.localization.filter import Cloud

MOST_PARTICLES = 2000
"""Most particles that are sent: more make no difference in a map view."""


def estimate_message(snapshot: Snapshot) -> EstimateMessage | None:
    """Return the estimate, carried forward to the snapshot's stamp."""
    if snapshot.pose is None or snapshot.estimate is None:
        return None
    pose = snapshot.pose
    covariance = by_rows(snapshot.estimate.covariance)
    return EstimateMessage(x=pose.x, y=pose.y, theta=pose.theta, covariance=covariance)


def integrity_message(claimed: Integrity) -> IntegrityMessage:
    """Return state, bounds and alerts; a bound that holds for any pose is null."""
    return IntegrityMessage(
        state=claimed.state,
        radius=claimed.radius if math.isfinite(claimed.radius) else None,
        heading_bound=claimed.heading_bound if claimed.heading_bound < math.pi else None,
        alerts=[alert.text for alert in claimed.alerts],
    )


def particles_message(snapshot: Snapshot, extent: Extent) -> ParticlesMessage:
    """Return the cloud, and the hypotheses carried forward to the snapshot's stamp."""
    cloud, hypotheses = snapshot.filter.cloud, snapshot.hypotheses()
    weights = [weight for _, weight, _ in hypotheses]
    return ParticlesMessage(
        count=len(cloud.weights),
        effective=_effective(snapshot),
        hypotheses=[
            HypothesisMessage(
                x=pose.x, y=pose.y, theta=pose.theta, weight=weight, covariance=by_rows(covariance)
            )
            for pose, weight, covariance in hypotheses
        ],
        alike=alike(snapshot.integrity.state, weights),
        likely=sum(weight >= LIKELY for weight in weights),
        extent=list(extent),
        cloud=packed(cloud, extent),
    )


def _effective(snapshot: Snapshot) -> float:
    if snapshot.filter.hand is not None:
        return snapshot.filter.hand.effective
    estimate = snapshot.estimate
    return estimate.effective if estimate else float(len(snapshot.filter.cloud.weights))


def alike(state: State, weights: Sequence[float]) -> int:
    """Return how many places may be the robot's, by the hypotheses' weights, heaviest first."""
    if state in (State.SEARCHING, State.LOST):
        return 0
    if state is not State.AMBIGUOUS:
        return 1
    return sum(weight >= ALIKE * weights[0] for weight in weights)


def filter_message(snapshot: Snapshot) -> FilterMessage:
    """Return the state of the filter."""
    return FilterMessage(
        paused=snapshot.filter.paused,
        kind=snapshot.filter.parameters.filter.filter,
        hand=hand_message(snapshot.filter.hand),
        updates=snapshot.filter.updates,
        undoable=snapshot.filter.undoable,
        broken=snapshot.filter.fault,
    )


def hand_message(state: HandState | None) -> HandMessage | None:
    """Return how far the filter is by hand; None while it works by itself."""
    if state is None:
        return None
    return HandMessage(
        number=state.number,
        last=None if state.last is None else state.last.step,
        undoable=state.undoable,
        effective=state.effective,
        ahead=PoseMessage(x=state.ahead.x, y=state.ahead.y, theta=state.ahead.theta),
    )


@lru_cache(maxsize=2)
def packed(cloud: Cloud, extent: Extent, most: int = MOST_PARTICLES) -> str:
    """Pack at most this many particles of a cloud as ``ParticlesMessage.cloud`` describes."""
    step = max(1, math.ceil(len(cloud.weights) / most))
    poses, weights = cloud.poses[::step], cloud.weights[::step]
    xmin, ymin, xmax, ymax = extent
    part = (poses[:, :2] - (xmin, ymin)) / (xmax - xmin, ymax - ymin)
    cells = np.zeros(
        len(poses), dtype=[("x", "<u2"), ("y", "<u2"), ("t", "<i2"), ("w", "u1"), ("zero", "u1")]
    )
    cells["x"], cells["y"] = np.rint(np.clip(part, 0, 1) * 65535).T
    cells["t"] = np.rint(np.clip(poses[:, 2] * (32768 / math.pi), -32768, 32767))
    # An empty cloud, or one whose weights are all zero, has no heaviest particle.
    cells["w"] = np.rint(weights * (255 / max(weights.max(initial=0.0), 1e-300)))
    return base64.b64encode(cells.tobytes()).decode("ascii")
