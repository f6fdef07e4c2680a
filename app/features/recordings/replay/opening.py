"""Makes a program that replays a recording, from the same parts as a program with a robot."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from app.engine.added_models import AddedModels, choice_of
from app.engine.build import build_engine
from app.engine.engine import Engine
from app.engine.parameter_changes import with_values_and_models
from app.engine.plugging import models_of
from app.engine.program import LocalProgram
from app.engine.start import Start, start
from app.features.recordings.attachments import PROFILE, SETTINGS, URDF
from app.features.recordings.files.mcap_reader import RecordingReader, open_recording
from app.features.recordings.files.recorded import RecordingError
from app.features.recordings.replay.parts import RecordedParts, first_estimate
from app.features.recordings.replay.recorded_robot import RecordedRobot
from app.features.recordings.replay.replay import Replay
from app.features.recordings.replay.requests import ReplaySettings
from app.features.recordings.replay.ticks import RecordedTopics
from app.features.recordings.replay.timeline import Timeline
from app.settings.config import MAPS, Config, by_path, with_settings
from robot.description.profile import load_profile
from robot.driving.differential_drive import DifferentialDrive
from robot.fields.field import Field
from robot.fields.field_loading import load_field
from robot.localization.models.entry_field import EntryField
from robot.scanning.line_scanner import LineScanner
from robot.settings import SettingError
from robot.toml_file import read_toml

TABLES = ("localization", "scanner", "odometry", "drive", "start_pose")
"""The tables of settings that affect a replay."""
CURES = {SETTINGS: "; --filter-config gives others", PROFILE: "; --profile gives another"}


def read_filter_config(path: Path) -> dict[str, Any]:
    """Read settings by their path (``localization.filter.max_particles``) from a TOML file.

    Raises:
        SettingError: the file cannot be read, or has settings that do not affect a replay.
    """
    content = read_toml(path)
    others = sorted(content.keys() - set(TABLES))
    if others:
        raise SettingError(
            f"{path}: {others[0]} changes no replay; valid are the tables {', '.join(TABLES)}"
        )
    return by_path(content)


def with_filter_config(config: Config, path: Path) -> tuple[Config, frozenset[str]]:
    """Replace settings by those of a file; return them, and the names of the filter's in the file.

    Raises:
        SettingError: a setting is misspelt or out of range.
    """
    given = read_filter_config(path)
    try:
        changed = with_settings(config, given)
    except SettingError as error:
        raise SettingError(f"{path}: {error}") from error
    names = (name for name in given if name.startswith("localization."))
    return changed, frozenset(name.rpartition(".")[2] for name in names)


@dataclass(frozen=True)
class ReplayOptions:
    """What may differ from the recording; None keeps what was recorded."""

    map: str | None = None
    """A field by name, or a file."""
    filter_config: Path | None = None
    """A file of settings that replace the recorded ones."""
    sensor_model: str = ""
    """The user's own model, as FILE.py:CLASS."""
    motion_model: str = ""
    models: str = ""
    """A folder of the user's own models."""
    profile: Path | None = None
    """What is known of the robot by now, instead of what was known then."""
    seed: int | None = None
    speed: float = 1.0
    paused: bool = False
    host: str = Config().host
    port: int = Config().port


@dataclass(frozen=True)
class ReplayProgram(LocalProgram):
    """A program whose robot is a recording."""

    replay: Replay = dataclasses.field(kw_only=True)
    """Its loop."""
    remarks: tuple[str, ...] = dataclasses.field(kw_only=True)
    """What is missing in the recording, or not as it was recorded."""
    before: Config | None = None
    """Settings of the program with a robot that opened it; None if it was started as a replay."""


@dataclass(frozen=True, eq=False)
class Opened:
    """A recording that was found to be sound, with its parts."""

    reader: RecordingReader
    parts: RecordedParts

    @classmethod
    def of(cls, path: Path) -> Opened:
        """Read what a recording has besides its messages.

        Raises:
            RecordingError, SettingError, FieldError, SpecError: as ``open_replay``.
        """
        reader = open_recording(path)
        RecordedTopics.of(reader.topics)
        return cls(reader, RecordedParts.of(reader))


Read = Callable[[Callable[[Path], Opened], Path], Opened]
"""Calls the first argument with the second, as ``read_apart`` does in another process."""


def read_here(read: Callable[[Path], Opened], path: Path) -> Opened:
    """Read a recording in this process."""
    return read(path)


def open_replay(
    path: Path,
    options: ReplayOptions,
    read: Read = read_here,
) -> ReplayProgram:
    """Make a program that replays a recording.

    Args:
        path: the recording.
        options: what may differ from it.
        read: where it is read.

    Raises:
        RecordingError: the file cannot be used; says what it is and what it has.
        SettingError, FieldError, SpecError: a setting, the map or the robot cannot be used.
    """
    opened = read(Opened.of, path)
    reader, parts = opened.reader, opened.parts
    topics = RecordedTopics.of(reader.topics)
    if options.profile is not None:
        built = load_profile(options.profile).applied_to(parts.spec.as_drawn)
        parts = replace(parts, spec=built)
    config, given = _configured(parts.config, options)
    field = _field(parts, options, reader)
    drive = DifferentialDrive(parts.spec, config.drive.multipliers)
    robot = RecordedRobot(reader, topics, parts.spec, drive, f"Recording {_name(path)}")
    added = models_of(config, field)
    begin = _Begin(
        config,
        field,
        LineScanner(parts.spec.floor_view, config.scanner, field.tape),
        added,
        _start(config, parts, field, robot),
        robot,
    )
    engine = begin.engine({}, None)
    settings = ReplaySettings(given)
    timeline = Timeline(engine, robot, field, settings, begin.engine)
    remarks = tuple(_remarks(reader, parts, options))
    for words in remarks:
        engine.note(words)
    replay = Replay(
        timeline, _name(path), _duration(reader, robot), paused=options.paused, speed=options.speed
    )
    return ReplayProgram(
        engine,
        robot,
        field,
        config,
        choice_of(added),
        replay.run,
        replay=replay,
        remarks=remarks,
    )


@dataclass(frozen=True)
class _Begin:
    """Makes an engine in its initial state, as often as one is needed."""

    config: Config
    field: Field
    scanner: LineScanner
    added: tuple[AddedModels, ...]
    start: Start
    robot: RecordedRobot

    def engine(self, changed: dict[str, Any], entries: EntryField | None) -> Engine:
        """Make an engine with some parameters changed by name; impossible changes are left out."""
        config, added = self.config, self.added
        for models in added:
            models.choose(None)
        parameters = config.localization
        for name, value in changed.items():
            try:
                parameters, choice = with_values_and_models(
                    parameters, choice_of(added), {name: value}
                )
            except SettingError:
                continue  # a model's file is gone; the page shows which is in use
            for models in added:
                models.choose(choice)
        return build_engine(
            config,
            self.robot,
            self.field,
            self.scanner,
            added=added,
            begin=self.start,
            parameters=parameters,
            entries=entries,
        )


def _configured(config: Config, options: ReplayOptions) -> tuple[Config, frozenset[str]]:
    """Return the settings of the replay, and the names of the filter's that were given for it."""
    given: frozenset[str] = frozenset()
    if options.filter_config is not None:
        config, given = with_filter_config(config, options.filter_config)
    config = replace(
        config,
        map=options.map or "",  # without a name, it is the recording's own map
        host=options.host,
        port=options.port,
        seed=config.seed if options.seed is None else options.seed,
        sensor_model=options.sensor_model,
        motion_model=options.motion_model,
        models=options.models,
        # Save no pose: the replayed pose is not where the robot is now.
        start_pose=replace(config.start_pose, save_pose_rate=-1.0, pose_file=""),
    )
    if options.sensor_model:
        given |= {"laser_model_type"}
    if options.motion_model:
        given |= {"robot_model_type"}
    return config, given


def _field(parts: RecordedParts, options: ReplayOptions, reader: RecordingReader) -> Field:
    if options.map is not None:
        return load_field(options.map, MAPS)
    if parts.field is None and any(name.startswith("map/") for name in parts.damaged):
        raise RecordingError(f"the map in {reader.path} is damaged; --map gives one")
    if parts.field is None:
        raise RecordingError(
            f"the recording {reader.path} has no map with it; --map says on which it was made"
        )
    return parts.field


def _start(config: Config, parts: RecordedParts, field: Field, robot: RecordedRobot) -> Start:
    """Return where the recorded filter began, as far as that is known."""
    wanted = config.start_pose
    as_configured = parts.has_settings and parts.from_start and not wanted.restore_pose
    if not as_configured:
        result = first_estimate(robot.reader, robot.topics, robot.start_ns)
        if result is not None and field.contains(result.pose):
            return Start((result,))
    return start(wanted, field)


def _remarks(reader: RecordingReader, parts: RecordedParts, options: ReplayOptions) -> list[str]:
    result = []
    if reader.unfinished:
        result.append("The recording was cut off.")
    result.extend(f"In the recording, {words}." for words in reader.damages)
    result.extend(
        f"{name} in the recording is damaged: the program's own is used{CURES.get(name, '')}."
        for name in parts.damaged
        if name in (SETTINGS, URDF, PROFILE)
    )
    if parts.models and not (options.sensor_model or options.motion_model):
        result.append(
            f"It was recorded with its user's own models ({', '.join(parts.models)}); they are "
            "not run unless --sensor-model or --motion-model says so."
        )
    return result


def _duration(reader: RecordingReader, robot: RecordedRobot) -> float:
    """From the first to the last tick [s]."""
    last = robot.start_ns
    for back in (2_000_000_000, 60_000_000_000, reader.end_ns):
        try:
            for message in reader.messages(
                (robot.topics.joint_states,), max(reader.end_ns - back, 0)
            ):
                last = max(last, message.log_time_ns)
        except RecordingError:
            last = max(last, reader.end_ns)
        if last > robot.start_ns:
            break
    return (last - robot.start_ns) / 1e9


def _name(path: Path) -> str:
    """The name of a recording's folder, or of its file without the suffix."""
    return path.absolute().stem if path.suffix == ".mcap" else path.absolute().name
