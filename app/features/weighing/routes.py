"""Routes that say how a scan fits single poses, all over the field, and in all directions."""

from __future__ import annotations

import base64
import math
import threading
import time
from typing import Annotated, Protocol, runtime_checkable

import numpy as np
from fastapi import APIRouter, HTTPException, Query

from app.engine.program import Program
from app.engine.snapshot import Snapshot
from app.features.weighing.messages import (
    HeadingsMessage,
    LandscapeMessage,
    PoseFitMessage,
    PoseFitsMessage,
)
from app.languages.marking import phrase
from app.messages.answers import refusal
from app.messages.telemetry import PoseMessage
from robot.fields.field import Field
from robot.geometry import Array, Pose2
from robot.localization.landscape import by_heading, landscape
from robot.localization.weighing import Weighing
from robot.scan import Scan

LOWEST = math.log(1e-6)
"""Log of the smallest weight that a landscape tells from none."""
MOST_SHARES_S = 0.5
"""Rays of a user's own model are not asked one by one if that would take longer [s]."""
WAIT_S = 2.0
"""Longest wait for somebody else's landscape [s]."""

Coordinate = Annotated[float, Query(ge=-1e4, le=1e4, allow_inf_nan=False)]
"""[m] in the map."""
Angle = Annotated[float, Query(ge=-1e3, le=1e3, allow_inf_nan=False)]
NOTHING = refusal(503, "before the camera's first picture, or while others ask")


@runtime_checkable
class FallibleSensor(Protocol):
    """A sensor model that can fail, as a feature's: it is asked here beside the engine."""

    @property
    def fault(self) -> str | None:
        """What went wrong, for people; None while nothing did."""
        ...

    def log_likelihood(self, poses: Array, scan: Scan) -> Array:
        """Return numbers of its shape, also once it has failed."""
        ...

    def apart(self) -> FallibleSensor:
        """Return the same model with a fault of its own: a failure there stops no robot."""
        ...


def weighing_router(program: Program) -> APIRouter:
    """Return the routes; they are answered beside the engine, by its last snapshot."""
    router = APIRouter()
    alone = threading.Lock()

    @router.get("/api/pose_fit", responses=NOTHING)
    def pose_fit(x: Coordinate, y: Coordinate, theta: Angle | None = None) -> PoseFitsMessage:
        """How the scan fits a pose, ray by ray; without a heading, the particle nearest to it."""
        return pose_fits(*_newest(program), program.field, (x, y, theta))

    @router.get("/api/likelihood", responses=NOTHING)
    def likelihood(theta: Angle | None = None) -> LandscapeMessage:
        """How the scan fits all over the field, at a heading; by default at the estimate's."""
        if not alone.acquire(timeout=WAIT_S):
            raise HTTPException(503, "Other pages are computing likelihoods; try again.")
        try:
            return landscape_message(*_newest(program), program.field, theta)
        finally:
            alone.release()

    @router.get("/api/likelihood/headings", responses=NOTHING)
    def headings(x: Coordinate, y: Coordinate) -> HeadingsMessage:
        """How the scan fits in all directions at a place."""
        return headings_message(*_newest(program), x, y)

    return router


def _newest(program: Program) -> tuple[Snapshot, Weighing]:
    """Return the newest snapshot, and how particles are weighed in it."""
    program.engine.audience.visit()
    latest = program.engine.latest.get()
    if latest is None or latest.filter.weighing is None:
        raise HTTPException(503, "The camera has sent no picture yet.")
    weighing = latest.filter.weighing.settled(latest.filter.cloud.poses)
    if isinstance(weighing.model, FallibleSensor):
        weighing = weighing.asking(weighing.model.apart())
    return latest, weighing


def _require_sound(weighing: Weighing) -> None:
    """Refuse numbers of a user's own model that has just failed."""
    model = weighing.model
    if isinstance(model, FallibleSensor) and model.fault is not None:
        raise HTTPException(503, phrase(f"The sensor model failed: {model.fault}"))


def pose_fits(
    snapshot: Snapshot,
    weighing: Weighing,
    field: Field,
    place: tuple[float, float, float | None],
) -> PoseFitsMessage:
    """Return how the scan fits a pose, or the particle nearest to x and y, and the estimate."""
    x, y, theta = place
    particle = None
    asked = Pose2(x, y, theta or 0.0)
    if theta is None and len(snapshot.filter.cloud.weights):
        asked, particle = _nearest(snapshot, x, y)
    scan, best = weighing.scan, weighing.best
    poses = np.array([pose.to_array() for pose in (asked, best or asked)])
    began = time.perf_counter()
    logs = weighing.log_likelihoods(poses)
    each = time.perf_counter() - began
    shares = weighing.shares(poses) if each * len(scan.ranges) < MOST_SHARES_S else None
    _require_sound(weighing)
    reach = snapshot.filter.parameters.sensor.laser_max_range
    fits = [
        PoseFitMessage(
            x=pose.x,
            y=pose.y,
            theta=pose.theta,
            log_likelihood=float(logs[i]),
            weight=math.exp(min(weighing.power * float(logs[i] - logs[1]), 300.0)),
            expected=_numbers(weighing.expected(pose, field.edge_index, reach)),
            shares=None if shares is None else _numbers(shares[i]),
            rest=0.0 if shares is None else float(logs[i] - np.nansum(shares[i])),
        )
        for i, pose in enumerate((asked, best or asked))
    ]
    start = scan.robot_from_scan
    return PoseFitsMessage(
        stamp=scan.stamp,
        model=_model_name(snapshot),
        power=weighing.power,
        extra_sd=scan.extra_sd,
        bearings=scan.bearings.round(5).tolist(),
        ranges=_numbers(scan.ranges),
        robot_from_scan=PoseMessage(x=start.x, y=start.y, theta=start.theta),
        asked=fits[0],
        particle=particle,
        best=None if best is None else fits[1],
    )


def _nearest(snapshot: Snapshot, x: float, y: float) -> tuple[Pose2, float]:
    """Return the particle nearest to a place, and its weight as a multiple of the mean."""
    cloud = snapshot.filter.cloud
    nearest = int(np.hypot(*(cloud.poses[:, :2] - (x, y)).T).argmin())
    return Pose2(*cloud.poses[nearest].tolist()), float(cloud.weights[nearest] * len(cloud.weights))


def landscape_message(
    snapshot: Snapshot, weighing: Weighing, field: Field, theta: float | None
) -> LandscapeMessage:
    """Return how the scan fits all over the field, and how long it took to say."""
    began = time.perf_counter()
    heading = theta if theta is not None else weighing.best.theta if weighing.best else 0.0
    area = landscape(weighing, field.drive_area, heading)
    _require_sound(weighing)
    logs = area.logs - area.logs.max()
    row, column = np.unravel_index(int(area.logs.argmax()), area.logs.shape)
    cells = np.rint((1 - np.clip(logs / LOWEST, 0, 1)) * 255).astype(np.uint8)
    x, y = area.origin
    best = PoseMessage(x=x + int(column) * area.step, y=y + int(row) * area.step, theta=heading)
    return LandscapeMessage(
        stamp=weighing.scan.stamp,
        model=_model_name(snapshot),
        x=x,
        y=y,
        step=area.step,
        columns=logs.shape[1],
        rows=logs.shape[0],
        theta=heading,
        lowest=LOWEST,
        cells=base64.b64encode(cells.tobytes()).decode("ascii"),
        best=best,
        seconds=time.perf_counter() - began,
    )


def headings_message(
    _snapshot: Snapshot, weighing: Weighing, x: float, y: float
) -> HeadingsMessage:
    """Return how the scan fits in all directions at a place."""
    began = time.perf_counter()
    thetas, logs = by_heading(weighing, x, y)
    _require_sound(weighing)
    return HeadingsMessage(
        stamp=weighing.scan.stamp,
        thetas=thetas.round(5).tolist(),
        logs=(logs - logs.max()).round(4).tolist(),
        seconds=time.perf_counter() - began,
    )


def _model_name(snapshot: Snapshot) -> str:
    return snapshot.filter.models.sensor or snapshot.filter.parameters.sensor.laser_model_type


def _numbers(values: Array) -> list[float | None]:
    """Return numbers; null for one that is not finite."""
    return [round(value, 5) if math.isfinite(value) else None for value in values.tolist()]
