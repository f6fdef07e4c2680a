"""Trials of a constant of mapping: maps of floors are drawn from drives with pictures of the floor.

The drives are recorded once. A map lies on the floor as its first pose does.
"""

from __future__ import annotations

import math
import pickle
import zlib
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from scipy.spatial import cKDTree

from app.engine.build import Streams
from app.engine.robots import build_robot
from app.settings.conditions import apply_condition
from app.settings.config import MAPS, Config
from robot.calibration.drive_log import DriveLog, DriveRecorder
from robot.description.spec import RobotSpec
from robot.description.unknowns import Differences
from robot.driving.differential_drive import DifferentialDrive
from robot.driving.figure_eight import FigureEight
from robot.fields.edges import sample
from robot.fields.field import Field
from robot.fields.field_loading import load_field
from robot.fields.svg_field import field_of_drawing
from robot.geometry import Array, Pose2, Twist2
from robot.mapping.mapper import Mapper
from robot.mapping.tape_map import MappingError
from sim.imperfections import draw
from sim.simulated import no_wait

DRAWN = (("stub", 60200), ("tee", 60201), ("generated-2", 60202))
"""Floors, and the robots that draw them; the last one's tape bends."""
LAP_S = 16.5
STEP = 0.004
"""Distance of the points at which edges are compared [m]."""
SAME_EDGE = 0.02
"""An edge is drawn if one is this near [m], with its tape on the same side."""


@dataclass(frozen=True, eq=False)
class LoggedDrive:
    """A drive as mapping and calibration take it, and the truth."""

    log: DriveLog
    field: Field
    path: Array
    """(k, 3) true poses at the pictures."""
    values: Array
    """(n,) true differences of the robot from its description."""
    name: str
    """Of the field."""
    seed: int


def recorded(
    kept: Path | None, record: Callable[[], list[LoggedDrive]] | None = None
) -> list[LoggedDrive]:
    """Return all drives, or those that are recorded; from a file, or to it if it is not there."""
    if kept is not None and kept.exists():
        drives: list[LoggedDrive] = pickle.loads(kept.read_bytes())  # our own, of a minute ago
        return drives
    drives = [lap(*drive) for drive in DRAWN] if record is None else record()
    if kept is not None:
        kept.write_bytes(pickle.dumps(drives))
    return drives


def few(drives: list[LoggedDrive]) -> list[LoggedDrive]:
    """Return the first, and the last, whose tape bends."""
    return [drives[0], drives[-1]]


def lap(name: str, seed: int) -> LoggedDrive:
    """Return a lap of the figure-eight of a robot that is as it is described."""
    return driven("default", name, seed, LAP_S, FigureEight().twist)


def driven(
    condition: str,
    name: str,
    seed: int,
    seconds: float,
    motion: Callable[[float], Twist2] | None = None,
    steer: Callable[[Field], Callable[[Pose2], Twist2]] | None = None,
) -> LoggedDrive:
    """Return what a robot logs that was built in a condition, and the truth.

    Args:
        condition: by which it was built; with any but the usual one the scanner's limits are
            wider, as its calibration is not known.
        name: of the field.
        seed: of the robot and of its sensors.
        seconds: how long it drives.
        motion: how it drives, by the time; None if it is steered.
        steer: on a field, returns how it drives by where it truly is.
    """
    spec, field = RobotSpec.load(), load_field(name, MAPS)
    config = apply_condition(Config(robot="sim"), condition)
    # More pictures than the recorder takes would only be rendered.
    camera = replace(config.sim.camera, frame_rate=10.0)
    config = replace(config, sim=replace(config.sim, camera=camera))
    robot = build_robot(config, spec, field, Streams.of(seed).robot, no_wait)
    recorder = DriveRecorder(spec, config.scanner, field.tape, calibrated=condition == "default")
    drive = DifferentialDrive(spec)
    by_pose = None if steer is None else steer(field)
    truths: list[tuple[float, ...]] = []
    try:
        while not truths or truths[-1][0] < seconds:
            reading = robot.read()
            recorder.add(reading)
            assert reading.truth is not None
            truths.append((reading.stamp, *reading.truth.to_array().tolist()))
            wanted = Twist2()
            if motion is not None:
                wanted = motion(reading.stamp)
            elif by_pose is not None:
                wanted = by_pose(reading.truth)
            robot.write(drive.wheels(wanted))
    finally:
        robot.close()
    delay = config.sim.camera.stamp_error
    true = draw(spec, config.sim.imperfections, Streams.of(seed).robot)
    path = np.array(truths)
    path[:, 3] = np.unwrap(path[:, 3])
    exposed = recorder.log.stamps - delay
    poses = [np.interp(exposed, path[:, 0], column) for column in path.T[1:]]
    values = Differences.between(spec, true, delay).values
    return LoggedDrive(recorder.log, field, np.column_stack(poses), values, name, seed)


def tried(drives: list[LoggedDrive], other_numbers: int) -> dict[str, Any]:
    """Draw the maps; return figures by name, and a number for each result.

    Args:
        other_numbers: if not 0, added to the seeds of other drives.
    """
    drawn = []
    for drive in drives:
        try:
            drawn.append(
                draw_map(lap(drive.name, drive.seed + other_numbers) if other_numbers else drive)
            )
        except MappingError:
            drawn.append(FAILED)
    means, largest, missing = np.array([each.figures for each in drawn]).T
    return {
        "map's edges off [mm]": over(np.mean, means),
        "at most [mm]": over(np.max, largest),
        "not drawn [%]": over(np.mean, missing),
        "refused": drawn.count(FAILED),
        "each": [each.number for each in drawn],
    }


@dataclass(frozen=True)
class AdjustedDrive:
    """What came of a drive."""

    figures: tuple[float, float, float]
    number: int = 0
    """Of the result; another result has another one."""


FAILED = AdjustedDrive((np.nan, np.nan, np.nan))


def draw_map(drive: LoggedDrive, *, calibrate: bool = False) -> AdjustedDrive:
    """Draw a map; its edges' mean and largest error [mm], and the share that is missing [%].

    Args:
        drive: from which it is drawn.
        calibrate: the robot along with it.
    """
    start = Pose2.from_array(drive.path[0])
    width = drive.field.tape[0].width
    drawn = Mapper(drive.log, RobotSpec.load(), width, start, calibrate=calibrate).run()
    text = drawn.drawing("drawn")
    own, true = (
        np.hstack([points, SAME_EDGE * normals])
        for edges in (field_of_drawing(text, "drawn").edges, drive.field.edges)
        for points, normals in [sample(edges, STEP)]
    )
    away = np.asarray(cKDTree(true).query(own)[0])
    lacking = np.asarray(cKDTree(own).query(true)[0]) > SAME_EDGE
    figures = 1e3 * float(away.mean()), 1e3 * float(away.max()), 100 * float(lacking.mean())
    return AdjustedDrive(figures, zlib.crc32(text.encode()))


def over(measure: Callable[[Array], Any], figures: Array) -> float:
    """Return a measure of the figures of what was not refused; nan if all was."""
    known = figures[~np.isnan(figures)]
    return float(measure(known)) if len(known) else math.nan
