"""How robots' profiles, what calibrations have measured, are completed, written and undone."""

from __future__ import annotations

import shutil
import tomllib
from dataclasses import replace
from datetime import UTC, datetime
from pathlib import Path

import numpy as np

from app.files import atomic_file
from robot.description.lens_table import MeasuredLens, table_lines
from robot.description.profile import Profile, load_profile, profile_of
from robot.description.spec import RobotSpec
from robot.description.unknowns import FOCAL, PRIORS, ROTATION, SHIFT
from robot.description.urdf import SpecError
from robot.geometry import Array
from robot.settings import SettingError

BEFORE = ".before"
"""Ends the name of the file that keeps a profile when another one is written over it."""
USUAL_SD = 0.003
"""How exactly a focal length is known whose file does not tell [by itself]."""
CAMERA = slice(ROTATION.start, SHIFT.stop)
"""The unknowns of the mounting."""


def before(path: Path) -> Path:
    """Return the file that keeps the profile from before."""
    return path.with_name(path.name + BEFORE)


def profile_before(path: Path, spec: RobotSpec) -> Profile:
    """Return the profile of a file, or one of nothing if the file does not exist yet.

    Raises:
        SpecError: the file is no profile, or one of another robot: it is not overwritten.
    """
    if not path.exists():
        return Profile.unmeasured(spec.name, "")
    profile = load_profile(path)
    if profile.robot != spec.name:
        raise SpecError(f"{path} is of the robot {profile.robot!r}, not of {spec.name!r}")
    return profile


def with_lens(profile: Profile, lens: MeasuredLens, source: str) -> Profile:
    """Return a profile with another lens.

    The mounting is not known any more: it was measured through the lens before.
    """
    values, sd = profile.values.copy(), profile.sd.copy()
    values[CAMERA] = values[FOCAL] = 0
    focal_sd = lens.sd[:2].mean() / lens.lens.matrix[[0, 1], [0, 1]].mean()
    sd[CAMERA], sd[FOCAL] = PRIORS[CAMERA], focal_sd if np.isfinite(focal_sd) else USUAL_SD
    return _made(replace(profile, values=values, sd=sd, lens=lens), source)


def with_mounting(profile: Profile, values: Array, sd: Array, source: str) -> Profile:
    """Return a profile with another mounting: rotation and shift (6,) of the camera."""
    every, every_sd = profile.values.copy(), profile.sd.copy()
    every[CAMERA], every_sd[CAMERA] = values, sd
    return _made(replace(profile, values=every, sd=every_sd), source)


def write_profile(path: Path, profile: Profile) -> None:
    """Write a profile as a whole; the one before is kept beside it, for ``undo``.

    Raises:
        SpecError: no robot is so, and nobody could read the file; nothing is written.
    """
    text = profile.to_toml()
    profile_of(tomllib.loads(text))
    if path.exists():
        shutil.copyfile(path, before(path))
    with atomic_file(path) as new:
        new.write_text(text, encoding="utf-8")


def write_calibration(path: Path, profile: Profile) -> None:
    """Write what was measured of a running robot, through the lens that it was started with.

    Raises:
        SpecError: the file has another lens by now, or is no profile: it is not overwritten.
        OSError: it cannot be written.
    """
    if path.exists() and _lens_lines(load_profile(path)) != _lens_lines(profile):
        raise SpecError(f"{path} has another lens by now; start again to look through that one")
    write_profile(path, profile)


def _lens_lines(profile: Profile) -> list[str]:
    return [] if profile.lens is None else table_lines(profile.lens)


def undo(path: Path) -> Path | None:
    """Go back to the profile before; return its path, or None if the robot is as described again.

    The two change places, so that undoing twice changes nothing.

    Raises:
        SettingError: there is no profile.
    """
    kept, aside = before(path), path.with_name(path.name + ".aside")
    if not path.exists() and not kept.exists():
        raise SettingError(f"{path} does not exist; brickpose calibrate drive makes one")
    for old, new in ((path, aside), (kept, path), (aside, kept)):
        if old.exists():
            old.replace(new)
    return path if path.exists() else None


def _made(profile: Profile, source: str) -> Profile:
    kept = [part for part in profile.source.split("; ") if part and part[:5] != source[:5]]
    return replace(profile, made=datetime.now(UTC), source="; ".join([*kept, source]))
