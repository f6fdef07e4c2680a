"""Telemetry: turns a snapshot into the messages that describe it."""

from __future__ import annotations

import dataclasses
import math
from functools import lru_cache

from app.engine.drivers import DriveState
from app.engine.plugging import plugged
from app.engine.program import Program
from app.engine.snapshot import LAYERS, Snapshot
from app.engine.values import listed
from app.messages.answers import FieldMessage
from app.messages.telemetry import (
    DriverMessage,
    LoopMessage,
    PoseMessage,
    RobotMessage,
    ScanMessage,
    TelemetryMessage,
    TwistMessage,
)
from app.page.belief import estimate_message, filter_message, integrity_message, particles_message
from app.page.outlets import Outlets
from app.page.thresholds import LONGEST_STEP_M, STALE_S
from app.page.view.cameras import home
from app.settings.faults import changed_faults
from robot.geometry import Array, Pose2
from robot.scanning.line_scanner import LineScan
from sim.engines import engine_is_here


class TelemetryWriter:
    """Writes telemetry about one field and one robot, which do not change, and their outputs."""

    def __init__(self, program: Program, outlets: Outlets) -> None:
        self._field = program.field
        self._robot = program.facts
        self._sim = program.config.sim
        self._outlets = outlets

    def message(self, snapshot: Snapshot) -> TelemetryMessage:
        """Return the telemetry of one tick."""
        faults, values = snapshot.faults, listed(snapshot)
        failures = self._outlets.failures  # after the values, which say what could not be read
        return TelemetryMessage(
            stamp=snapshot.stamp,
            map=self._field.name,
            truth=pose_message(snapshot.truth),
            odometry=pose_message(snapshot.odometry),
            estimate=estimate_message(snapshot),
            integrity=integrity_message(snapshot.integrity),
            twist=TwistMessage(v=snapshot.twist.v, omega=snapshot.twist.omega),
            wheels=[float(speed) for speed in snapshot.reading.velocities],
            mode=snapshot.mode,
            driver=driver_message(self._outlets.drivers.state),
            particles=particles_message(snapshot, self._field.extent),
            scan=_scan_message(snapshot),
            robot=RobotMessage(
                name=self._robot.name,
                connected=snapshot.connected,
                battery_v=snapshot.battery_v,
                can_be_placed=self._robot.can_be_placed,
                engine=self._robot.engine,
                faults={} if faults in (None, self._sim) else changed_faults(faults, self._sim),
                calibrated=snapshot.calibrated if math.isfinite(snapshot.calibrated) else None,
            ),
            loop=LoopMessage(**dataclasses.asdict(snapshot.loop)),
            filter=filter_message(snapshot),
            values=values,
            problems=[*snapshot.problems.present, *failures],
            error_count=snapshot.problems.count + len(failures),
            hidden_layers=sorted(LAYERS - snapshot.layers),
            **self._outlets.telemetry(snapshot),
        )


def _scan_message(snapshot: Snapshot) -> ScanMessage:
    line_scan = snapshot.filter.line_scan
    if line_scan is None:
        assert snapshot.filter.scanner is not None  # a program that is served has a scanner
        table = snapshot.filter.scanner.table
        return ScanMessage(
            stamp=0.0,
            bearings=_rounded(table.bearings, 5),
            ranges=[None] * len(table.bearings),
            robot_from_scan=PoseMessage(x=table.centre[0], y=table.centre[1], theta=0.0),
            robot=None,
            tape_width=None,
        )
    start = line_scan.scan.robot_from_scan
    return ScanMessage(
        stamp=line_scan.scan.stamp,
        bearings=_rounded(line_scan.scan.bearings, 5),
        ranges=[None if r == math.inf else r for r in _rounded(line_scan.scan.ranges, 5)],
        robot_from_scan=PoseMessage(x=start.x, y=start.y, theta=start.theta),
        robot=pose_message(snapshot.scan_pose),
        tape_width=tape_width(line_scan),
    )


@lru_cache(maxsize=2)
def tape_width(line_scan: LineScan) -> float | None:
    """Return the tape's measured width [m]; None if no ray counted."""
    width = line_scan.tape_width
    return None if math.isnan(width) else width


def driver_message(state: DriveState) -> DriverMessage:
    """Return who drives, for the clients that do not."""
    name = None if state.driver is None else state.driver.name
    return DriverMessage(name=name, mine=False, this_page=False, stopped=state.stopped)


def pose_message(pose: Pose2 | None) -> PoseMessage | None:
    """Return a pose as a message; None stays None."""
    return None if pose is None else PoseMessage(x=pose.x, y=pose.y, theta=pose.theta)


def field_message(program: Program) -> FieldMessage:
    """Return the message that a page gets first, and again after a calibration."""
    field, spec, scanner = program.field, program.engine.spec, program.engine.scanner
    drive, initial = program.config.drive, program.config.localization.filter
    robot = program.facts
    lines = scanner.table.lines(9).round(1).tolist()
    view_home = home(field.floor.extent).round(3).tolist()
    return FieldMessage(
        name=field.name,
        drive_area=list(field.drive_area),
        extent=list(field.floor.extent),
        view_home=(view_home[0], view_home[1], view_home[2]),
        start=PoseMessage(x=field.start.x, y=field.start.y, theta=field.start.theta),
        robot_outline=[(x, y) for x, y in spec.outline.round(4).tolist()],
        robot_measured=spec.measured,
        engine_missing=robot.has_faults and robot.engine is None and not engine_is_here(),
        max_v=drive.max_velocity,
        max_omega=drive.max_angular_velocity,
        drive_timeout=drive.cmd_vel_timeout,
        stale_after=STALE_S,
        longest_step=LONGEST_STEP_M,
        initial_sd_xy=initial.initial_sd_xy,
        initial_sd_theta=initial.initial_sd_theta,
        image_width=spec.lens.width,
        image_height=spec.lens.height,
        tape_width=scanner.main_width,
        rays_px=[[(u, v) for u, v in line] for line in lines],
        features=[feature.name for feature in plugged().features.active],
    )


def _rounded(values: Array, digits: int) -> list[float]:
    rounded: list[float] = values.round(digits).tolist()
    return rounded
