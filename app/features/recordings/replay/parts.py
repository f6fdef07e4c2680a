"""The settings, map and robot that a recording contains, so that nothing else is needed."""

from __future__ import annotations

import dataclasses
import tempfile
from collections.abc import Collection
from dataclasses import dataclass, replace
from pathlib import Path, PurePath, PurePosixPath
from typing import Any

import numpy as np

from app.features.recordings.attachments import PROFILE, SETTINGS, URDF
from app.features.recordings.files.mcap_reader import RecordingReader
from app.features.recordings.files.recorded import RecordingError
from app.features.recordings.replay.decoding import ContentError, pose_and_covariance_of
from app.features.recordings.replay.ticks import RecordedTopics
from app.features.ros.message_types import MessageError
from app.settings.config import MAPS, NEW_NAMES, Config, as_table, by_path, from_table
from robot.description.profile import load_profile
from robot.description.spec import RobotSpec
from robot.fields.field import Field
from robot.fields.field_loading import load_field
from robot.fields.map_files import read_map_yaml
from robot.localization.estimate import Hypothesis
from robot.settings import SettingError
from robot.toml_file import parse_toml

TAKEN = ("drive", "odometry", "scanner", "localization", "start_pose", "seed")
"""Settings that are taken from the recording; where to listen and what to publish are not."""

FOLDERS = ("map", "robot")
"""Folders of attachments that are read; code in a recording is never run."""

LONGEST_NAME = 255
"""Longest name that a file can have [bytes]."""

MODELS = "models/"
SOON_NS = 10_000_000_000
"""An estimate later than this after the first tick says nothing about the beginning [ns]."""
SINCE = np.diag(np.square([0.01, 0.01, 0.03]))
"""Covariance of the robot's possible motion since the estimate [m², m², rad²]."""


@dataclass(frozen=True)
class RecordedParts:
    """The parts of one recording, as far as it has them."""

    config: Config
    """The recorded settings; the program's own where there are none."""
    spec: RobotSpec
    field: Field | None
    """None if the recording has no map."""
    has_settings: bool
    """Whether the recording has settings."""
    from_start: bool
    """Whether the recording began with the run, before the filter knew anything."""
    models: tuple[str, ...] = ()
    """Files of the user's own models that were in use."""
    damaged: tuple[str, ...] = ()
    """Attachments that are damaged."""

    @classmethod
    def of(cls, reader: RecordingReader) -> RecordedParts:
        """Read the parts of a recording.

        Raises:
            RecordingError, SettingError, FieldError, SpecError: one of the parts cannot be used.
        """
        with tempfile.TemporaryDirectory(prefix="brickpose-") as made:
            folder = Path(made)
            damaged = _damaged(reader)
            names = _unpacked(reader, folder, damaged)
            facts = reader.metadata.get("brickpose", {})
            map_file = facts.get("map_file", "")
            return cls(
                Config() if SETTINGS in damaged else _config(reader),
                _robot(folder, names),
                _field(folder / map_file) if map_file in names else None,
                SETTINGS in reader.attachments and SETTINGS not in damaged,
                facts.get("from_start") == "true",
                tuple(n.removeprefix(MODELS) for n in reader.attachments if n.startswith(MODELS)),
                damaged,
            )


def _damaged(reader: RecordingReader) -> tuple[str, ...]:
    result = []
    for name in reader.attachments:
        try:
            reader.attachments[name]
        except RecordingError:
            result.append(name)
    return tuple(result)


def _unpacked(reader: RecordingReader, folder: Path, damaged: Collection[str]) -> list[str]:
    """Write the attachments that may be read to a folder; return their names."""
    names = []
    for name in reader.attachments.keys() - set(damaged):
        path = PurePosixPath(name)
        if len(path.parts) == 2 and path.parts[0] in FOLDERS and _names_file(path.name):
            target = folder / path
            target.parent.mkdir(exist_ok=True)
            target.write_bytes(reader.attachments[name])
            names.append(name)
    return names


def _names_file(name: str, system: type[PurePath] = Path) -> bool:
    """Whether a foreign name can be that of a file, and does not lead out of its folder.

    On Windows a backslash and a drive's colon lead elsewhere, too.
    """
    inside = name != ".." and system(name).name == name
    return inside and name.isprintable() and len(name.encode()) <= LONGEST_NAME


def _field(path: Path) -> Field:
    if path.suffix.lower() in (".yaml", ".yml"):
        picture = read_map_yaml(path).text("image")
        # A recording may come from anybody: it must not show pictures of this computer.
        if Path(picture).name != picture:
            raise RecordingError(
                f"the recording's map is the picture {picture!r}; valid is one beside {path.name}"
            )
    return load_field(str(path), MAPS)


def _robot(folder: Path, names: Collection[str]) -> RobotSpec:
    """Return the recorded robot as its profile corrects it, or the program's own."""
    drawn = RobotSpec.load(folder / URDF) if URDF in names else RobotSpec.load()
    return load_profile(folder / PROFILE).applied_to(drawn) if PROFILE in names else drawn


def _config(reader: RecordingReader) -> Config:
    if SETTINGS not in reader.attachments:
        return Config()
    try:
        text = reader.attachments[SETTINGS].decode()
        content = with_new_names(parse_toml(text, SETTINGS))
        taken = {name: content[name] for name in TAKEN if name in content}
        own = {field.name for field in dataclasses.fields(Config)} | {"camera"}
        added = {n: t for n, t in content.items() if n not in own and isinstance(t, dict)}
        return replace(from_table(Config, taken), added=added)
    except (SettingError, UnicodeDecodeError) as error:
        raise RecordingError(f"the settings in {reader.path} cannot be used: {error}") from error


def with_new_names(content: dict[str, Any]) -> dict[str, Any]:
    """Return settings with their present names, also of a recording from before ``[sim]`` existed.

    In such a recording ``[camera]`` is the simulated camera, with names that the settings of the
    real camera have now.
    """
    if "sim" in content:
        return content
    return as_table({_new_name(path): value for path, value in by_path(content).items()}, {})


def _new_name(path: str) -> str:
    """Return the present path of a setting, given its old path; most are the same."""
    if path in NEW_NAMES:
        return NEW_NAMES[path]
    table, dot, name = path.partition(".")
    return f"{NEW_NAMES.get(table, table)}{dot}{name}"


def first_estimate(
    reader: RecordingReader, topics: RecordedTopics, start_ns: int
) -> Hypothesis | None:
    """Return the first usable estimate of the first ten seconds; None if there is none.

    Args:
        start_ns: time of the first tick.
    """
    if not topics.amcl_pose:
        return None
    try:
        for message in reader.messages((topics.amcl_pose,)):
            if message.log_time_ns > start_ns + SOON_NS:
                return None
            _, pose, covariance = pose_and_covariance_of(message.cdr)
            spread = covariance + SINCE
            if np.linalg.eigvalsh(spread)[0] <= 0:
                continue
            return Hypothesis(1.0, pose, spread)
    except (RecordingError, MessageError, ContentError):
        return None
    return None
