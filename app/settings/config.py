"""The program's configuration: one tree of frozen values, filled from TOML and the command line.

No module imports a settings object: settings are passed as arguments.
"""

from __future__ import annotations

import dataclasses
import functools
import json
from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, NoReturn, TypeVar, get_args, get_type_hints

from pydantic import TypeAdapter, ValidationError

from app.settings.groups import (
    FeatureSettings,
    MappingSettings,
    RecordingSettings,
    Ros2Settings,
    StartPoseSettings,
)
from robot.cameras.settings import CameraSourceSettings
from robot.driving.drive_controller import DriveSettings
from robot.driving.figure_eight import FigureEight
from robot.driving.odometry import OdometrySettings
from robot.hat.settings import BuildHatSettings
from robot.localization.parameters import LocalizationParameters
from robot.scanning.line_scanner import LineScannerSettings
from robot.settings import SettingError, check_names, check_settings, describe, setting
from robot.toml_file import read_toml
from sim.floor_camera import CameraSettings
from sim.simulated import SimSettings

NEW_NAMES: Mapping[str, str] = MappingProxyType(
    {
        "camera_source": "camera.source",
        "pictures": "camera",
        "physics": "sim.physics",
        "ros2.foxglove_port": "port",
        "imperfections": "sim.imperfections",
        **{f"camera.{name}": f"sim.camera.{name}" for name in describe(CameraSettings)},
    }
)
"""New paths of settings and tables, by their old paths."""

if TYPE_CHECKING:
    from _typeshed import DataclassInstance

ROOT = Path(__file__).resolve().parents[2]
_PARTS = next(
    (folder for folder in (ROOT / "brickpose", ROOT) if (folder / "frontend").is_dir()), ROOT
)
"""Folder of what is not Python: a wheel has it in the package, a checkout beside it."""
MAPS = _PARTS / "maps"
FRONTEND = _PARTS / "frontend"
DOCS = _PARTS / "docs"

AUTO = "auto"
"""Chooses a robot, or an engine of physics, that is available."""

UNKNOWN = "unexpected_keyword_argument"
"""Pydantic's error type for a name that is not a field."""

PLAIN = {int: "a whole number", float: "a number", str: "a text", bool: "true or false"}
"""Types of settings, as messages call them."""

T = TypeVar("T", bound="DataclassInstance")


@dataclass(frozen=True)
class Config:
    """Everything that can be set; each table of the TOML file is a field."""

    robot: str = setting(
        AUTO,
        "Which robot: sim, with physics; kinematic, without: its wheels roll as if on rails; "
        "buildhat, the real one; or one of a feature; auto is sim where physics is installed",
    )
    map: str = setting(
        "square", "A field of maps/, generated-N (from a seed), or a file (.svg, .yaml)"
    )
    host: str = setting("127.0.0.1", "Address to listen on; 0.0.0.0 is all")
    port: int = setting(8080, "Port to listen on; 0 is any free one", low=0, high=65535)
    allowed_origins: tuple[str, ...] = setting(
        (),
        "Other sites whose pages may talk to the robot, as http://localhost:5500; null: from files",
    )
    seed: int = setting(0, "Seed of everything random", low=0, high=2**32 - 1)
    sensor_model: str = setting(
        "", "A sensor model of your own, FILE.py:CLASS, read again when saved (docs/own_models.md)"
    )
    motion_model: str = setting(
        "", "A motion model of your own, FILE.py:CLASS, read again when saved (docs/own_models.md)"
    )
    models: str = setting("", "A folder of models of your own, which the page offers")
    profile: str = setting(
        "",
        "What `brickpose calibrate` has measured of the robot, a TOML file; none: it is as "
        "described (without a setting: a real robot's own, see docs/calibration.md)",
    )
    drive: DriveSettings = DriveSettings()
    figure_eight: FigureEight = FigureEight()
    odometry: OdometrySettings = OdometrySettings()
    scanner: LineScannerSettings = LineScannerSettings()
    localization: LocalizationParameters = LocalizationParameters()
    mapping: MappingSettings = MappingSettings()
    recording: RecordingSettings = RecordingSettings()
    ros2: Ros2Settings = Ros2Settings()
    start_pose: StartPoseSettings = StartPoseSettings()
    features: FeatureSettings = FeatureSettings()
    build_hat: BuildHatSettings = BuildHatSettings()
    camera: CameraSourceSettings = CameraSourceSettings()
    sim: SimSettings = SimSettings()
    added: Mapping[str, Mapping[str, Any]] = dataclasses.field(default_factory=dict, hash=False)
    """What a file says in the tables of other packages' features, by the features' names."""

    def __post_init__(self) -> None:
        check_settings(self)

    def group(self, feature: str, default: T) -> T:
        """Return the settings of a feature of another package.

        Args:
            feature: its name, which is that of its table in a file.
            default: its settings, as they are where the file says nothing.

        Raises:
            SettingError: a setting is unknown, of the wrong type or out of range.
        """
        table = self.added.get(feature, {})
        if not isinstance(table, Mapping):
            raise SettingError(f"{feature} is {table!r}; valid is a table")
        try:
            return with_settings(default, by_path(dict(table)))
        except SettingError as error:
            raise SettingError(f"[{feature}] {error}") from error


def by_path(table: dict[str, Any], path: str = "") -> dict[str, Any]:
    """Return the settings in a table and its subtables, by their path as in ``with_settings``."""
    result: dict[str, Any] = {}
    for name, value in table.items():
        if isinstance(value, dict):
            result |= by_path(value, f"{path}{name}.")
        else:
            result[f"{path}{name}"] = value
    return result


def load_config(
    path: Path, added: Mapping[str, Any] = MappingProxyType({}), ignored: Collection[str] = ()
) -> Config:
    """Read a TOML file.

    Args:
        path: the file.
        added: settings of features, with their defaults, by their tables' names.
        ignored: names of tables that say nothing now: of features that are left out.

    Raises:
        SettingError: the file is missing or is not TOML, or a key is misspelt or out of range; the
            message names the key's path and what is valid.
    """
    content = read_toml(path)
    ours = require_free(added)
    for name in set(ignored) - ours:
        content.pop(name, None)
    own = {name: content.pop(name) for name in added if name in content}
    try:
        _require_known(content.keys(), (ours - {"added"}) | set(added))
        config = from_table(Config, content)
        config = replace(config, added={**config.added, **own})
        for name in own:
            config.group(name, added[name])
        return config
    except SettingError as error:
        raise SettingError(f"{path}: {error}") from error


def require_free(added: Iterable[str]) -> set[str]:
    """Return the names of our own settings and tables.

    Raises:
        SettingError: a feature's table has one of them.
    """
    ours = {field.name for field in dataclasses.fields(Config)}
    for name in ours.intersection(added):
        raise SettingError(f"a feature cannot have the settings [{name}]: they are the program's")
    return ours


def _require_known(names: Iterable[str], valid: Collection[str]) -> None:
    renamed = {path.partition(".")[0] for path in NEW_NAMES}
    for name in names:
        if name not in valid and name not in renamed:
            raise SettingError(f"{name} is unknown; valid are {', '.join(sorted(valid))}")


def from_table(group: type[T], table: Mapping[str, Any]) -> T:
    """Build a dataclass, and the dataclasses nested in it, from a table of a TOML file.

    Raises:
        SettingError: a key is unknown, of the wrong type or out of range.
    """
    # Validate as JSON: its strict types are TOML's (tables, lists, an int for a float). JSON has no
    # dates, and no setting is a date: a date becomes null, which is refused.
    try:
        text = json.dumps(table, default=lambda _: None)
    except ValueError as error:  # hexadecimal numbers may have thousands of digits
        raise SettingError(f"a number is too long: {error}") from error
    try:
        result: T = _adapter(group).validate_json(text, strict=True, extra="forbid")
    except ValidationError as error:
        _refuse(group, table, error)
    return result


def with_settings(group: T, settings: Mapping[str, Any]) -> T:
    """Return a dataclass with some settings replaced; their paths are as ``table.table.name``.

    Raises:
        SettingError: a setting is unknown, of the wrong type or out of range.
    """
    return from_table(type(group), as_table(settings, dataclasses.asdict(group)))


def as_table(settings: Mapping[str, Any], table: dict[str, Any]) -> dict[str, Any]:
    """Put settings, given by their path, into a table and return it; the inverse of ``by_path``.

    Raises:
        SettingError: a path uses a setting as a table.
    """
    for path, value in settings.items():
        *tables, name = path.split(".")
        inner = table
        for depth, part in enumerate(tables, 1):
            inner = inner.setdefault(part, {})
            if not isinstance(inner, dict):
                way, rest = ".".join(tables[:depth]), ".".join((*tables[depth:], name))
                raise SettingError(f"{way} is no table; {rest} cannot be in it")
        inner[name] = value
    return table


@functools.cache
def _adapter(group: type[Any]) -> TypeAdapter[Any]:
    return TypeAdapter(group)


def _refuse(group: type[Any], table: Mapping[str, Any], error: ValidationError) -> NoReturn:
    """Raise a SettingError for the first error, in our words; unknown names come before others."""
    fault = min(error.errors(include_url=False), key=lambda fault: fault["type"] != UNKNOWN)
    kind, place, path = fault["type"], fault["loc"], _path(fault["loc"])
    if kind == UNKNOWN and group is Config and path in NEW_NAMES:
        raise SettingError(f"{path} is now {NEW_NAMES[path]}") from error
    if kind == UNKNOWN:
        table_type = _type_at(group, place[:-1])
        check_names(table_type, [str(place[-1])], _path((*place[:-1], "")))
    if kind == "value_error":
        raise SettingError(f"{_path((*place, ''))}{fault['ctx']['error']}") from error
    if not place:
        raise SettingError(fault["msg"]) from error
    value = "missing" if kind == "missing" else repr(_value_at(table, place))
    valid = _valid(_type_at(group, place), path)
    raise SettingError(f"{path} is {value}; valid is {valid}") from error


def _path(place: tuple[int | str, ...]) -> str:
    """Format a location as ``table.table.name`` or ``name[0]``; a last part "" gives ``table.``."""
    return "".join(f"[{part}]" if isinstance(part, int) else f".{part}" for part in place)[1:]


def _value_at(table: Any, place: tuple[int | str, ...]) -> Any:
    return functools.reduce(lambda inner, part: inner[part], place, table)


def _type_at(group: Any, place: tuple[int | str, ...]) -> Any:
    for part in place:
        group = get_args(group)[0] if isinstance(part, int) else get_type_hints(group)[part]
    return group


def _valid(wanted: Any, path: str) -> str:
    """Return the name of a type, as messages use it."""
    if dataclasses.is_dataclass(wanted):
        return f"a table, as in [{path}]"
    return "a list" if get_args(wanted) else PLAIN.get(wanted, f"a {wanted.__name__}")
