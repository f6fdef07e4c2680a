"""Drives of the simulated robot, recorded, so that many filters can be tried on the same ones."""

from __future__ import annotations

import math
from bisect import bisect_right
from dataclasses import dataclass, replace

import numpy as np

from app.engine.build import build_simulated, settle_robot
from app.settings.config import MAPS, Config
from robot.description.spec import RobotSpec
from robot.driving.differential_drive import DifferentialDrive
from robot.driving.drive_controller import DriveController
from robot.driving.figure_eight import FigureEight
from robot.driving.odometry import Odometry
from robot.fields.field import Field
from robot.fields.field_loading import load_field
from robot.geometry import Pose2, Twist2, interpolate
from robot.scan import Scan
from robot.scanning.line_scanner import LineScanner
from sim.simulated import no_wait


@dataclass(frozen=True, slots=True)
class Tick:
    """One reading of the robot."""

    stamp: float
    truth: Pose2
    odometry: Pose2
    """In the odom frame."""
    scan: Scan | None = None
    """Of the picture that came with the reading."""
    odometry_at_scan: Pose2 | None = None
    """In the odom frame, at the scan's stamp."""


@dataclass(frozen=True)
class Drive:
    """What a robot saw and where it was."""

    field: Field
    ticks: list[Tick]

    def truth_at(self, stamp: float) -> Pose2:
        """The true pose at a moment, between two readings."""
        after = min(bisect_right(self.ticks, stamp, key=lambda t: t.stamp), len(self.ticks) - 1)
        low, high = self.ticks[max(after - 1, 0)], self.ticks[after]
        part = (stamp - low.stamp) / max(high.stamp - low.stamp, 1e-9)
        return interpolate(low.truth, high.truth, min(max(part, 0.0), 1.0))


def on_eight(rng: np.random.Generator, elapsed: float, eight: FigureEight | None = None) -> Pose2:
    """Where a robot may be a time [s] after the start of a figure-eight.

    The path is turned at random about the field's centre, and the robot a little off it.
    """
    eight = eight or FigureEight()
    left = min(elapsed % eight.lap, eight.lap / 2)
    right = elapsed % eight.lap - left
    on_path = eight.twist(0.0).integrate(left) @ eight.twist(eight.lap / 2).integrate(right)
    jitter = Pose2(*rng.normal(0, (0.02, 0.02, 0.1)).tolist())
    return Pose2(theta=float(rng.uniform(-math.pi, math.pi))) @ on_path @ jitter


def record(
    config: Config,
    seconds: float,
    *,
    start: Pose2 | None = None,
    elapsed: float = 0.0,
    kidnap: tuple[float, Pose2] | None = None,
    unskew: bool = True,
) -> Drive:
    """Drive the figure-eight and keep readings and scans.

    Args:
        config: robot, map, seed and figure-eight.
        seconds: how long.
        start: pose in the map; by default the field's.
        elapsed: time on the figure-eight at the start [s].
        kidnap: when [s] and where to the robot is put, unseen by itself.
        unskew: undo the rolling shutter's skew.
    """
    of, spec = load_field(config.map, MAPS), RobotSpec.load()
    if start is not None:
        of = replace(of, start=start)
    chance = np.random.default_rng(config.seed).spawn(2)[0]
    config, _ = settle_robot(config)
    robot = build_simulated(config, spec, of, chance, no_wait)
    kinematics = DifferentialDrive(spec, config.drive.multipliers)
    odometry = Odometry(kinematics, config.odometry)
    scanner = LineScanner(spec.floor_view, config.scanner)
    controller = DriveController(kinematics, config.drive)
    ticks: list[Tick] = []
    while not ticks or ticks[-1].stamp < seconds:
        reading = robot.read()
        assert reading.truth is not None
        now = odometry.update(reading)
        tick = Tick(reading.stamp, reading.truth, now.odom_from_robot)
        if reading.frame is not None:
            then = odometry.at(reading.frame.stamp)
            twist = then.twist if unskew else Twist2()
            scan = scanner.scan(reading.frame, twist).scan
            tick = replace(tick, scan=scan, odometry_at_scan=then.odom_from_robot)
        ticks.append(tick)
        if kidnap is not None and reading.stamp >= kidnap[0]:
            robot.place(kidnap[1])
            kidnap = None
        since = reading.stamp - ticks[0].stamp
        controller.command(config.figure_eight.twist(elapsed + since), reading.stamp)
        robot.write(kinematics.wheels(controller.update(reading.stamp)))
    robot.close()
    return Drive(of, ticks)
