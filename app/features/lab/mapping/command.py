"""``brickpose map``: draws the tape of a floor from a recorded drive."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from dataclasses import replace
from datetime import UTC, datetime
from pathlib import Path

import numpy as np

from app.console import say
from app.features.lab.mapping.map_report import map_report
from app.features.lab.unknown_lines import unknown_lines
from app.features.mapping.map_files import write_map, written_for
from app.features.recordings.replay.opening import ReplayOptions, open_replay
from app.files import atomic_file
from app.result_files import require_new, require_writable
from app.settings.profile_files import profile_before, write_profile
from robot.calibration.drive_log import DriveLog, DriveRecorder
from robot.description.profile import Profile
from robot.description.spec import RobotSpec
from robot.description.unknowns import ROBOT
from robot.fields.svg_field import TAPE_MM
from robot.geometry import Pose2
from robot.interface import RobotError
from robot.mapping.mapper import Mapper
from robot.mapping.tape_map import MappingError, TapeMap
from robot.scanning.tape import Tape
from robot.settings import SettingError

MOST_MET = 2000
"""Once rays met so many edges, the shade of tape that they met more often is the floor's."""


def map_recording(
    recording: Path,
    out: Path,
    start: Sequence[float],
    width: float,
    report: Path | None,
    profile: Path | None,
    *,
    force: bool = False,
    brightness: str | None = None,
) -> int:
    """Run the command; return 0, or 1 if the map does not fit what was seen.

    Args:
        recording: the drive.
        out: the drawing to write; the ROS map lies beside it.
        start: where the drive begins in the map [m, m, rad].
        width: of the tape [m].
        report: the page to write; None is beside the drawing.
        profile: calibrates the robot along with the map, and writes its profile; or None.
        force: whether files of an earlier map may be overwritten, and a map be written that
            contradicts itself.
        brightness: of the tape, as ``read_drive``.

    Raises:
        MappingError, CalibrationError: the drive does not tell what the floor is like.
        ContradictionError: the map contradicts itself; only the report is written.
        SettingError, RecordingError, OSError: says what cannot be used.
    """
    if out.suffix.lower() != ".svg":
        raise SettingError(f"--out is {out}; valid is a file that ends in .svg")
    low, high = (side / 1e3 for side in TAPE_MM)
    if not low <= width <= high:
        raise SettingError(f"--width is {width:g}; valid is {low:g} to {high:g}")
    if not np.isfinite(start).all():
        raise SettingError(f"--start is {start}; valid are finite numbers")
    page = report or out.with_suffix(".html")
    calibrate = profile is not None
    require_writable(out, page, *([profile] if profile else []))
    if not force:
        require_new(*written_for(out), page)
    log, spec = read_drive(recording, width, brightness, calibrated=not calibrate)
    if profile is not None:
        profile_before(profile, spec)  # another robot's is not overwritten
    mapper = Mapper(log, spec, width, Pose2(*start), calibrate=calibrate)
    drawn = mapper.run(_show if sys.stderr.isatty() else _silent)
    with atomic_file(page) as new:
        new.write_text(map_report(drawn, recording.name), encoding="utf-8")
    for line in [*drawn.facts, *drawn.remarks]:
        say(line)
    drawn.quality.require_consistent(force=force)
    write_map(drawn, out, f"Drawn from {recording.name}")
    options = f"--map {out}"
    if profile is not None:
        measured = profile_of_map(drawn, spec, f"a map from {recording.name}")
        write_profile(profile, measured)
        for line in unknown_lines(measured.values, measured.sd):
            say(line)
        options += f" --profile {profile}"
    say(f"the map is {out}, a report in {page}; use it by: brickpose run {options}")
    return 0 if drawn.fits else 1


def profile_of_map(drawn: TapeMap, spec: RobotSpec, source: str) -> Profile:
    """Return the profile of a robot that was calibrated along with a map."""
    values = drawn.solution.state.values[:ROBOT]
    sd = np.sqrt(np.diag(drawn.solution.covariance))[:ROBOT] * drawn.quality.interval_factor
    lens = Profile.of(spec).lens
    return Profile(spec.name, datetime.now(UTC), source, values, sd, lens, drawn.quality.table())


def read_drive(
    recording: Path, width: float, brightness: str | None = None, *, calibrated: bool = True
) -> tuple[DriveLog, RobotSpec]:
    """Return the drive in a recording, and its robot, with its calibration or without.

    Args:
        recording: the drive.
        width: of the tape [m].
        brightness: ``dark``, ``light`` or ``either`` than the floor; None is what the recording's
            scanner is set to, or, if that goes by its field, the one that pictures show.
        calibrated: whether the robot is as its profile says.

    Raises:
        RecordingError: the file cannot be used.
        MappingError: it has no pictures.
    """
    program = open_replay(recording, ReplayOptions())
    spec = program.robot.spec if calibrated else program.robot.spec.uncalibrated
    brightness = brightness or program.config.scanner.tape_brightness
    shades = ("dark", "light") if brightness == "field" else (brightness,)
    recorders = [
        DriveRecorder(
            spec,
            replace(program.config.scanner, tape_brightness=shade, tape_width=width),
            (Tape(width),),
            calibrated=calibrated,
        )
        for shade in shades
    ]
    met, pictures = np.zeros(len(shades)), 0
    try:
        while True:
            reading = program.robot.read()
            pictures += reading.frame is not None
            for place, recorder in enumerate(recorders):
                edges = recorder.add(reading)
                met[place] += 0 if edges is None else np.isfinite(edges[:, 0]).sum()
            if len(recorders) > 1 and met.max() > MOST_MET:
                recorders, met = [recorders[int(met.argmax())]], np.zeros(1)
    except RobotError:
        pass  # the recording is over
    finally:
        program.robot.close()
    if not pictures:
        raise MappingError(f"{recording} has no pictures; a map needs them, and the wheels' turns")
    return recorders[int(met.argmax())].log, spec


def _silent(seconds: float) -> None:
    """Show nothing: the output is no terminal."""


def _show(seconds: float) -> None:
    sys.stderr.write(f"\r{seconds:4.0f} s of the drive are mapped")
    sys.stderr.flush()
