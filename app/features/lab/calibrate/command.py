"""``brickpose calibrate drive``: measures a robot from a drive, and writes its profile."""

from __future__ import annotations

import math
import sys
from argparse import Namespace
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from app.condition_option import with_condition
from app.console import say
from app.engine.build import build_program
from app.engine.program import LocalProgram
from app.engine.robots import own_file, robot_kind
from app.features.lab.calibrate.calibrated_robot import CalibratedRobot
from app.features.lab.calibrate.drive_report import drive_report
from app.features.lab.unknown_lines import unknown_lines
from app.features.recordings.replay.opening import ReplayOptions, open_replay
from app.files import atomic_file
from app.messages.commands import PauseCommand
from app.messages.driving_commands import DriveCommand
from app.options import config_file, config_from
from app.result_files import require_new_report, require_writable
from app.settings.config import AUTO, Config
from app.settings.profile_files import profile_before, write_profile
from app.settings.profiles import NONE
from robot.calibration.adjustment import CalibrationError, Solution
from robot.calibration.calibrate import SHORTEST_S, START_COVARIANCE, Calibration, calibrate
from robot.calibration.drive_log import DriveRecorder
from robot.calibration.programme import LONGEST_S, USUAL_S, rest_after, velocity
from robot.description.lens_table import MeasuredLens
from robot.description.profile import load_profile
from robot.description.spec import RobotSpec
from robot.description.unknowns import ROBOT, UNKNOWNS
from robot.fields.field import Field
from robot.geometry import Pose2
from robot.interface import Reading, RobotError
from robot.settings import SettingError

MOST_S = 600.0
"""Longest duration of a drive [s]."""
FEWEST_S = 20.0
"""Before, nothing is adjusted to see whether the camera's place is known [s]."""
MOST_MORE = 1.5
"""By which factor a drive is longer when it is looked at again, at most: looking takes seconds."""
OUT = Path("profile.toml")
Report = Callable[[float, Solution], None]
LIVE_ONLY = ("until", "robot", "condition", "seed", "serial_port", "camera")
"""Options that have no effect with a recording."""


def calibrate_drive(given: dict[str, Any]) -> int:
    """Run the command with its options by name; return 0.

    Raises:
        CalibrationError: the drive does not determine the unknowns; nothing is written.
        ContradictionError: it contradicts itself; only the report is written.
        SettingError, FieldError, RecordingError, OSError: says what cannot be used.
    """
    if "stamps" in given:
        raise SettingError("--stamps has no effect without --odometry")
    until, force = given.pop("until", None), given.pop("force", False)
    seconds = given.pop("seconds", USUAL_S if until is None else LONGEST_S)
    if not SHORTEST_S <= seconds <= MOST_S:
        raise SettingError(f"--seconds is {seconds:g}; valid is {SHORTEST_S:g} to {MOST_S:g}")
    start = given.pop("start", None)
    driven = Config(robot=given.get("robot", config_file(given).robot))
    out = given.pop("out", own_file(driven) or OUT)
    pose = None if start is None else Pose2(*start)
    page = given.pop("report", out.with_suffix(".html"))
    require_writable(out, page)
    if not force:
        require_new_report(page, out)
    recording = given.pop("recording", None)
    report = _show if sys.stderr.isatty() else _silent
    if recording is None:
        lens = profile_before(out, robot_kind(driven).description()).lens
        config = with_condition(config_from(Namespace(**given)), given)
        result = calibrate_by_driving(config, seconds, pose, report, lens, until)
    else:
        for name in LIVE_ONLY:
            if name in given:
                option = "--" + name.replace("_", "-")
                raise SettingError(f"{option} has no effect with a recording")
        lens = load_profile(out).lens if out.exists() else None
        result = calibrate_recording(recording, given.get("map"), seconds, pose, report, lens)
    for line in lines_of(result.calibration):
        say(line)
    known = result.calibration.camera_y_sd
    if until is not None:
        compared = "known" if known <= until else "not known"
        say(f"camera_y is {compared} to {1e3 * until:g} mm: its deviation is {1e3 * known:.2f} mm")
    profile_before(out, result.spec)
    with atomic_file(page) as new:
        new.write_text(drive_report(result), encoding="utf-8")
    result.calibration.quality.require_consistent(force=force)
    write_profile(out, result.profile)
    robot = "" if driven.robot == AUTO else f" --robot {driven.robot}"
    used = f"brickpose run{robot} --profile {out}"
    say(f"the profile is {out}, a report in {page}; use it by: {used}")
    return 0


def _silent(seconds: float, solution: Solution) -> None:
    """Show nothing, because the output is not a terminal."""


def _show(seconds: float, solution: Solution) -> None:
    sd = np.sqrt(np.diag(solution.covariance))[:ROBOT]
    cells = []
    for unknown, each in zip(UNKNOWNS, sd, strict=False):
        name = unknown.name.removeprefix("camera_")
        cells.append(f"{name} {1.96 * unknown.scale * each:.2g} {unknown.unit}")
    sys.stderr.write(f"{seconds:4.0f} s, +- (95 %): {', '.join(cells)}\n")
    sys.stderr.flush()


def calibrate_by_driving(
    config: Config,
    seconds: float,
    start: Pose2 | None,
    report: Report = _silent,
    lens: MeasuredLens | None = None,
    until: float | None = None,
) -> CalibratedRobot:
    """Drive the calibration's programme with a robot, and adjust the drive.

    Args:
        config: of the robot.
        seconds: how long it drives at most.
        start: where it stands; the field's start by default.
        report: called while the drive is adjusted.
        lens: that it is seen through, if it is another than the described one.
        until: standard deviation of ``camera_y`` [m] at which the drive ends.

    Raises:
        CalibrationError: the robot has a fault, or the drive does not determine the unknowns.
        SpecError: the lens is for pictures of another size.
    """
    # An earlier profile would hide what is measured.
    config = replace(config, profile=NONE)
    program = build_program(config)
    try:
        program.field.require_inside(start or program.field.start)
        spec = _seen_through(lens, program.robot.spec)
        recorder = DriveRecorder(spec, config.scanner, program.field.tape)
        began: float | None = None
        due, elapsed = FEWEST_S, 0.0
        for reading in _driven(program, seconds):
            recorder.add(reading)
            began = reading.stamp if began is None else began
            elapsed = reading.stamp - began
            # The robot stands between two parts, and may wait there.
            if until is not None and elapsed >= rest_after(due):
                more = (_known(recorder, spec, program.field, start) / until) ** 2
                if more <= 1:
                    break
                # The variance falls with the time, or faster.
                due = elapsed * min(MOST_MORE, more)
    finally:
        program.robot.close()
    driven = seconds if until is None else elapsed
    source = f"{driven:.3g} s of driving on {program.field.name}"
    result = _adjusted(recorder, spec, program.field, start, source, report)
    return replace(result, lens=lens)


def _seen_through(lens: MeasuredLens | None, spec: RobotSpec) -> RobotSpec:
    return spec if lens is None else lens.applied_to(spec)


def _driven(program: LocalProgram, seconds: float) -> Iterator[Reading]:
    """Yield the readings of a robot that drives the programme."""
    engine = program.engine
    engine.commands.put(PauseCommand(type="pause"))
    began: float | None = None
    while True:
        reading = engine.step().reading
        began = reading.stamp if began is None else began
        elapsed = reading.stamp - began
        if reading.faults:
            raise CalibrationError(f"the robot stopped: {reading.faults[0]}")
        if elapsed >= seconds:
            return
        yield reading
        wanted = velocity(elapsed)
        engine.commands.put(DriveCommand(type="drive", v=wanted.v, omega=wanted.omega))


def calibrate_recording(
    path: Path,
    map_name: str | None,
    seconds: float,
    start: Pose2 | None,
    report: Report = _silent,
    lens: MeasuredLens | None = None,
) -> CalibratedRobot:
    """Adjust the beginning of a recorded drive.

    Raises:
        RecordingError: the file cannot be used.
        CalibrationError: the drive does not determine the unknowns.
    """
    program = open_replay(path, ReplayOptions(map=map_name))
    first: float | None = None
    try:
        program.field.require_inside(start or program.field.start)
        spec = _seen_through(lens, program.robot.spec.as_drawn)
        recorder = DriveRecorder(spec, program.config.scanner, program.field.tape)
        while True:
            reading = program.robot.read()
            first = reading.stamp if first is None else first
            if reading.stamp - first >= seconds:
                break
            recorder.add(reading)
    except RobotError:
        pass  # the recording is over
    finally:
        program.robot.close()
    source = f"the recording {path.name} on {program.field.name}"
    result = _adjusted(recorder, spec, program.field, start, source, report)
    return replace(result, lens=lens)


def _known(recorder: DriveRecorder, spec: RobotSpec, field: Field, start: Pose2 | None) -> float:
    """Return the standard deviation of ``camera_y`` by the drive so far [m]; inf if it is none."""
    try:
        return _adjusted(recorder, spec, field, start, "", _silent).calibration.camera_y_sd
    except CalibrationError:
        return math.inf  # more of the drive may tell


def _adjusted(
    recorder: DriveRecorder,
    spec: RobotSpec,
    field: Field,
    start: Pose2 | None,
    source: str,
    report: Report,
) -> CalibratedRobot:
    if field.tape_width is None:
        raise CalibrationError(f"the field {field.name} is not of tape")
    begin = start or field.start
    log = recorder.log
    result = calibrate(log, spec, field, begin, START_COVARIANCE, report)
    return CalibratedRobot(spec, result, field, log.stamps, source)


def lines_of(calibration: Calibration) -> list[str]:
    """Return the report, with a line for each unknown."""
    lines = unknown_lines(calibration.values, calibration.sd, calibration.not_learnt)
    lines += calibration.quality.facts
    millimetres = 1.96 * 1e3 * calibration.position_sd
    if not math.isnan(millimetres):
        lines.append(
            f"all of this makes the robot's place uncertain by {millimetres:.2f} mm (95 %)"
        )
    lines += calibration.remarks
    lines += [f"to learn more: {motion}" for motion in calibration.advice]
    return lines
