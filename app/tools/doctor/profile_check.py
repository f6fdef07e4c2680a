"""Checks what calibrations have measured of the robot."""

from __future__ import annotations

from datetime import UTC, datetime
from pathlib import Path

from app.tools.doctor.finding import Finding, ok, problem, warning
from robot.calibration.profile import load_profile
from robot.description.spec import RobotSpec
from robot.description.urdf import SpecError

OLD_DAYS = 180
"""A profile older than this is told: tyres wear, and masts are bumped."""


def check_profile(path: Path | None, spec: RobotSpec, today: datetime | None = None) -> Finding:
    """Check that the robot was measured, not long ago, and that the profile is its own.

    Args:
        path: the profile; None if there is none.
        spec: the robot as described.
        today: the date; by default today's.
    """
    if path is None:
        return warning("The robot was never calibrated", "run brickpose calibrate drive")
    try:
        profile = load_profile(path)
        profile.applied_to(spec)
    except SpecError as error:
        return problem(f"The profile cannot be used: {error}", "run brickpose calibrate drive")
    days = ((today or datetime.now(UTC)) - profile.made.astimezone(UTC)).days
    words = f"profile of {profile.made:%Y-%m-%d}, by {profile.source or 'nobody knows what'}"
    if days > OLD_DAYS:
        return warning(f"The {words}, is {days} days old", "run brickpose calibrate drive")
    if days < -1:
        return warning(f"The {words}, is from the future", "set the clock")
    return ok(f"P{words[1:]}")
