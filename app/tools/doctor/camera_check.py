"""Checks of the camera: whether pictures come, how often, and how old they are."""

from __future__ import annotations

import statistics
import time
from collections.abc import Iterator

from app.tools.doctor.finding import Finding, ok, problem, sentence, warning
from robot.camera import Lens
from robot.cameras.camera import Camera
from robot.cameras.choice import open_camera
from robot.cameras.settings import CameraSourceSettings

START_S = 8.0
"""How long the first picture may take [s]: a camera that is looked for opens one after another."""

WATCH_S = 1.0
LOOK_S = 0.002

SLOW = 0.8
"""Fewer pictures than this share of the frame rate are too few."""

OLD_S = 0.15
"""Pictures that are older when they come are late [s]; the robot drives 45 mm meanwhile."""


def check_camera(
    lens: Lens, settings: CameraSourceSettings, patience: float = START_S
) -> Iterator[Finding]:
    """Take pictures for a second.

    Args:
        lens: tells their size.
        settings: which camera, and how they are asked for.
        patience: how long the first may take [s].
    """
    try:
        camera = open_camera(lens, settings)
    except ValueError as error:
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
    """Whether enough pictures come: ``rate`` of ``wanted`` a second."""
    given = f"{sentence(name)}: {lens.width} x {lens.height}, {rate:.0f} pictures/s"
    if rate < SLOW * wanted:
        return warning(
            f"{given} of {wanted:g}", "more light, or a lower frame_rate in [camera] of --config"
        )
    return ok(given)


def age(seconds: float) -> Finding:
    """Whether pictures are stamped by the clock that the wheels are, and come soon."""
    given = f"Pictures are {1000 * seconds:.0f} ms old when they come"
    if seconds < 0:
        return problem(f"{given}: their stamps are of another clock")
    if seconds > OLD_S:
        return warning(given, "end other programs; a camera with time stamps is quicker to know")
    return ok(given)
