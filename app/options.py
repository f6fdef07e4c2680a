"""Options that several commands share."""

from __future__ import annotations

import argparse
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from app.settings.conditions import apply_condition, condition_names
from app.settings.config import Config, load_config

OPTIONS = ("robot", "profile", "host", "port", "seed")
"""Options that set the top-level settings of the same names."""

START_OPTIONS = ("restore_pose", "pose_file")
"""Options that set the settings of the same names in ``start_pose``."""

Commands = Any
"""What ``add_subparsers`` returns."""


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
    if "features" in given:
        config = given["features"].with_run_options(config, given)
    return apply_condition(config, given["condition"]) if "condition" in given else config


def config_of(given: dict[str, Any]) -> Config:
    """Return the configuration of the file, if one is given, overridden by map and profile."""
    config = config_file(given)
    return replace(config, **{name: given[name] for name in ("map", "profile") if name in given})


def config_file(given: Mapping[str, Any]) -> Config:
    """Return the configuration of the file, if one is given; else the defaults."""
    if given.get("config") is None:
        return Config()
    features = given.get("features")
    if features is None:
        return load_config(given["config"])
    return load_config(given["config"], features.settings, features.left_out)
