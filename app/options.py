"""Options that several commands share."""

from __future__ import annotations

import argparse
from dataclasses import replace
from pathlib import Path
from typing import Any

from app.settings.conditions import apply_condition, condition_names
from app.settings.config import Config, load_config
from robot.settings import SettingError

OPTIONS = ("robot", "profile", "host", "port", "seed", "sensor_model", "motion_model", "models")
"""Options that set the top-level settings of the same names."""

START_OPTIONS = ("restore_pose", "pose_file")
"""Options that set the settings of the same names in ``start_pose``."""

ROUTE_OPTIONS = {"ros2": "dds", "foxglove": "foxglove"}
"""Settings of ``ros2`` by the options that set them."""

Commands = Any
"""What ``add_subparsers`` returns."""


class CommandParser(argparse.ArgumentParser):
    """Options are not abbreviated, and one that is not given has no value, not even None.

    So a setting in a file is overridden only by what was typed. Subcommands inherit this.
    """

    def __init__(self, *args: Any, **kwargs: Any) -> None:
        usual: dict[str, Any] = {"argument_default": argparse.SUPPRESS, "allow_abbrev": False}
        super().__init__(*args, **(usual | kwargs))


def add_map(command: argparse.ArgumentParser) -> None:
    """Add the option for the field."""
    command.add_argument(
        "--map",
        metavar="NAME|FILE",
        help="a field of maps/, generated-N (from a seed), or an .svg or .yaml file "
        f"(default: {Config().map})",
    )


def add_condition(command: argparse.ArgumentParser, *, many: bool = False) -> None:
    """Add the option for conditions, which make a simulation worse."""
    repeated = "; may be given more than once" if many else ""
    command.add_argument(
        "--condition",
        metavar="NAME",
        action="append" if many else "store",
        help=f"a named condition that makes a simulation worse{repeated}: {condition_names()} "
        "(default: default)",
    )


def add_profile(command: argparse.ArgumentParser) -> None:
    """Add the option for the robot's profile."""
    command.add_argument(
        "--profile",
        metavar="PROFILE.toml",
        help="what `brickpose calibrate` has measured of the robot; none: it is as described "
        "(default: the real robot's own, see docs/calibration.md)",
    )


def add_config(command: argparse.ArgumentParser) -> None:
    """Add the option for a file of settings."""
    command.add_argument(
        "--config",
        type=Path,
        metavar="FILE.toml",
        help="settings (docs/configuration.md); options win over them",
    )


def add_address(command: argparse.ArgumentParser) -> None:
    """Add the options for the address of the page."""
    default = Config()
    command.add_argument(
        "--host", help=f"address to listen on; 0.0.0.0 is all (default: {default.host})"
    )
    command.add_argument(
        "--port",
        type=int,
        help=f"port to listen on; 0 is any free one (default: {default.port})",
    )


def add_own_models(command: argparse.ArgumentParser) -> None:
    """Add the options for the user's own sensor and motion models."""
    for kind in ("sensor", "motion"):
        command.add_argument(
            f"--{kind}-model",
            metavar="FILE.py:CLASS",
            help=f"a {kind} model of your own, read again when it is saved (docs/own_models.md)",
        )
    command.add_argument(
        "--models", metavar="DIR", help="a folder of models of your own, which the page offers"
    )


def add_serial_port(command: argparse.ArgumentParser) -> None:
    """Add the option for the Build HAT's serial port."""
    command.add_argument(
        "--serial-port",
        metavar="DEVICE",
        help="the Build HAT's serial port (default: that of this Pi)",
    )


def add_camera(command: argparse.ArgumentParser) -> None:
    """Add the option for the real robot's camera."""
    command.add_argument(
        "--camera",
        metavar="SOURCE",
        help="the real robot's camera: pi, /dev/video0, a folder of pictures, a video file "
        "(default: the first that delivers pictures)",
    )


def config_from(parsed: argparse.Namespace) -> Config:
    """Return the configuration of the file, if one is given, overridden by the other options."""
    given = vars(parsed)
    config = config_of(given)
    over = {name: given[name] for name in OPTIONS if name in given}
    over_start = {name: given[name] for name in START_OPTIONS if name in given}
    config = replace(config, start_pose=replace(config.start_pose, **over_start))
    if "serial_port" in given:
        over["build_hat"] = replace(config.build_hat, serial_port=given["serial_port"])
    if "camera" in given:
        over["camera"] = replace(config.camera, source=given["camera"])
    config = replace(config, **over)
    if "record" in given:
        if not given["record"]:
            raise SettingError("--record is ''; valid is a folder")
        recording = replace(config.recording, record=True, folder=given["record"])
        config = replace(config, recording=recording)
    routes = {name: given[option] for option, name in ROUTE_OPTIONS.items() if option in given}
    config = replace(config, ros2=replace(config.ros2, **routes))
    return apply_condition(config, given["condition"]) if "condition" in given else config


def config_of(given: dict[str, Any]) -> Config:
    """Return the configuration of the file, if one is given, overridden by map and profile."""
    config = load_config(given["config"]) if "config" in given else Config()
    return replace(config, **{name: given[name] for name in ("map", "profile") if name in given})
