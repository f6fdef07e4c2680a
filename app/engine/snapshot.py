"""Everything that one tick of the engine shows; frozen, so any thread may read it."""

from __future__ import annotations

import time
from dataclasses import dataclass, field, replace
from typing import get_args

from app.engine.driving import Mode
from app.engine.own_models.own_models import OwnChoice
from app.engine.problems import Problem, Problems
from app.engine.replay_state import ReplayState
from app.messages.commands import Command
from app.messages.message import Layer
from robot.geometry import Array, Pose2, Twist2
from robot.interface import Frame, Reading
from robot.localization.estimate import Estimate
from robot.localization.filter import Cloud
from robot.localization.integrity import Integrity
from robot.localization.parameters import LocalizationParameters
from robot.scanning.line_scanner import LineScan

LAYERS: frozenset[Layer] = frozenset(get_args(Layer))
"""Everything that the 3D view can show."""


@dataclass(frozen=True, slots=True)
class LoopStatistics:
    """How the engine keeps up; smoothed over about a second."""

    step_hz: float
    step_ms: float
    """Work of one step, without waiting for the robot [ms]."""
    frame_hz: float
    latency_ms: float
    """From the newest frame's exposure to this tick [ms]."""


@dataclass(frozen=True, slots=True)
class Snapshot:
    """One tick."""

    stamp: float
    """The robot's clock [s]."""
    published: float
    """The computer's monotonic clock when this was made [s]."""
    reading: Reading = field(repr=False)
    """What the robot answered in this tick."""
    commands: tuple[Command, ...]
    """Taken in this tick, in their order."""
    truth: Pose2 | None
    odometry: Pose2
    """Dead reckoning since the start or the last place, in the map."""
    odom_from_robot: Pose2
    """Dead reckoning alone: it never jumps."""
    pose: Pose2 | None
    """The estimate, carried forward to the stamp; None before the first measurement."""
    estimate: Estimate | None
    """The filter's newest answer, at its own stamp."""
    integrity: Integrity
    """What is claimed of it."""
    twist: Twist2
    """As applied."""
    mode: Mode
    cloud: Cloud = field(repr=False)
    frame: Frame | None
    """The newest picture."""
    line_scan: LineScan | None = field(repr=False)
    """What was found in it."""
    odom_from_scan: Pose2 | None
    """Odometry at the scan's stamp."""
    scan_pose: Pose2 | None
    """The estimate at the scan's stamp."""
    paused: bool
    updates: int
    parameters: LocalizationParameters = field(repr=False)
    own: OwnChoice = field(repr=False)
    """Models in files of the user's own: in use and on offer."""
    fault: str | None
    """What is wrong with them, with file and line; the robot stands still meanwhile."""
    loop: LoopStatistics
    connected: bool
    battery_v: float | None
    problems: tuple[str, ...]
    problem_count: int
    record: tuple[Problem, ...] = field(repr=False)
    layers: frozenset[Layer]
    """What the 3D view shows."""
    replay: ReplayState | None = None
    """Where a replay stands; None of a robot."""

    def failed(self, problems: Problems) -> Snapshot:
        """The same place, with the engine at an end: nothing moves and nothing answers."""
        return replace(
            self,
            published=time.monotonic(),
            twist=Twist2(),
            mode="idle",
            connected=False,
            problems=problems.now,
            problem_count=problems.count,
            record=problems.record,
        )

    def hypotheses(self) -> list[tuple[Pose2, float, Array]]:
        """Where the robot may be now: pose, weight and covariance of each, heaviest first."""
        if self.estimate is None or self.pose is None:
            return []
        moved = self.estimate.pose.inverse() @ self.pose
        return [
            (hypothesis.pose @ moved, hypothesis.weight, hypothesis.covariance)
            for hypothesis in self.estimate.hypotheses
        ]
