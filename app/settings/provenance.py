"""Provenance of a result: code, libraries and settings."""

from __future__ import annotations

import dataclasses
import functools
import hashlib
import platform
from importlib import metadata
from typing import Any

from app.settings.config import ROOT, Config

LIBRARIES = ("numpy", "scipy", "numba", "opencv-python-headless", "pybullet", "mujoco-core")
SOURCES = ("robot", "sim", "app")


@functools.cache
def code_version() -> str:
    """Return a short digest of the files that decide a run: sources, descriptions and maps."""
    digest = hashlib.sha256()
    for folder in (*SOURCES, "maps"):
        for path in sorted((ROOT / folder).rglob("*")):
            if path.suffix in (".py", ".urdf", ".yaml", ".svg", ".pgm", ".png"):
                digest.update(path.relative_to(ROOT).as_posix().encode() + b"\0")
                digest.update(path.read_bytes())
    return digest.hexdigest()[:16]


def versions() -> dict[str, str]:
    """Return the versions of Python, the program, its libraries for computation, and its code."""
    result = {"python": platform.python_version(), "brickpose": metadata.version("brickpose")}
    for name in LIBRARIES:
        try:
            result[name] = metadata.version(name)
        except metadata.PackageNotFoundError:
            result[name] = "not installed"
    return result | {"code": code_version()}


def settings_of(group: Any, path: str = "") -> dict[str, Any]:
    """Return all settings of a tree of dataclasses, by their path as in a TOML file."""
    result: dict[str, Any] = {}
    for field in dataclasses.fields(group):
        value = getattr(group, field.name)
        if dataclasses.is_dataclass(value):
            result |= settings_of(value, f"{path}{field.name}.")
        else:
            result[f"{path}{field.name}"] = value
    return result


def changed_settings(config: Config) -> dict[str, Any]:
    """Return the settings that differ from their defaults, but for what results name apart."""
    default = settings_of(Config())
    elsewhere = ("robot", "host", "port", "seed", "sim.engine")
    return {
        path: value
        for path, value in settings_of(config).items()
        if value != default[path] and path not in elsewhere
    }
