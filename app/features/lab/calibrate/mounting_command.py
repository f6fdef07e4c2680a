"""``brickpose calibrate mounting``: measures how the camera is mounted, by one picture."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from app.console import say
from app.engine.robots import robot_kind
from app.features.lab.calibrate.floor_grid import draw_floor
from app.features.lab.calibrate.pictures import board_of, find_in, read_grey
from app.features.lab.chosen_lens import read_chosen_lens
from app.files import atomic_file
from app.result_files import require_new_report, require_writable
from app.settings.config import AUTO, MAPS, Config
from app.settings.profile_files import profile_before, with_lens, with_mounting, write_profile
from robot.calibration.lens.sighting import Grey, SightingError
from robot.calibration.mounting.board_mounting import check_scale, mounting_by_board
from robot.calibration.mounting.mounting import UNITS, LensDoubt, Mounting, step_between
from robot.calibration.mounting.tape_mounting import mounting_by_tape
from robot.camera import Lens
from robot.cameras.picture_files import turned_line
from robot.description.lens_table import MeasuredLens
from robot.description.profile import Profile
from robot.description.spec import RobotSpec
from robot.description.unknowns import FOCAL
from robot.fields.field_loading import load_field
from robot.geometry import Pose2
from robot.lens_files.camera_info import parameter_sd
from robot.settings import SettingError

OUT = Path("profile.toml")
VAGUE = 0.01
"""A report names the focal length if its relative standard deviation is above this."""
BOARD_OPTIONS = ("squares", "size", "type", "marker", "dictionary", "spacing")


@dataclass(frozen=True)
class MeasuredMounting:
    """A mounting, and the picture that it was measured from."""

    mounting: Mounting
    source: str
    notes: tuple[str, ...] = ()
    """What else was seen, for people."""


def calibrate_mounting(given: dict[str, Any]) -> int:
    """Run the command with its options by name; return 0.

    Raises:
        MountingError, SightingError: the picture does not show the mounting; nothing is written.
        ContradictionError: it contradicts itself; nothing is written.
        SettingError, FieldError, SpecError, CameraError, OSError: says what cannot be used.
    """
    out, force = given.pop("out", OUT), given.pop("force", False)
    report = given.pop("report", out.with_suffix(".png"))
    require_writable(out, report)
    if not force:
        require_new_report(report, out)
    spec = robot_kind(Config(robot=given.pop("robot", AUTO))).description()
    before = profile_before(out, spec)
    if "camera" in given:
        lens_file = read_chosen_lens(given.pop("camera"), given.pop("camera_name", None))
        sd = parameter_sd(lens_file.keys, lens_file.lens)
        before = with_lens(before, MeasuredLens.of(lens_file.lens, sd), "lens file")
    elif "camera_name" in given:
        raise SettingError("--camera-name has no effect without --camera")
    seen_by = replace(spec, lens=before.applied_to(spec).lens)
    file = given.pop("picture")
    picture = read_grey(file)
    if picture.asks_to_be_turned:
        say(turned_line([file.name]))
    grey = picture.pixels
    _check_size(grey, seen_by.lens, file)
    measured = _measured(given, file, grey, seen_by, before)
    for line in lines_of(measured, spec):
        say(line)
    step = step_between(spec.robot_from_camera, measured.mounting.robot_from_camera)
    sd = np.sqrt(np.diag(measured.mounting.covariance))
    quality = measured.mounting.quality
    sd *= quality.interval_factor
    profile = replace(with_mounting(before, step, sd, measured.source), fit=quality.table())
    profile.applied_to(spec)
    floor = draw_floor(grey, seen_by.lens, measured.mounting.robot_from_camera)
    quality.require_consistent(force=force)
    write_profile(out, profile)
    with atomic_file(report) as new:
        cv2.imwrite(str(new), floor)
    say(f"the profile is {out}; {report} shows the floor's grid: does it lie on the floor?")
    return 0


def _check_size(grey: Grey, lens: Lens, file: Path) -> None:
    height, width = grey.shape
    if (width, height) != (lens.width, lens.height):
        raise SightingError(
            f"{file} is of {width} x {height} px, but the lens is for pictures of {lens.width} x "
            f"{lens.height} px: take it at that size, or give --camera with that lens"
        )


def _measured(
    given: dict[str, Any], file: Path, grey: Grey, spec: RobotSpec, before: Profile
) -> MeasuredMounting:
    if "at" in given:
        for name in ("map", "start"):
            if name in given:
                raise SettingError(f"--{name} has no effect with --at; valid is one of them")
        return _by_board(given, file, grey, spec, before)
    if "map" not in given:
        raise SettingError(
            "where is the board, or the robot? valid are --at X Y THETA for a board on the floor, "
            "and --map FIELD, with --start X Y THETA, for tape"
        )
    for name in BOARD_OPTIONS:
        if name in given:
            raise SettingError(f"--{name} has no effect with --map; valid is with --at")
    field = load_field(given["map"], MAPS)
    placed = Pose2(*given["start"]) if "start" in given else field.start
    settings = Config().scanner

    def measure(lens: Lens) -> Mounting:
        return mounting_by_tape(lens, grey, field, placed, spec.robot_from_camera, settings)

    mounting = _doubt(before).added(measure, spec.lens)
    source = f"mounting by tape of {field.name} in {file.name}"
    return MeasuredMounting(mounting, source, _notes(before))


def _doubt(profile: Profile) -> LensDoubt:
    """Return how exactly the lens of a profile is known."""
    focal = float(profile.sd[FOCAL])
    if profile.lens is None or not np.isfinite(profile.lens.sd[2:4]).all():
        return LensDoubt(focal)
    x, y = profile.lens.sd[2:4].tolist()
    return LensDoubt(focal, (x, y))


def _notes(profile: Profile) -> tuple[str, ...]:
    if profile.sd[FOCAL] < VAGUE:
        return ()
    percent = 196 * profile.sd[FOCAL]
    return (
        f"the focal length is known to {percent:.1f} % only, which makes the intervals wide: "
        "`brickpose calibrate lens` first",
    )


def _by_board(
    given: dict[str, Any], file: Path, grey: Grey, spec: RobotSpec, before: Profile
) -> MeasuredMounting:
    found_boards = find_in([file], board_of(given))
    if not found_boards.seen:
        raise SightingError(f"{file}: {found_boards.refused[file.name]}")
    board, sighting = found_boards.board, found_boards.seen[file.name]

    def measure(lens: Lens) -> Mounting:
        return mounting_by_board(lens, sighting, board, Pose2(*given["at"]), spec.robot_from_camera)

    mounting = _doubt(before).added(measure, spec.lens)
    width = check_scale(grey, spec.lens, mounting, sighting, board, Config().scanner)
    note = (
        "no tape beside the board: whether the board was printed at its true size is not checked"
        if width is None
        else f"the tape beside the board seems {1e3 * width:.1f} mm wide: the board's size is right"
    )
    return MeasuredMounting(
        mounting, f"mounting by a {board.words} in {file.name}", (note, *_notes(before))
    )


def lines_of(measured: MeasuredMounting, spec: RobotSpec) -> Iterator[str]:
    """Yield the lines of the report."""
    mounting = measured.mounting
    drawn = replace(mounting, robot_from_camera=spec.robot_from_camera).values
    yield f"{'measured':<9}{'value':>10}{'95 %':>8}{'drawn':>10}"
    for name, (unit, scale) in UNITS.items():
        value, sd = scale * mounting.values[name], scale * mounting.sd[name]
        yield f"{name:<9}{value:>z10.2f}{1.96 * sd:>8.2f}{scale * drawn[name]:>z10.2f} {unit}"
    yield f"{len(mounting.errors)} numbers of the picture lie {mounting.rms:.2f} px off"
    yield from (*mounting.quality.facts, *mounting.quality.remarks, *measured.notes)
