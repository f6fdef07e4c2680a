"""From a snapshot to the messages that describe it."""

from __future__ import annotations

import base64
import dataclasses
import math

import numpy as np

from app.engine.snapshot import LAYERS, Snapshot
from app.messages.answers import FieldMessage, ParameterMessage
from app.messages.telemetry import (
    EstimateMessage,
    FilterMessage,
    HypothesisMessage,
    LoopMessage,
    ParticlesMessage,
    PoseMessage,
    RobotMessage,
    ScanMessage,
    TelemetryMessage,
    TwistMessage,
)
from app.own_models.own_models import OwnChoice
from robot.fields.field import Field
from robot.geometry import Array, Pose2
from robot.interface import Placeable, Robot
from robot.localization.filter import Cloud
from robot.localization.parameters import LocalizationParameters
from robot.scanning.line_scanner import LineScan, LineScanner
from robot.scanning.tape_edges import Verdict
from robot.settings import Setting, describe

MOST_PARTICLES = 2000
"""More are not sent: a map view shows no difference."""

AMBIGUOUS = 0.2
"""A second hypothesis with this share of the weight makes the place ambiguous."""


class TelemetryWriter:
    """Knows what does not change: the field, the robot and the scanner."""

    def __init__(self, field: Field, robot: Robot, scanner: LineScanner) -> None:
        self._field = field
        self._robot = robot
        self._scanner = scanner

    def message(self, snapshot: Snapshot) -> TelemetryMessage:
        """The telemetry of one tick."""
        estimate = snapshot.estimate
        hypotheses = estimate.hypotheses if estimate else ()
        return TelemetryMessage(
            stamp=snapshot.stamp,
            map=self._field.name,
            truth=pose_message(snapshot.truth),
            odometry=pose_message(snapshot.odometry),
            estimate=_estimate(snapshot),
            twist=TwistMessage(v=snapshot.twist.v, omega=snapshot.twist.omega),
            mode=snapshot.mode,
            particles=ParticlesMessage(
                count=len(snapshot.cloud.weights),
                effective=estimate.effective if estimate else float(len(snapshot.cloud.weights)),
                hypotheses=[
                    HypothesisMessage(x=h.pose.x, y=h.pose.y, theta=h.pose.theta, weight=h.weight)
                    for h in hypotheses
                ],
                extent=list(self._field.floor.extent),
                cloud=_packed(snapshot.cloud, self._field.floor.extent),
            ),
            scan=self._scan(snapshot),
            robot=RobotMessage(
                name=self._robot.name,
                connected=snapshot.connected,
                battery_v=snapshot.battery_v,
                can_be_placed=isinstance(self._robot, Placeable),
            ),
            loop=LoopMessage(**dataclasses.asdict(snapshot.loop)),
            filter=FilterMessage(
                paused=snapshot.paused,
                updates=snapshot.updates,
                ambiguous=len(hypotheses) > 1 and hypotheses[1].weight >= AMBIGUOUS,
            ),
            problems=list(snapshot.problems),
            error_count=snapshot.problem_count,
            hidden_layers=sorted(LAYERS - snapshot.layers),
        )

    def _scan(self, snapshot: Snapshot) -> ScanMessage:
        found = snapshot.line_scan
        table = self._scanner.table
        if found is None:
            rays = len(table.bearings)
            return ScanMessage(
                stamp=0.0,
                bearings=_rounded(table.bearings, 5),
                ranges=[None] * rays,
                robot_from_scan=PoseMessage(x=table.centre[0], y=table.centre[1], theta=0.0),
                robot=None,
                entry_px=[None] * rays,
                exit_px=[None] * rays,
                tape_width=None,
            )
        counted = found.verdicts == Verdict.COUNTED
        width = float(np.median(found.widths[counted])) if counted.any() else None
        start = found.scan.robot_from_scan
        return ScanMessage(
            stamp=found.scan.stamp,
            bearings=_rounded(found.scan.bearings, 5),
            ranges=[None if math.isinf(r) else round(r, 5) for r in found.scan.ranges.tolist()],
            robot_from_scan=PoseMessage(x=start.x, y=start.y, theta=start.theta),
            robot=pose_message(snapshot.scan_pose),
            entry_px=self._pixels(found, 0, counted),
            exit_px=self._pixels(found, 1, counted),
            tape_width=width,
        )

    def _pixels(
        self, found: LineScan, which: int, counted: np.ndarray
    ) -> list[tuple[float, float] | None]:
        pixels = self._scanner.pixels(found.edges[:, which]).tolist()
        return [
            (round(u, 1), round(v, 1)) if shown else None
            for (u, v), shown in zip(pixels, counted.tolist(), strict=True)
        ]


def pose_message(pose: Pose2 | None) -> PoseMessage | None:
    """A pose for the wire."""
    return None if pose is None else PoseMessage(x=pose.x, y=pose.y, theta=pose.theta)


def field_message(field: Field, robot: Robot, scanner: LineScanner, limits: Array) -> FieldMessage:
    """What a view needs once; ``limits`` (2,) are the greatest v [m/s] and omega [rad/s]."""
    lines = scanner.table.lines(9).round(1).tolist()
    return FieldMessage(
        name=field.name,
        extent=list(field.floor.extent),
        start=PoseMessage(x=field.start.x, y=field.start.y, theta=field.start.theta),
        robot_outline=[(x, y) for x, y in robot.spec.outline.round(4).tolist()],
        max_v=float(limits[0]),
        max_omega=float(limits[1]),
        image_width=robot.spec.lens.width,
        image_height=robot.spec.lens.height,
        rays_px=[[(u, v) for u, v in line] for line in lines],
    )


def parameter_messages(
    now: LocalizationParameters, default: LocalizationParameters, own: OwnChoice, given: OwnChoice
) -> list[ParameterMessage]:
    """Every parameter of the filter, with its meaning; models of the user's own are choices, too.

    Args:
        now: the parameters that hold.
        default: those of the start.
        own: models of the user's own, in use and on offer.
        given: those of the start.
    """
    found = []
    models = {
        "laser_model_type": (own.sensor, given.sensor, own.sensors),
        "robot_model_type": (own.motion, given.motion, own.motions),
    }
    for group in dataclasses.fields(now):
        values, defaults = getattr(now, group.name), getattr(default, group.name)
        for name, known in describe(values).items():
            chosen, first, offered = models.get(name, ("", "", ()))
            value = chosen or getattr(values, name)
            standard = first or getattr(defaults, name)
            found.append(_parameter(group.name, name, known, value, standard, offered))
    return found


def _parameter(
    group: str,
    name: str,
    known: Setting,
    value: object,
    default: object,
    more_choices: tuple[str, ...],
) -> ParameterMessage:
    return ParameterMessage.model_validate(
        {
            "name": name,
            "group": group,
            "value": value,
            "default": default,
            "meaning": known.meaning,
            "unit": known.unit,
            "low": known.low if math.isfinite(known.low) else None,
            "high": known.high if math.isfinite(known.high) else None,
            "choices": [*known.choices, *more_choices],
            "integer": isinstance(default, int) and not isinstance(default, bool),
        }
    )


def _estimate(snapshot: Snapshot) -> EstimateMessage | None:
    if snapshot.pose is None or snapshot.estimate is None:
        return None
    pose = snapshot.pose
    return EstimateMessage(
        x=pose.x,
        y=pose.y,
        theta=pose.theta,
        covariance=snapshot.estimate.covariance.ravel().tolist(),
    )


def _packed(cloud: Cloud, extent: tuple[float, float, float, float]) -> str:
    """The cloud as ``ParticlesMessage.cloud`` says."""
    step = max(1, math.ceil(len(cloud.weights) / MOST_PARTICLES))
    poses, weights = cloud.poses[::step], cloud.weights[::step]
    xmin, ymin, xmax, ymax = extent
    part = (poses[:, :2] - (xmin, ymin)) / (xmax - xmin, ymax - ymin)
    packed = np.zeros(
        len(poses), dtype=[("x", "<u2"), ("y", "<u2"), ("t", "<i2"), ("w", "u1"), ("zero", "u1")]
    )
    packed["x"], packed["y"] = np.rint(np.clip(part, 0, 1) * 65535).T
    packed["t"] = np.rint(np.clip(poses[:, 2] * (32768 / math.pi), -32768, 32767))
    packed["w"] = np.rint(weights * (255 / weights.max()))
    return base64.b64encode(packed.tobytes()).decode("ascii")


def _rounded(values: Array, digits: int) -> list[float]:
    rounded: list[float] = values.round(digits).tolist()
    return rounded
