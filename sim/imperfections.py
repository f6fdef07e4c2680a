"""Imperfections of real robots that are not in their description; drawn once a run, by seed."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial.transform import Rotation

from robot.description.spec import RobotSpec
from robot.settings import check_settings, setting

BUMPS = ("none", "roll", "pitch", "yaw")
MOUNTING = 2**31
"""Number of the stream for the camera's mounting and lens; no spawned child gets this number."""
LARGEST = 3.0
"""Errors beyond this many standard deviations are drawn again, so that no dimension is absurd."""


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
    camera_angle_sd: float = setting(
        0.0, "Error of the camera's mounting about each of its axes", unit="degree", low=0, high=10
    )
    camera_position_sd: float = setting(
        0.0, "Error of the camera's place along each axis", unit="m", low=0, high=0.05
    )
    focal_length_sd: float = setting(
        0.0, "Relative error of the lens's focal length", low=0, high=0.1
    )
    bump: str = setting(
        "none", "Whether something bumps the camera, and about which axis of the robot it turns",
        choices=BUMPS,
    )  # fmt: skip
    bump_time: float = setting(20.0, "When it is bumped", unit="s", low=0, high=3600)
    bump_angle: float = setting(
        1.0, "How far it turns then (REP-103: nose down, and to the left)", unit="degree",
        low=-10, high=10,
    )  # fmt: skip
    robot: int = setting(
        -1, "Seed of what one robot keeps: wheels, track, mounting; -1 is the run's seed",
        low=-1, high=2**32 - 1,
    )  # fmt: skip
    encoder_step: float = setting(
        1.0, "Angle that the encoders count in; 0 is exact", unit="degree", low=0, high=45
    )

    def __post_init__(self) -> None:
        check_settings(self)

    @classmethod
    def none(cls) -> Imperfections:
        """Return settings of a perfect robot: it is as described, with exact encoders."""
        return cls(wheel_radius_sd=0, track_sd=0, slip_sd=0, encoder_step=0)

    def of_robot(self, rng: np.random.Generator) -> np.random.Generator:
        """Return the generator of a robot's permanent errors: from its own seed, or the run's."""
        return rng if self.robot < 0 else np.random.default_rng(self.robot)


def bumped(spec: RobotSpec, imperfections: Imperfections) -> RobotSpec:
    """Return the robot after its camera was bumped: turned where it is."""
    if imperfections.bump == "none":
        return spec
    axis = np.eye(3)[BUMPS.index(imperfections.bump) - 1]
    turn = Rotation.from_rotvec(math.radians(imperfections.bump_angle) * axis)
    robot_from_camera = spec.robot_from_camera.copy()
    robot_from_camera[:3, :3] = turn.as_matrix() @ robot_from_camera[:3, :3]
    return replace(spec, robot_from_camera=robot_from_camera)


def draw(spec: RobotSpec, imperfections: Imperfections, rng: np.random.Generator) -> RobotSpec:
    """Draw the true robot: other wheel radii, another track, a camera mounted a little askew.

    Errors are normal, cut off at ``LARGEST`` standard deviations. The same seed repeats a run; an
    error that is switched off does not change the others.
    """
    rng = imperfections.of_robot(rng)
    errors = _cut_normal(rng, len(spec.joints) + 1)
    radii = [
        joint.radius * (1 + imperfections.wheel_radius_sd * error)
        for joint, error in zip(spec.joints, errors, strict=False)
    ]
    true = spec.with_wheels(radii, spec.track * (1 + imperfections.track_sd * errors[-1]))
    offset = imperfections.camera_angle_sd, imperfections.camera_position_sd
    if not any((*offset, imperfections.focal_length_sd)):
        return true
    return _askew(true, imperfections, _beside(rng))


def _beside(rng: np.random.Generator) -> np.random.Generator:
    """Return a separate stream, which does not change the draws of ``rng`` and its children."""
    seed = rng.bit_generator.seed_seq
    assert isinstance(seed, np.random.SeedSequence)
    return np.random.default_rng(
        np.random.SeedSequence(seed.entropy, spawn_key=(*seed.spawn_key, MOUNTING))
    )


def _askew(spec: RobotSpec, imperfections: Imperfections, rng: np.random.Generator) -> RobotSpec:
    angles = math.radians(imperfections.camera_angle_sd) * np.array(_cut_normal(rng, 3))
    robot_from_camera = spec.robot_from_camera.copy()
    robot_from_camera[:3, :3] @= Rotation.from_rotvec(angles).as_matrix()
    robot_from_camera[:3, 3] += imperfections.camera_position_sd * np.array(_cut_normal(rng, 3))
    longer = 1 + imperfections.focal_length_sd * _cut_normal(rng, 1)[0]
    matrix = spec.lens.matrix.copy()
    matrix[[0, 1], [0, 1]] *= longer
    lens = replace(spec.lens, matrix=matrix)
    return replace(spec, robot_from_camera=robot_from_camera, lens=lens)


def _cut_normal(rng: np.random.Generator, count: int) -> list[float]:
    errors: list[float] = []
    while len(errors) < count:
        error = float(rng.standard_normal())
        if abs(error) <= LARGEST:
            errors.append(error)
    return errors
