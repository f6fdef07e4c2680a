"""The unknowns of a calibration: how the built robot may differ from its description."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from scipy.spatial.transform import Rotation

from robot.description.spec import RobotSpec
from robot.geometry import Array


@dataclass(frozen=True, slots=True)
class Unknown:
    """One number of the robot that is measured."""

    name: str
    unit: str
    """Unit in which people read it."""
    scale: float
    """Values in that unit are the solver's (SI or relative) times this."""
    prior: float
    """Standard deviation of a robot built by hand, in the solver's unit."""


DEGREE = math.degrees(1.0)

UNKNOWNS = (
    Unknown("camera_roll", "degree", DEGREE, math.radians(2.25)),
    Unknown("camera_pitch", "degree", DEGREE, math.radians(2.25)),
    Unknown("camera_yaw", "degree", DEGREE, math.radians(2.25)),
    Unknown("camera_x", "mm", 1e3, 0.0075),
    Unknown("camera_y", "mm", 1e3, 0.0075),
    Unknown("camera_z", "mm", 1e3, 0.0075),
    Unknown("focal_length", "%", 1e2, 0.03),
    Unknown("picture_delay", "ms", 1e3, 0.060),
    Unknown("left_radius", "%", 1e2, 0.045),
    Unknown("right_radius", "%", 1e2, 0.045),
    Unknown("wheel_separation", "%", 1e2, 0.075),
    Unknown("tape_width", "mm", 1e3, 0.001),
    Unknown("lens_error_0", "px", 1.0, 0.03),
    Unknown("lens_error_1", "px", 1.0, 0.03),
    Unknown("lens_error_2", "px", 1.0, 0.03),
)
"""All unknowns, as differences from the description.

The camera is turned about the robot's axes, as a rotation vector, and shifted along them; focal
length, radii and separation are relative. The tape's width is the floor's. No lens file is exact:
the last are what it is off in the rows of the picture, as a polynomial over half the height.
Without them, height and place of the camera would seem better known than they are."""

ROBOT = len(UNKNOWNS) - 4
"""The first unknowns are of the robot itself."""
COUNT = len(UNKNOWNS)
PRIORS = np.array([unknown.prior for unknown in UNKNOWNS])
ROTATION, SHIFT = slice(0, 3), slice(3, 6)
FOCAL, DELAY, LEFT, RIGHT, SEPARATION, TAPE = range(6, 12)
LENS = slice(12, COUNT)
NAMES = tuple(unknown.name for unknown in UNKNOWNS)


@dataclass(frozen=True, eq=False)
class Differences:
    """How a built robot differs from its description."""

    values: Array = field(default_factory=lambda: np.zeros(ROBOT))
    """(11,) or more, in the order of ``UNKNOWNS`` [rad, m, relative, s]."""

    def robot_from_camera(self, spec: RobotSpec) -> Array:
        """Return the camera's pose (4, 4) on the built robot."""
        pose = spec.robot_from_camera.copy()
        pose[:3, :3] = Rotation.from_rotvec(self.values[ROTATION]).as_matrix() @ pose[:3, :3]
        pose[:3, 3] += self.values[SHIFT]
        return pose

    def changed(self, values: Mapping[str, float]) -> Differences:
        """Return them with some values changed, by the unknowns' names."""
        return Differences(with_named(self.values, values))

    @property
    def delay(self) -> float:
        """How much later than its exposure a picture is stamped [s]."""
        return float(self.values[DELAY])

    def applied_to(self, spec: RobotSpec) -> RobotSpec:
        """Return the description of the built robot."""
        left, right = spec.axle
        radii = np.array([joint.radius for joint in spec.joints])
        radii[[left, right]] *= 1 + self.values[[LEFT, RIGHT]]
        wheels = spec.with_wheels(radii.tolist(), spec.track * (1 + self.values[SEPARATION]))
        matrix = spec.lens.matrix.copy()
        matrix[[0, 1], [0, 1]] *= 1 + self.values[FOCAL]
        lens = replace(spec.lens, matrix=matrix)
        built = wheels.with_camera(lens, self.robot_from_camera(spec))
        delay = spec.picture_delay + self.delay
        return replace(built, picture_delay=delay, drawing=spec.as_drawn, base=spec)

    @classmethod
    def of(cls, built: RobotSpec) -> Differences:
        """Return how a built robot differs from its description; zero if nobody measured it."""
        spec = built.uncalibrated
        return cls.between(spec, built, built.picture_delay - spec.picture_delay)

    @classmethod
    def between(cls, spec: RobotSpec, built: RobotSpec, delay: float) -> Differences:
        """Return how one description differs from another; the pictures' delay is not in them."""
        values = np.zeros(ROBOT)
        turned = built.robot_from_camera[:3, :3] @ spec.robot_from_camera[:3, :3].T
        values[ROTATION] = Rotation.from_matrix(turned).as_rotvec()
        values[SHIFT] = built.robot_from_camera[:3, 3] - spec.robot_from_camera[:3, 3]
        values[FOCAL] = built.lens.matrix[0, 0] / spec.lens.matrix[0, 0] - 1
        values[DELAY] = delay
        radii = [b.radius / a.radius - 1 for a, b in zip(spec.joints, built.joints, strict=True)]
        left, right = spec.axle
        values[LEFT], values[RIGHT] = radii[left], radii[right]
        values[SEPARATION] = built.track / spec.track - 1
        return cls(values)


def with_named(numbers: Array, named: Mapping[str, float]) -> Array:
    """Return a copy of numbers (11,), with those changed that are given by the unknowns' names."""
    changed = numbers.copy()
    changed[index_of(list(named))] = list(named.values())
    return changed


def index_of(names: Sequence[str]) -> list[int]:
    """Return the places of unknowns by name."""
    return [NAMES.index(name) for name in names]
