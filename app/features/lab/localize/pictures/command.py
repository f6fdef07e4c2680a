"""Carries out ``brickpose localize`` with a folder of pictures, and draws what was found."""

from __future__ import annotations

import argparse
import math
from collections import Counter
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np

from app.console import say
from app.engine.robots import robot_spec
from app.features.lab.chosen_lens import read_chosen_lens
from app.features.lab.localize.localize import GivenStart
from app.features.lab.localize.pictures.follow import LocatedPicture, LocatedPictures, PictureRun
from app.features.lab.localize.pictures.motion import RecordedOdometry
from app.features.lab.localize.pictures.sequence import (
    SequenceError,
    StampedPicture,
    read_sequence,
)
from app.features.lab.trajectories.reading import read_trajectory
from app.options import config_file
from app.result_files import require_new, require_writable
from app.settings.config import MAPS, Config
from app.trajectories.trajectory import Trajectory
from app.trajectories.tum_file import write_tum
from robot.cameras.camera import Picture
from robot.cameras.picture_files import turned_line
from robot.description.camera_file import with_camera
from robot.description.spec import RobotSpec
from robot.fields.edges import sample
from robot.fields.field import Field, FieldError
from robot.fields.field_loading import load_field
from robot.geometry import Array, Pose2
from robot.localization.estimate import State
from robot.scanning.line_scanner import LineScan, LineScanner
from robot.scanning.tape_edges import Verdict
from robot.settings import SettingError

COLOURS = {
    Verdict.TOO_SHORT: (255, 120, 0),
    Verdict.NOT_STRAIGHT: (0, 0, 255),
    Verdict.WRONG_WIDTH: (255, 0, 255),
}
"""BGR of entries that do not count, by why: blue, red, magenta."""
ENTRY, EXIT, FIELD = (0, 255, 0), (255, 255, 0), (0, 165, 255)
"""BGR of entries that count (green), their exits (cyan), and the field's edges (orange)."""
STEP_M, FARTHEST_M = 0.004, 1.5
"""Step along the field's edges, and how far from the camera they are drawn."""


class Overlays:
    """A folder of pictures with what was found in them."""

    def __init__(self, folder: Path, field: Field) -> None:
        """Make the folder; it may exist, and pictures of the same names are replaced."""
        folder.mkdir(parents=True, exist_ok=True)
        self._folder = folder
        self._points, _ = sample(field.edges, STEP_M)

    def write(
        self, located: LocatedPicture, image: Picture, line_scan: LineScan, scanner: LineScanner
    ) -> None:
        """Draw one picture.

        Raises:
            OSError: the file cannot be written.
        """
        drawn = np.ascontiguousarray(image.copy())
        _dots(drawn, self._edges(located, scanner), FIELD, 0)
        sides = [scanner.pixels(side) for side in line_scan.edges.T]
        for verdict, colour in COLOURS.items():
            _dots(drawn, sides[0][line_scan.verdicts == verdict], colour, 2)
        counted = line_scan.scan.hit
        _dots(drawn, sides[1][counted], EXIT, 1)
        _dots(drawn, sides[0][counted], ENTRY, 2)
        done, data = cv2.imencode(".png", drawn)
        if done:
            _overlay(self._folder, located.picture).write_bytes(data.tobytes())

    def _edges(self, located: LocatedPicture, scanner: LineScanner) -> Array:
        """Return the pixels (n, 2) of the field's edges, seen from the estimate."""
        seen = located.pose.inverse().apply(self._points)
        place = scanner.view.robot_from_camera[:2, 3]
        near = seen[np.hypot(*(seen - place).T) < FARTHEST_M]
        pixels = scanner.view.pixels(near)
        shown: Array = pixels[scanner.view.inside(pixels, 1.0)]
        return shown


def _dots(image: Picture, pixels: Array, colour: tuple[int, int, int], radius: int) -> None:
    for u, v in pixels[np.isfinite(pixels[:, 0])].round().astype(int).tolist():
        cv2.circle(image, (u, v), radius, colour, -1)


def _overlay(folder: Path, picture: StampedPicture) -> Path:
    return folder / f"{picture.path.stem}.png"


def _overlays_in(folder: Path, pictures: Sequence[StampedPicture]) -> list[Path]:
    """Return the files that show what was found.

    Raises:
        SettingError: one of them is a picture of the recording.
    """
    files = [_overlay(folder, picture) for picture in pictures]
    recorded = {picture.path.resolve() for picture in pictures}
    if any(file.resolve() in recorded for file in files):
        raise SettingError(f"--overlays is {folder}, whose pictures are read; valid is another")
    return files


def localize_pictures(parsed: argparse.Namespace) -> int:
    """Follow the robot through the pictures and write its trajectory; return 0.

    Raises:
        SequenceError, PictureError: the pictures cannot be used.
        SettingError, FieldError, SpecError, CameraError, TrajectoryError: another file or option
            cannot be used.
    """
    config = config_file(vars(parsed))
    pictures = read_sequence(parsed.bag, parsed.stamps)
    field = load_field(str(parsed.map), MAPS)
    if not field.tape:
        raise FieldError(f"the field {field.name} is not of tape; valid is a drawing (.svg)")
    spec = _spec(parsed, config)
    odometry = None
    if parsed.odometry is not None:
        odometry = RecordedOdometry(read_trajectory(parsed.odometry).without_repeats())
    run = PictureRun(
        spec,
        field,
        replace(config, seed=parsed.seed),
        _start(parsed, field, config),
        odometry,
    )
    out = parsed.out or Path("localized") / f"{parsed.bag.resolve().name}.tum"
    require_writable(out)
    shown = () if parsed.overlays is None else _overlays_in(parsed.overlays, pictures)
    if not parsed.force:
        require_new(out, *shown)
    overlays = None if parsed.overlays is None else Overlays(parsed.overlays, field)
    run.follow(pictures, overlays.write if overlays else None)
    _write(out, run.result, parsed.bag, field)
    _tell(run.result, len(pictures), out)
    if odometry is None:
        say(
            "without --odometry nothing tells how far the robot drives along straight tape: no "
            "bound can be told, and it may be metres off"
        )
    return 0


def _spec(parsed: argparse.Namespace, config: Config) -> RobotSpec:
    if parsed.profile is not None:
        config = replace(config, profile=str(parsed.profile))
    spec = robot_spec(config)
    if parsed.camera is None:
        if parsed.camera_name is not None:
            raise SettingError("--camera-name has no effect without --camera")
        return spec
    return with_camera(spec, read_chosen_lens(parsed.camera, parsed.camera_name))


def _start(parsed: argparse.Namespace, field: Field, config: Config) -> GivenStart | None:
    if parsed.initial_pose is None:
        return None
    pose = Pose2(*parsed.initial_pose)
    try:
        field.require_inside(pose)
    except FieldError as error:
        raise SettingError(f"--initial-pose {error}") from error
    default = config.localization.filter
    return GivenStart(
        pose,
        parsed.sd_xy or default.initial_sd_xy,
        parsed.sd_theta or default.initial_sd_theta,
    )


def _write(out: Path, result: LocatedPictures, folder: Path, field: Field) -> None:
    if len(result.located) < 2:
        raise SequenceError(
            f"the robot was located in {len(result.located)} of the pictures of {folder}; a "
            "trajectory needs 2"
        )
    trajectory = Trajectory.of_poses(
        [item.exposed for item in result.located],
        [item.pose.to_array() for item in result.located],
    )
    write_tum(out, trajectory, [f"{folder.name} on {field.name}, pose at the exposures"])


def _tell(result: LocatedPictures, count: int, out: Path) -> None:
    for kind, pictures in (
        ("stale: it shows what the one before showed, but the robot has moved", result.stale),
        (
            "left out: picture and odometry disagree, and the next ones do not tell which is right",
            result.disagreeing,
        ),
        (
            "left out: picture and odometry disagree, and the next one agrees with the picture: "
            "odometry jumped",
            result.jumped,
        ),
        ("left out: it is no picture that can be read", result.unread),
        ("left out: odometry tells nothing at its time", result.unmoved),
        ("left out: no place is known", result.unknown),
    ):
        for picture in pictures:
            say(f"{picture.name} is {kind}")
    if result.to_turn:
        say(turned_line([picture.name for picture in result.to_turn]))
    states = Counter(str(item.state) for item in result.located)
    claimed = ", ".join(f"{number} {state}" for state, number in states.most_common())
    say(f"{len(result.located)} of {count} pictures: {claimed}")
    for line in _trust(result.located):
        say(line)
    say(f"the trajectory is {out}")


def _trust(located: list[LocatedPicture]) -> list[str]:
    """Return lines that say how far poses can be relied on."""
    lines = []
    shares = [item.share for item in located if not math.isnan(item.share)]
    if shares:
        lines.append(
            f"edges in the pictures that lie on the field: {np.median(shares):.0%} (median), "
            f"at least {min(shares):.0%}"
        )
    bounds = [item.radius for item in located if math.isfinite(item.radius)]
    if bounds:
        lines.append(
            f"the place is known to {1e3 * np.median(bounds):.0f} mm (median), at worst "
            f"{1e3 * max(bounds):.0f} mm, in {len(bounds)} pictures; in "
            f"{len(located) - len(bounds)} no bound can be told"
        )
    else:
        lines.append("in no picture a bound can be told")
    lost = [item.exposed - located[0].exposed for item in located if item.state is State.LOST]
    if lost:
        lines.append(
            f"lost in {len(lost)} pictures, first {lost[0]:.1f} s and last {lost[-1]:.1f} s after "
            "the first picture: what they show is not drawn where the poses are"
        )
    return lines
