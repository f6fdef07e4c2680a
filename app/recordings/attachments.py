"""What a replay needs besides the messages: settings, map, robot, models and versions.

The names of the attachments are paths in a folder in which everything finds its neighbours:

    settings.toml             all settings, as they were when the recording began
    map/square.svg            or a ROS map: the YAML file and its picture
    robot/robot.urdf          and the lens file that it names
    models/my_model.py        models of the user's own that were in use
    versions.json             of the program and of what it computes with
"""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path

SETTINGS = "settings.toml"
URDF = "robot/robot.urdf"
VERSIONS = "versions.json"

MEDIA_TYPES = {
    ".toml": "application/toml",
    ".json": "application/json",
    ".svg": "image/svg+xml",
    ".png": "image/png",
    ".yaml": "application/yaml",
    ".urdf": "application/xml",
    ".py": "text/x-python",
}


@dataclass(frozen=True, slots=True)
class Attachment:
    """A file within a recording."""

    name: str
    """A path in the folder of all of them."""
    data: bytes = field(repr=False)

    @property
    def media_type(self) -> str:
        """By its ending."""
        return MEDIA_TYPES.get(Path(self.name).suffix.lower(), "application/octet-stream")


@dataclass(frozen=True, slots=True)
class Contents:
    """What a recording begins with."""

    facts: dict[str, str]
    """What is worth knowing at a glance."""
    attachments: tuple[Attachment, ...] = ()
