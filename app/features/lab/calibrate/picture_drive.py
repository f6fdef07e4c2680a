"""``brickpose calibrate drive PICTURES``: a camera that any robot carries, by its pictures.

Nobody knows the wheels of such a robot, only how it moved, by odometry. So it gets those wheels of
the described robot that would have moved it like that: how much larger they are in truth says how
much too short odometry is.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from app.console import say
from app.engine.robots import robot_spec
from app.features.lab.calibrate.calibrated_robot import CalibratedRobot
from app.features.lab.calibrate.command import MOST_S, lines_of
from app.features.lab.calibrate.drive_report import drive_report
from app.features.lab.chosen_lens import read_chosen_lens
from app.features.lab.localize.pictures.motion import PAST_END
from app.features.lab.localize.pictures.sequence import (
    SequenceError,
    StampedPicture,
    read_sequence,
)
from app.features.lab.trajectories.reading import read_trajectory
from app.files import atomic_file
from app.options import config_file
from app.result_files import require_new, require_writable
from app.settings.config import MAPS
from app.trajectories.trajectory import Trajectory
from robot.calibration.adjustment import CalibrationError
from robot.calibration.calibrate import SHORTEST_S, START_COVARIANCE, calibrate
from robot.calibration.drive_log import PERIOD_S, DriveLog, DriveRecorder
from robot.cameras.camera import PictureError, check_size
from robot.cameras.picture_files import turned_line
from robot.description.camera_file import BODY_FROM_OPTICAL, with_camera
from robot.description.spec import RobotSpec
from robot.description.unknowns import Differences
from robot.driving.differential_drive import DifferentialDrive
from robot.fields.field import Field
from robot.fields.field_loading import load_field
from robot.geometry import Array, Pose2, wrap_angle
from robot.lens_files.camera_info import camera_info
from robot.scanning.line_scanner import LineScannerSettings
from robot.settings import SettingError

OUT = Path("camera.yaml")
SUFFIXES = (".yaml", ".yml")
NEEDLESS = ("robot", "until", "seed", "condition", "serial_port")
"""Options of a drive now, which pictures of an earlier one do not need."""


@dataclass(frozen=True, eq=False)
class PictureDrive:
    """A drive as pictures and odometry tell it."""

    log: DriveLog
    unread: tuple[str, ...]
    """Names of files that hold no picture."""
    unmoved: tuple[str, ...]
    """Names of pictures of which odometry tells nothing."""
    to_turn: tuple[str, ...]
    """Names of pictures that say that they are to be turned, and are not."""


def calibrate_pictures(given: dict[str, Any]) -> int:
    """Run the command with its options by name; return 0.

    Raises:
        CalibrationError: the drive does not determine the camera; nothing is written.
        ContradictionError: it contradicts itself; only the report is written.
        SequenceError, TrajectoryError, PictureError: pictures or odometry cannot be used.
        SettingError, FieldError, CameraError, OSError: another file or option cannot be used.
    """
    for name in NEEDLESS:
        if name in given:
            raise SettingError(
                f"--{name.replace('_', '-')} has no effect with a folder of pictures"
            )
    folder, seconds = given.get("recording"), given.get("seconds", MOST_S)
    if folder is None:
        raise SettingError("--odometry is of a folder of pictures; valid is drive PICTURES")
    out, page = _written(given)
    if not SHORTEST_S <= seconds <= MOST_S:
        raise SettingError(f"--seconds is {seconds:g}; valid is {SHORTEST_S:g} to {MOST_S:g}")
    config = config_file(given)
    taped = load_field(given.get("map", config.map), MAPS)
    if not taped.tape:
        raise CalibrationError(f"the field {taped.name} is not of tape")
    spec = robot_spec(config).as_drawn
    if "camera" in given:
        spec = with_camera(spec, read_chosen_lens(Path(given["camera"]), None))
    begin = Pose2(*given["start"]) if "start" in given else taped.start
    taped.require_inside(begin)
    pictures = read_sequence(folder, given.get("stamps"))
    odometry = read_trajectory(given["odometry"]).without_repeats()
    kept = [picture for picture in pictures if picture.stamp - pictures[0].stamp < seconds]
    drive = picture_drive(kept, odometry, spec, config.scanner, taped)
    for line in _left_out(drive):
        say(line)
    calibration = calibrate(drive.log, spec, taped, begin, START_COVARIANCE)
    source = f"the pictures {folder.name} on {taped.name}"
    result = CalibratedRobot(spec, calibration, taped, drive.log.stamps, source)
    for line in lines_of(calibration):
        say(line)
    with atomic_file(page) as new:
        new.write_text(drive_report(result), encoding="utf-8")
    calibration.quality.require_consistent(force=given.get("force", False))
    with atomic_file(out) as new:
        new.write_text(camera_text(result), encoding="utf-8")
    say(f"the camera is in {out}, a report in {page}; use it by: brickpose localize --camera {out}")
    return 0


def _written(given: dict[str, Any]) -> tuple[Path, Path]:
    """Return the files for the camera and for its report, which can be written and are not there.

    Raises:
        SettingError: they cannot be.
    """
    out = given.get("out", OUT)
    if out.suffix not in SUFFIXES:
        raise SettingError(f"--out is {out}; valid is a file that ends in {' or '.join(SUFFIXES)}")
    page = given.get("report", out.with_suffix(".html"))
    require_writable(out, page)
    if not given.get("force", False):
        require_new(out, page)
    return out, page


def picture_drive(
    pictures: list[StampedPicture],
    odometry: Trajectory,
    spec: RobotSpec,
    settings: LineScannerSettings,
    taped: Field,
) -> PictureDrive:
    """Return the drive that pictures show, of a robot that moved as odometry says.

    Raises:
        SequenceError: no picture is left.
        PictureError: a picture has another size than the camera.
    """
    recorder = DriveRecorder(spec, settings, taped.tape)
    begin, end = odometry.stamps[0] - PAST_END, odometry.stamps[-1] + PAST_END
    stamps: list[float] = []
    edges: list[Array] = []
    unread: list[str] = []
    unmoved: list[str] = []
    to_turn: list[str] = []
    for picture in pictures:
        if not begin <= picture.stamp <= end:
            unmoved.append(picture.name)
            continue
        if stamps and picture.stamp - stamps[-1] < PERIOD_S - 1e-6:
            continue
        try:
            read = picture.read()
        except PictureError:
            unread.append(picture.name)
            continue
        if read.asks_to_be_turned:
            to_turn.append(picture.name)
        check_size(read.pixels.shape, spec.lens, picture.name)
        stamps.append(picture.stamp)
        edges.append(recorder.edges(read.pixels))
    if not stamps:
        raise SequenceError("no picture was taken while odometry tells how the robot moved")
    angles = wheel_angles(odometry.poses, DifferentialDrive(spec))
    log = DriveLog(np.array(stamps), np.array(edges), odometry.stamps, angles)
    return PictureDrive(log, tuple(unread), tuple(unmoved), tuple(to_turn))


def wheel_angles(poses: Array, drive: DifferentialDrive) -> Array:
    """Return how far wheels would have turned (n, 2) by each of some poses (n, 3) [rad]."""
    turn = wrap_angle(np.diff(poses[:, 2]))
    middle = poses[:-1, 2] + turn / 2
    moved = np.diff(poses[:, :2], axis=0)
    chord = moved[:, 0] * np.cos(middle) + moved[:, 1] * np.sin(middle)
    # Along an arc it went farther than straight.
    way = chord / np.sinc(turn / math.tau)
    radii = drive.radii[[drive.left, drive.right]]
    steps = (way[:, None] + turn[:, None] * drive.track / 2 * np.array([-1.0, 1.0])) / radii
    return np.vstack([np.zeros((1, 2)), np.cumsum(steps, axis=0)])


def camera_text(result: CalibratedRobot) -> str:
    """Return the file of the camera: ROS's ``camera_info``, with how it is mounted, and its delay.

    Comments say how well it is known.
    """
    calibration = result.calibration
    built = Differences(result.profile.values).applied_to(result.spec)
    pose = built.robot_from_camera
    turn = Rotation.from_matrix(pose[:3, :3] @ BODY_FROM_OPTICAL.T)
    lens = replace(built.lens, readout=result.spec.lens.readout)
    words = [f"Measured by {result.source}.", *lines_of(calibration)]
    mounting = [
        "mounting:  # ahead, left, up [m]; roll, pitch, yaw [rad]",
        f"  xyz: {_numbers(pose[:3, 3])}",
        f"  rpy: {_numbers(turn.as_euler('xyz'))}",
        f"picture_delay: {built.picture_delay:.4f}  # [s]",
    ]
    return camera_info(lens, None, "\n".join(words)) + "\n".join(mounting) + "\n"


def _numbers(values: Array) -> str:
    return "[" + ", ".join(f"{value:.6f}" for value in values.tolist()) + "]"


def _left_out(drive: PictureDrive) -> Iterator[str]:
    for name in drive.unread:
        yield f"{name} is left out: it is no picture that can be read"
    if drive.unmoved:
        names = ", ".join(drive.unmoved[:3])
        yield f"{len(drive.unmoved)} pictures are left out, such as {names}: no odometry then"
    if drive.to_turn:
        yield turned_line(list(drive.to_turn))
