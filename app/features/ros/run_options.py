"""The options of ``run`` for routes to ROS 2."""

from __future__ import annotations

from argparse import ArgumentParser
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from app.settings.config import Config

SETTINGS = {"ros2": "dds", "foxglove": "foxglove"}
"""Settings of ``ros2`` by the options that set them."""


def add(run: ArgumentParser) -> None:
    """Add the options."""
    run.add_argument(
        "--ros2", action="store_true", help="join ROS 2 as a node, over DDS (docs/ros2.md)"
    )
    run.add_argument(
        "--foxglove",
        action="store_true",
        help="serve Foxglove, at /foxglove on the same port (docs/ros2.md)",
    )


def apply(config: Config, given: Mapping[str, Any]) -> Config:
    """Return the settings with what was typed."""
    routes = {name: given[option] for option, name in SETTINGS.items() if option in given}
    return replace(config, ros2=replace(config.ros2, **routes))
