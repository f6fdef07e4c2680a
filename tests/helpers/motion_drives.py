"""A varied drive, and true poses drawn beside its odometry by a motion model with known alphas."""

from __future__ import annotations

import numpy as np

from app.features.lab.model_fits.motions import STEP, DriveCorrection, MotionRun, chained
from robot.geometry import Pose2, Twist2, compose
from robot.localization.models.odometry_motion import DifferentialMotion

TWISTS = (
    Twist2(0.15, 0.0),
    Twist2(0.15, 0.8),
    Twist2(0.0, 1.2),
    Twist2(-0.1, 0.0),
    Twist2(0.2, -0.7),
    Twist2(0.0, -1.5),
    Twist2(0.1, 0.3),
)
"""Straight on and back, turns on the spot, arcs; two seconds each."""

SECONDS_EACH = 2.0


def varied_steps(seconds: float, step: float = STEP) -> list[Pose2]:
    count = round(seconds / step)
    kinds = [int(tick * step / SECONDS_EACH) % len(TWISTS) for tick in range(count)]
    each = [twist.integrate(step) for twist in TWISTS]
    return [each[kind] for kind in kinds]


def drawn_runs(
    model: DifferentialMotion,
    count: int,
    seconds: float,
    rng: np.random.Generator,
    floors: tuple[float, float] = (0.0, 0.0),
    correction: DriveCorrection | None = None,
) -> list[MotionRun]:
    """The same odometry so many times, truth drawn anew for each; floors by normal errors.

    With a correction truth is drawn about odometry that was corrected by it.
    """
    steps = np.array([moved.to_array() for moved in varied_steps(seconds)])
    mean = steps if correction is None else correction.corrected(steps)
    truth = np.zeros((len(steps) + 1, count, 3))
    for tick, moved in enumerate(mean):
        truth[tick + 1] = model.sample(truth[tick], Pose2.from_array(moved), rng)
    noise = np.array([floors[0], floors[0], floors[1]]) * rng.standard_normal(truth.shape)
    stamps, odometry = STEP * np.arange(len(steps) + 1), chained(steps)
    return [
        MotionRun(f"drive {k}", stamps, odometry, compose(truth[:, k], noise[:, k]))
        for k in range(count)
    ]
