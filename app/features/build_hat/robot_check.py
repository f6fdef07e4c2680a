"""Checks of the robot: do pictures come, how often and how old; is it calibrated."""

from __future__ import annotations

import statistics
import time
from collections.abc import Iterator
from datetime import UTC, datetime
from pathlib import Path

from app.tools.doctor.finding import Finding, ok, problem, sentence, warning
from robot.camera import Lens
from robot.cameras.camera import Camera, SourceError
from robot.cameras.choice import open_camera
from robot.cameras.settings import CameraSourceSettings
from robot.description.profile import load_profile
from robot.description.spec import RobotSpec
from robot.description.urdf import SpecError
from robot.estimation.fit_quality import FitQuality

START_S = 8.0
"""How long the first picture may take [s]: a search for a camera opens one after another."""

WATCH_S = 1.0
LOOK_S = 0.002

SLOW = 0.8
"""A lower share of the frame rate than this gets a warning."""

OLD_S = 0.15
"""Pictures that are older on arrival are late [s]; the robot drives 45 mm in this time."""
OLD_DAYS = 180
"""A profile older than this gets a warning: tyres wear, and masts are bumped."""


def check_camera(
    lens: Lens, settings: CameraSourceSettings, patience: float = START_S
) -> Iterator[Finding]:
    """Take pictures for a second and check their rate and age.

    Args:
        lens: gives the size of the pictures.
        settings: which camera to use, and how it takes pictures.
        patience: how long the first picture may take [s].
    """
    try:
        camera = open_camera(lens, settings)
    except SourceError as error:
        yield problem(sentence(str(error)))
        return
    try:
        yield from _watched(camera, lens, settings.frame_rate, patience)
    finally:
        camera.close()


def _watched(camera: Camera, lens: Lens, frame_rate: float, patience: float) -> Iterator[Finding]:
    ages: list[float] = []
    end = time.monotonic() + patience
    while (clock := time.monotonic()) < end:
        frame = camera.newest()
        if frame is None:
            time.sleep(LOOK_S)
            continue
        if not ages:
            end = clock + WATCH_S
        ages.append(clock - frame.stamp)
    if not ages:
        yield problem(sentence(camera.problem or f"{camera.name} sends no pictures"))
        return
    yield pictures(camera.name, lens, (len(ages) - 1) / WATCH_S, frame_rate)
    yield age(statistics.median(ages))


def pictures(name: str, lens: Lens, rate: float, wanted: float) -> Finding:
    """Check that enough pictures come: ``rate`` of the ``wanted`` ones a second."""
    given = f"{sentence(name)}: {lens.width} x {lens.height}, {rate:.0f} pictures/s"
    if rate < SLOW * wanted:
        return warning(
            f"{given} of {wanted:g}", "more light, or a lower frame_rate in [camera] of --config"
        )
    return ok(given)


def age(seconds: float) -> Finding:
    """Check that pictures arrive soon, with stamps from the same clock as the wheels'."""
    given = f"Pictures are {1000 * seconds:.0f} ms old when they come"
    if seconds < 0:
        return problem(f"{given}: their stamps are of another clock")
    if seconds > OLD_S:
        return warning(given, "end other programs; a camera with time stamps is quicker to know")
    return ok(given)


def check_profile(path: Path | None, spec: RobotSpec, today: datetime | None = None) -> Finding:
    """Check that the robot was measured, not long ago, and that the profile is its own.

    Args:
        path: the profile; None if there is none.
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
    doubts = FitQuality.of_table(profile.fit).remarks
    if doubts:
        return warning(f"The {words}: {'; '.join(doubts)}", "run brickpose calibrate drive")
    if days > OLD_DAYS:
        return warning(f"The {words}, is {days} days old", "run brickpose calibrate drive")
    if days < -1:
        return warning(f"The {words}, is from the future", "set the clock")
    return ok(f"P{words[1:]}")
