"""The program's configuration: one tree of frozen values, filled from TOML and the command line.

Nobody imports a settings object: what is needed is passed as an argument.
"""

from __future__ import annotations

import dataclasses
import tomllib
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar, get_args, get_origin, get_type_hints

from app.settings.recording import RecordingSettings
from app.settings.ros2 import Ros2Settings
from app.settings.start_pose import StartPoseSettings
from robot.cameras.settings import CameraSourceSettings
from robot.driving.drive_controller import DriveSettings
from robot.driving.figure_eight import FigureEight
from robot.driving.odometry import OdometrySettings
from robot.hat.settings import BuildHatSettings
from robot.localization.parameters import LocalizationParameters
from robot.scanning.line_scanner import LineScannerSettings
from robot.settings import SettingError, check_names, check_settings, setting
from sim.bullet import BulletSettings
from sim.floor_camera import CameraSettings
from sim.imperfections import Imperfections

ROOT = Path(__file__).resolve().parents[2]
MAPS = ROOT / "maps"
FRONTEND = ROOT / "frontend"

ROBOTS = ("sim", "kinematic", "buildhat")

T = TypeVar("T")


@dataclass(frozen=True)
class Config:
    """Everything that can be set; each table of the TOML file is a field."""

    robot: str = setting("auto", "Which robot", choices=("auto", *ROBOTS))
    map: str = setting(
        "square", "A field by name, generated-N (from a seed), or a file (.svg, .yaml)"
    )
    host: str = setting("127.0.0.1", "Address to listen on")
    port: int = setting(8080, "Port to listen on", low=0, high=65535)
    allowed_origins: tuple[str, ...] = setting(
        (),
        "Pages of other places that may talk to the robot, as http://localhost:5500; null is files",
    )
    seed: int = setting(0, "Seed of everything random", low=0, high=2**32 - 1)
    sensor_model: str = setting("", "A sensor model of your own, as FILE.py:CLASS")
    motion_model: str = setting("", "A motion model of your own, as FILE.py:CLASS")
    models: str = setting("", "A folder of models of your own, which the page offers")
    camera_source: str = setting(
        "auto", "The real robot's camera: auto, pi, /dev/video0, a folder of pictures, a video file"
    )
    drive: DriveSettings = DriveSettings()
    figure_eight: FigureEight = FigureEight()
    odometry: OdometrySettings = OdometrySettings()
    scanner: LineScannerSettings = LineScannerSettings()
    localization: LocalizationParameters = LocalizationParameters()
    recording: RecordingSettings = RecordingSettings()
    ros2: Ros2Settings = Ros2Settings()
    start_pose: StartPoseSettings = StartPoseSettings()
    build_hat: BuildHatSettings = BuildHatSettings()
    pictures: CameraSourceSettings = CameraSourceSettings()
    camera: CameraSettings = CameraSettings()
    physics: BulletSettings = BulletSettings()
    imperfections: Imperfections = Imperfections()

    def __post_init__(self) -> None:
        check_settings(self)


def read_toml(path: Path) -> dict[str, Any]:
    """The tables of a TOML file.

    Raises:
        SettingError: it cannot be read or is no TOML.
    """
    try:
        return tomllib.loads(path.read_text(encoding="utf-8"))
    except (OSError, UnicodeDecodeError) as error:
        raise SettingError(f"{path} cannot be read: {error}") from error
    except tomllib.TOMLDecodeError as error:
        raise SettingError(f"{path} is no TOML: {error}") from error


def by_path(table: dict[str, Any], path: str = "") -> dict[str, Any]:
    """The settings in a table and the tables in it, as ``with_settings`` names them."""
    found: dict[str, Any] = {}
    for name, value in table.items():
        if isinstance(value, dict):
            found |= by_path(value, f"{path}{name}.")
        else:
            found[f"{path}{name}"] = value
    return found


def load_config(path: Path) -> Config:
    """Read a TOML file.

    Raises:
        SettingError: the file is missing or no TOML, or a key is misspelt or out of range; the
            message has the key's path and what is valid.
    """
    content = read_toml(path)
    try:
        return from_table(Config, content)
    except SettingError as error:
        raise SettingError(f"{path}: {error}") from error


def from_table(group: type[T], table: dict[str, Any], path: str = "") -> T:
    """A dataclass from a table of a TOML file, and its tables likewise.

    Raises:
        SettingError: a key is unknown, of the wrong type or out of range.
    """
    check_names(group, table, path)
    types = get_type_hints(group)
    values = {name: _value(types[name], value, f"{path}{name}") for name, value in table.items()}
    try:
        return group(**values)
    except SettingError as error:
        raise SettingError(f"{path}{error}") from error


def with_settings(group: T, settings: dict[str, Any], path: str = "") -> T:
    """A dataclass with some settings replaced, named by their path as ``table.table.name``.

    Raises:
        SettingError: a setting is unknown, of the wrong type or out of range.
    """
    here: dict[str, Any] = {}
    below: dict[str, dict[str, Any]] = {}
    for name, value in settings.items():
        first, _, rest = name.partition(".")
        if rest:
            below.setdefault(first, {})[rest] = value
        else:
            here[first] = value
    check_names(group, (*here, *below), path)
    types = get_type_hints(type(group))
    changed = {name: _value(types[name], value, f"{path}{name}") for name, value in here.items()}
    for name, values in below.items():
        old = getattr(group, name)
        if not dataclasses.is_dataclass(old):
            raise SettingError(f"{path}{name} is no table; {min(values)} cannot be in it")
        changed[name] = with_settings(old, values, f"{path}{name}.")
    try:
        return dataclasses.replace(group, **changed)  # type: ignore[type-var]
    except SettingError as error:
        raise SettingError(f"{path}{error}") from error


def _value(wanted: Any, value: Any, path: str) -> Any:
    if dataclasses.is_dataclass(wanted):
        if not isinstance(value, dict):
            raise SettingError(f"{path} is {value!r}; valid is a table, as in [{path}]")
        return from_table(wanted, value, f"{path}.")  # type: ignore[arg-type]
    if get_origin(wanted) is tuple:
        return _tuple(wanted, value, path)
    if wanted is float and isinstance(value, int) and not isinstance(value, bool):
        return float(value)
    if type(value) is not wanted:
        raise SettingError(f"{path} is {value!r}; valid is a {wanted.__name__}")
    return value


def _tuple(wanted: Any, value: Any, path: str) -> tuple[Any, ...]:
    if not isinstance(value, list):
        raise SettingError(f"{path} is {value!r}; valid is a list")
    kind = get_args(wanted)[0]
    return tuple(_value(kind, one, f"{path}[{place}]") for place, one in enumerate(value))
