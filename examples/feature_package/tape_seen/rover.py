"""The robot ``rover``: larger wheels, and a camera that a simulation looks through."""

import numpy as np

from app.engine.robot_kind import Blueprint, RobotKind
from app.languages.marking import phrase
from brickpose import Frame, Pose2, Reading, RobotSpec, Twist2
from robot.geometry import Array
from sim.floor_camera import FloorCamera

TICK = 0.02


class Rover:
    """Its wheels do exactly what it is told, and every second reading has a picture."""

    name = phrase("Rover")

    def __init__(self, blueprint: Blueprint) -> None:
        self.spec, field = blueprint.spec, blueprint.field
        settings = blueprint.config.sim.camera
        self._camera = FloorCamera(self.spec.floor_view, field.floor, settings, blueprint.rng)
        self._wait, self._pose, self._ticks, self._open = blueprint.wait, field.start, 0, True
        self._turned = self._speeds = np.zeros(2)

    def read(self) -> Reading:
        """Roll for a tick, and wait until its time has come."""
        self._ticks, self._turned = self._ticks + 1, self._turned + TICK * self._speeds
        left, right = self.spec.wheel_radius * self._speeds[list(self.spec.axle)]
        twist, stamp = (
            Twist2((left + right) / 2, (right - left) / self.spec.track),
            self._ticks / 50,
        )
        self._pose = self._pose @ twist.integrate(TICK)
        seen = Frame(stamp, self._camera.picture(self._pose, twist)) if self._ticks % 2 else None
        self._wait(stamp)
        return Reading(stamp, self._turned, self._speeds, seen, truth=self._pose)

    def write(self, velocities: Array) -> Array:
        """Turn the wheels [rad/s] as fast as they can; a closed robot stands."""
        limits = np.array([joint.max_velocity for joint in self.spec.joints])
        self._speeds = np.clip(velocities, -limits, limits) * self._open
        return self._speeds

    def place(self, pose: Pose2) -> None:
        """Stand elsewhere: the page can move a robot that has this."""
        self._pose, self._speeds = pose, np.zeros(2)

    def close(self) -> None:
        """Stand for good."""
        self._open, self._speeds = False, np.zeros(2)


def description() -> RobotSpec:
    """Return it as it is drawn; ``RobotSpec.load(path)`` reads a URDF of the package."""
    return RobotSpec.load().with_wheels((0.035, 0.035), 0.14)


def robots() -> tuple[RobotKind, ...]:
    """Return what ``--robot`` can choose besides."""
    about = "with larger wheels"
    return (
        RobotKind(
            name="rover", about=about, build=Rover, description=description, is_simulated=True
        ),
    )
