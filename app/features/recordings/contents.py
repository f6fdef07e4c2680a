"""Collects the contents at the beginning of a recording from a program."""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import yaml

from app.engine.added_models import ModelChoice
from app.engine.program import Program
from app.features.recordings.attachments import (
    PROFILE,
    SETTINGS,
    URDF,
    VERSIONS,
    Attachment,
    Contents,
    as_toml,
)
from app.features.recordings.replay.recorded_robot import RecordedRobot
from app.settings.config import MAPS, Config
from app.settings.provenance import versions
from robot.description.spec import RobotSpec
from robot.description.urdf import parse_xml
from robot.fields.map_files import read_map_yaml
from robot.lens_files.camera_info import camera_info


def contents_of(program: Program) -> Contents:
    """Return the facts and files at the beginning of a program's recording.

    Raises:
        OSError, ValueError: a file is missing or unreadable by now.
    """
    latest = program.engine.latest.get()
    config, spec = program.config, program.robot.spec
    if latest is not None:
        config, spec = replace(config, localization=latest.filter.parameters), latest.spec
    known = versions()
    map_files = list(_map_files(config.map) if config.map else _replayed(program, "map/"))
    facts = {
        "robot": program.robot.name,
        "robot_kind": config.robot,
        "engine": program.facts.engine or "",
        "map": program.field.name,
        "map_file": map_files[0].name if map_files else "",
        "seed": str(config.seed),
        # If false, the filter already had an estimate: a replay begins with the first recorded one.
        "from_start": "true" if latest is None else "false",
        "version": known["brickpose"],
        "code": known["code"],
    }
    attachments = (
        Attachment(SETTINGS, as_toml(config).encode()),
        *map_files,
        *(_replayed(program, "robot/") or _robot_files(spec)),
        *_model_files(config, latest.filter.models if latest else program.given),
        Attachment(VERSIONS, json.dumps(known, indent=1).encode()),
    )
    return Contents(facts, attachments)


def _replayed(program: Program, folder: str) -> list[Attachment]:
    """Return attachments of the recording that is replayed, the map's file first."""
    if not isinstance(program.robot, RecordedRobot):
        return []
    reader = program.robot.reader
    first = reader.metadata.get("brickpose", {}).get("map_file", "")
    names = sorted(
        (n for n in reader.attachments if n.startswith(folder)), key=lambda n: n != first
    )
    return [Attachment(name, reader.attachments[name]) for name in names]


def _map_files(name: str) -> Iterator[Attachment]:
    """Yield the map's file first, then the picture that it names."""
    path = Path(name)
    if path.name == name and not path.suffix:
        path = MAPS / f"{name}.svg"
    if path.suffix.lower() == ".svg":
        yield Attachment(f"map/{path.name}", path.read_bytes())
        return
    content = read_map_yaml(path)
    picture = path.parent / content.text("image")
    # The picture may lie anywhere; in the recording it lies beside the map.
    given = yaml.safe_dump({**content.content, "image": picture.name}, sort_keys=False)
    yield Attachment(f"map/{path.name}", given.encode())
    yield Attachment(f"map/{picture.name}", picture.read_bytes())


def _robot_files(spec: RobotSpec) -> Iterator[Attachment]:
    """Yield the robot as drawn, and its profile if it has one."""
    drawn = spec.as_drawn
    yield Attachment(URDF, drawn.urdf.encode())
    if spec.profile:
        yield Attachment(PROFILE, spec.profile.encode())
    for item in parse_xml(drawn.urdf).findall("ros2_control/sensor/param[@name='camera_info']"):
        lens = Path((item.text or "").strip())
        yield Attachment(f"robot/{lens}", camera_info(drawn.lens).encode())


def _model_files(config: Config, choice: ModelChoice) -> Iterator[Attachment]:
    """The user's files of the models in use, which are named ``my_model.py:MyModel``."""
    given = [
        Path(model_file.rpartition(":")[0])
        for model_file in (config.sensor_model, config.motion_model)
    ]
    names = {each.rpartition(":")[0] for each in (choice.sensor, choice.motion) if ":" in each}
    for name in sorted(names):
        places = [item for item in given if item.name == name]
        path = places[0] if places else Path(config.models) / name
        yield Attachment(f"models/{name}", path.read_bytes())
