"""Writes the exported folder, entirely from the robot's description and the settings."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

import yaml

from app.console import say
from app.engine.build import robot_spec
from app.files import make_folder
from app.options import config_of
from app.ros2.export.controllers import controllers
from app.ros2.export.nav2 import nav2
from app.settings.config import MAPS, Config
from robot.calibration.lens.camera_info import camera_info
from robot.description.spec import RobotSpec
from robot.description.urdf import parse_xml
from robot.fields.field_loading import load_field
from robot.fields.grid_map import save_map_yaml

TITLE = "By `brickpose export ros2`, from the robot's description, profile and settings."
MOCK = "mock_components/GenericSystem"
"""ros2_control's own mock of hardware: its wheels follow each command at once."""


def export_ros2(folder: Path, config: Config, plugin: str = MOCK) -> list[Path]:
    """Write description, parameters and map; return the paths of the files.

    Args:
        folder: where to write them; made if it does not exist.
        config: the settings and the map.
        plugin: ros2_control's hardware plugin for the wheels.

    Raises:
        SettingError: the folder cannot be made.
        SpecError: the robot's profile cannot be used.
        OSError: a file cannot be written.
    """
    spec, field = robot_spec(config), load_field(config.map, MAPS)
    for name in ("urdf", "config", "maps"):
        make_folder(folder / name)
    lens = _lens_file(spec)
    grid = field.grid or field.occupancy(config.ros2.map_resolution)
    files = {
        folder / "urdf" / "brickpose.urdf": with_plugin(spec.urdf, plugin),
        folder / "urdf" / lens: camera_info(spec.lens, title=TITLE),
        folder / "config" / "controllers.yaml": _yaml(controllers(spec, config)),
        folder / "config" / "nav2.yaml": _yaml(nav2(spec, config, field)),
    }
    for path, text in files.items():
        path.write_text(text, encoding="utf-8")
    chart = folder / "maps" / f"{field.name}.yaml"
    save_map_yaml(grid, chart)
    return [*files, chart, chart.with_suffix(".pgm")]


def with_plugin(urdf: str, plugin: str) -> str:
    """Replace the description's ros2_control hardware plugin for the wheels."""
    parse_xml(urdf)
    before, tag, after = urdf.partition("<plugin>")
    _, end, rest = after.partition("</plugin>")
    return before + tag + plugin + end + rest


def _lens_file(spec: RobotSpec) -> str:
    named = parse_xml(spec.urdf).find("ros2_control/sensor/param[@name='camera_info']")
    assert named is not None and named.text  # every RobotSpec has a camera
    return named.text.strip()


def _yaml(content: dict[str, Any]) -> str:
    written: str = yaml.safe_dump(content, sort_keys=False, default_flow_style=None, width=100)
    return f"# {TITLE}\n{written}"


def export_command(parsed: argparse.Namespace) -> int:
    """Write the files, and print their paths."""
    given = vars(parsed)
    for path in export_ros2(parsed.folder, config_of(given), given.get("hardware_plugin", MOCK)):
        say(str(path))
    return 0
