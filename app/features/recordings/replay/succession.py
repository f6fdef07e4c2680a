"""Builds the next program when the page asks for one: a replay, or the robot again."""

from __future__ import annotations

import dataclasses
from dataclasses import replace
from pathlib import Path

from app.engine.parameter_changes import changed_values
from app.engine.program import Program
from app.features.recordings.replay.opening import (
    Read,
    ReplayOptions,
    ReplayProgram,
    open_replay,
    read_here,
)
from app.features.recordings.replay.recorded_robot import RecordedRobot
from app.foreign_files import read_apart
from app.languages.marking import phrase
from app.messages.commands import SetParametersCommand
from app.page.serving import build_served
from app.settings.config import Config
from robot.errors import BrickPoseError


def replay_after(program: Program, path: Path) -> ReplayProgram:
    """Build the program that replays a recording which another program's page opened.

    Anybody may have sent the recording: another process reads it.

    Raises:
        RecordingError, SettingError, FieldError, SpecError: as ``open_replay``.
        CostlyFileError: it takes too much time or memory.
    """
    return _in_place_of(program, path, ReplayOptions(), read_apart)


def run_again(program: Program, path: Path) -> ReplayProgram:
    """Build the program that replays a recording with the current parameters of another program.

    A setting that differs from the recording's holds from the beginning, and overrides recorded
    changes; so do the user's own models.

    Raises:
        RecordingError, SettingError, FieldError, SpecError: as ``open_replay``.
    """
    config, newest = program.config, program.engine.latest.get()
    options = ReplayOptions(
        sensor_model=config.sensor_model, motion_model=config.motion_model, models=config.models
    )
    replay = _in_place_of(program, path, options)
    if newest is not None:
        values = changed_values(newest.filter.parameters, replay.config.localization)
        models = {
            "laser_model_type": newest.filter.models.sensor,
            "robot_model_type": newest.filter.models.motion,
        }
        values |= {name: model for name, model in models.items() if model}
        replay.replay.timeline.change(SetParametersCommand(type="set_parameters", values=values))
    replay.replay.asked.ask(position_s=0.0)
    return replay


def robot_again(program: Program, before: Config) -> Program:
    """Return a program with its robot, or the recording again, which says what the robot lacks."""
    try:
        return build_served(before)
    except (BrickPoseError, OSError) as error:
        assert isinstance(program.robot, RecordedRobot)
        replay = replay_after(program, program.robot.reader.path)
        replay.engine.note(phrase(f"There is no way back to the robot yet: {error}"))
        return replay


def _in_place_of(
    program: Program, path: Path, options: ReplayOptions, read: Read = read_here
) -> ReplayProgram:
    config = program.config
    replay = open_replay(path, replace(options, host=config.host, port=config.port), read)
    before = program.before if isinstance(program, ReplayProgram) else program.config
    # Its page lists the recordings of this computer, not those of the recorded one.
    config = dataclasses.replace(replay.config, recording=program.config.recording)
    return dataclasses.replace(replay, config=config, before=before)
