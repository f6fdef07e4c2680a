"""What real robots have and their description does not say: drawn once a run, by seed."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from robot.description.spec import RobotSpec
from robot.settings import check_settings, setting


@dataclass(frozen=True)
class Imperfections:
    """How far the true robot may be from its description; standard deviations unless named."""

    wheel_radius_sd: float = setting(
        0.01,
        "Relative error of each wheel's radius: tyres wear and are pressed flat",
        low=0,
        high=0.1,
    )
    track_sd: float = setting(
        0.02,
        "Relative error of the distance between the wheels: tyres are broad, axles have play",
        low=0,
        high=0.1,
    )
    slip_sd: float = setting(
        0.02,
        "Relative error between what a wheel turned and what it rolled; drifts slowly",
        low=0,
        high=0.5,
    )
    slip_time: float = setting(
        1.0, "Time over which slip forgets what it was", unit="s", low=0.01, high=100
    )
    encoder_step: float = setting(
        1.0, "Angle that the encoders count in; 0 is exact", unit="degree", low=0, high=45
    )

    def __post_init__(self) -> None:
        check_settings(self)

    @classmethod
    def none(cls) -> Imperfections:
        """The robot as described, with exact encoders."""
        return cls(wheel_radius_sd=0, track_sd=0, slip_sd=0, encoder_step=0)


LARGEST = 3.0
"""Errors are drawn anew beyond this many standard deviations, so that no dimension turns absurd."""


def draw(spec: RobotSpec, imperfections: Imperfections, rng: np.random.Generator) -> RobotSpec:
    """The true robot: the described one with other wheel radii and another track.

    Errors are normal, cut off at ``LARGEST`` standard deviations. A run is repeated by the same
    seed; what is switched off does not change what the rest draws.
    """
    errors = _cut_normal(rng, len(spec.joints) + 1)
    radii = [
        joint.radius * (1 + imperfections.wheel_radius_sd * error)
        for joint, error in zip(spec.joints, errors, strict=False)
    ]
    return spec.with_wheels(radii, spec.track * (1 + imperfections.track_sd * errors[-1]))


def _cut_normal(rng: np.random.Generator, count: int) -> list[float]:
    errors: list[float] = []
    while len(errors) < count:
        error = float(rng.standard_normal())
        if abs(error) <= LARGEST:
            errors.append(error)
    return errors
