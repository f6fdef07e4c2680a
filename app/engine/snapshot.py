"""Everything that one tick of the engine shows; frozen, so any thread may read it."""

from __future__ import annotations

import time
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any, get_args

from app.engine.driving import Mode
from app.engine.follower import FilterState
from app.engine.problems import ProblemState
from app.messages.commands import Command
from app.messages.message import Layer
from robot.description.spec import RobotSpec
from robot.fields.occupancy_grid import OccupancyGrid
from robot.geometry import Array, Pose2, Twist2
from robot.interface import Frame, Reading
from robot.localization.estimate import KNOWN, Estimate, Integrity
from sim.simulated import SimSettings


@dataclass(frozen=True, slots=True)
class ReplayState:
    """State of a replay at one tick."""

    file: str
    """Name of the recording."""
    position_s: float
    """Time since the recording's beginning [s]."""
    duration_s: float
    speed: float
    """Seconds of the recording in one second."""
    paused: bool
    catching_up: float | None
    """Share of the way to the requested time, 0 to 1; None when the replay is there."""
    estimate_then: Pose2 | None
    """The recorded estimate, carried forward to the tick by odometry."""


LAYERS: frozenset[Layer] = frozenset(get_args(Layer))
"""All layers of the 3D view."""


@dataclass(frozen=True, slots=True)
class LoopStatistics:
    """Rates and delays of the engine, smoothed over about a second."""

    step_hz: float
    step_ms: float
    """Work of one step, without waiting for the robot [ms]."""
    frame_hz: float
    latency_ms: float
    """From the newest frame's exposure to this tick [ms]."""


@dataclass(frozen=True, slots=True)
class DrawnMap:
    """The map that is drawn by driving, as far as it is; others see it instead of the field's."""

    stamp: float
    """When it was drawn [s]; the same stamp means the same map."""
    grid: OccupancyGrid
    map_from_odom: Pose2
    """Where odometry began in it."""


@dataclass(frozen=True, slots=True)
class Snapshot:
    """Everything that one tick shows, in frozen values that their owners made."""

    stamp: float
    """The robot's clock [s]."""
    published: float
    """The computer's monotonic clock when this was made [s]."""
    reading: Reading = field(repr=False)
    """What the robot answered in this tick."""
    spec: RobotSpec = field(repr=False)
    """The robot as it is known now."""
    calibrated: float
    """Stamp of the last calibration since the start [s]; -inf before the first."""
    commands: tuple[Command, ...]
    """Commands taken in this tick, in order."""
    truth: Pose2 | None
    odometry: Pose2
    """Dead reckoning since the start or the last ``place`` command, in the map."""
    odom_from_robot: Pose2
    """Dead reckoning in the frame ``odom``: it never jumps."""
    pose: Pose2 | None
    """The estimate, carried forward to the stamp; None before the first measurement."""
    estimate: Estimate | None
    """The filter's newest estimate, at its own stamp."""
    integrity: Integrity
    """State, bounds and alerts of ``pose``."""
    twist: Twist2
    """The applied velocity."""
    mode: Mode
    filter: FilterState = field(repr=False)
    """Scanner and filter."""
    frame: Frame | None
    """The newest picture, with the stamp of its exposure."""
    odom_from_scan: Pose2 | None
    """Odometry at the scan's stamp."""
    scan_pose: Pose2 | None
    """The estimate at the scan's stamp."""
    loop: LoopStatistics
    connected: bool
    battery_v: float | None
    problems: ProblemState
    layers: frozenset[Layer]
    """Visible layers of the 3D view."""
    route: Pose2 | None = None
    """Goal of the route that explores, in the frame ``odom``; None without one."""
    drawn: DrawnMap | None = field(default=None, repr=False)
    """The map that is drawn by driving; None without one."""
    added: Mapping[str, Any] = field(default_factory=dict, repr=False)
    """What companions show of themselves, by the names of their features; and ``Controls.kept``."""
    faults: SimSettings | None = field(default=None, repr=False)
    """What is wrong with a simulated robot and its camera; None of a real one."""
    replay: ReplayState | None = None
    """State of the replay; None if this is not a replay."""

    @property
    def knows_place(self) -> bool:
        """Whether the filter holds one place for the robot's."""
        return self.integrity.state in KNOWN

    def failed(self, problems: ProblemState) -> Snapshot:
        """Return this snapshot for a failed engine: the robot stands and does not answer."""
        return replace(
            self,
            published=time.monotonic(),
            twist=Twist2(),
            mode="idle",
            connected=False,
            problems=problems,
        )

    def hypotheses(self) -> list[tuple[Pose2, float, Array]]:
        """Return pose now, weight and covariance of each hypothesis, heaviest first."""
        if self.estimate is None or self.pose is None:
            return []
        moved = self.estimate.pose.inverse() @ self.pose
        return [
            (hypothesis.pose @ moved, hypothesis.weight, hypothesis.covariance)
            for hypothesis in self.estimate.hypotheses
        ]
