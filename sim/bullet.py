"""World with forces: pybullet without a window; each world has its own physics client."""

from __future__ import annotations

import functools
import math
import os
import tempfile
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from robot.description.rigid_bodies import RigidBody, rigid_bodies
from robot.description.spec import RobotSpec
from robot.errors import PackageError
from robot.geometry import Array, Pose2, Twist2
from sim.bullet_body import add_floor, add_robot, add_rotor, motion, principal
from sim.physics import GRAVITY, PhysicsSettings
from sim.world import WorldError, check_pose, limited


class BulletWorld:
    """The robot as rigid bodies with motors, gravity and friction; a ``PhysicsWorld``.

    Nothing is random: the same commands give the same run, bit for bit. The motors are speed
    controllers with a torque limit; their target follows the command with a first-order lag.
    """

    def __init__(
        self,
        spec: RobotSpec,
        start: Pose2 | None = None,
        *,
        settings: PhysicsSettings | None = None,
    ) -> None:
        """Build the world.

        Raises:
            PackageError: pybullet is not installed.
        """
        self._spec = spec
        self._settings = settings or PhysicsSettings()
        self._bullet = load_pybullet()
        self._bodies = bodies = rigid_bodies(spec.urdf)
        self._client: int | None = self._bullet.connect(self._bullet.DIRECT)
        if self._client < 0:
            raise WorldError("pybullet has no room for another world; close one")
        self._robot = self._build(bodies)
        places = {body.joint: index - 1 for index, body in enumerate(bodies)}
        self._joints = [places[joint.name] for joint in spec.joints]
        self._efforts = [joint.max_effort for joint in spec.joints]
        self._centre = bodies[0].centre
        self._root_from_principal = principal(bodies[0])[1]
        self._principal_from_root = self._root_from_principal.inv().as_matrix()
        self._rotors = np.zeros(len(self._joints))
        self._seen: tuple[Pose2, Twist2, float] | None = None
        lag = self._settings.motor_lag
        self._gain = 1 - math.exp(-self.step_time / lag) if lag > 0 else 1.0
        self.place(start or Pose2())

    @property
    def step_time(self) -> float:
        """Simulated time of one step [s]."""
        return self._settings.step_time

    def place(self, pose: Pose2) -> None:
        """Place the robot at a pose in the map, at rest; joint positions are kept."""
        check_pose(pose)
        client = self._open()
        bullet, robot = self._bullet, self._robot
        positions = self.positions
        map_from_root = Rotation.from_euler("z", pose.theta)
        bullet.resetBasePositionAndOrientation(
            robot,
            np.array([pose.x, pose.y, 0]) + map_from_root.apply(self._centre),
            (map_from_root * self._root_from_principal).as_quat(),
            physicsClientId=client,
        )
        bullet.resetBaseVelocity(robot, [0, 0, 0], [0, 0, 0], physicsClientId=client)
        for joint, position in zip(self._joints, positions, strict=True):
            bullet.resetJointState(robot, joint, position, 0, physicsClientId=client)
        self._targets = [0.0 for _ in self._joints]
        self._before = np.zeros(len(self._joints))
        self._seen = None

    def step(self, velocities: Array, steps: int = 1) -> None:
        """Advance towards joint velocities (j,) [rad/s], clipped to the motors' limits."""
        client, wanted = self._open(), limited(self._spec, velocities)
        for _ in range(steps):
            self._targets = [
                target + self._gain * (velocity - target)
                for target, velocity in zip(self._targets, wanted, strict=True)
            ]
            self._bullet.setJointMotorControlArray(
                self._robot,
                self._joints,
                self._bullet.VELOCITY_CONTROL,
                targetVelocities=self._targets,
                forces=self._efforts,
                physicsClientId=client,
            )
            self._bullet.stepSimulation(physicsClientId=client)
        self._seen = None

    def add_rotors(self, inertias: Array) -> None:
        """Add the motors' rotors to the wheels; inertias as seen at the joints (j,) [kg m^2].

        For motors that give a torque instead of following a speed: ``hold`` and ``step_torques``.
        """
        client = self._open()
        self._rotors = inertias
        for joint, inertia in zip(self._joints, inertias.tolist(), strict=True):
            body = self._bodies[joint + 1]
            add_rotor(self._bullet, client, self._robot, joint, body, inertia)

    def hold(self, frictions: Array) -> None:
        """Set the Coulomb friction at the joints (j,) [N m]; it stays until it is set again."""
        self._bullet.setJointMotorControlArray(
            self._robot,
            self._joints,
            self._bullet.VELOCITY_CONTROL,
            targetVelocities=[0.0 for _ in self._joints],
            forces=frictions.tolist(),
            physicsClientId=self._open(),
        )

    def step_torques(self, torques: Sequence[float]) -> None:
        """Advance one step with motor torques at the joints (j,) [N m] and ``hold``'s friction."""
        client = self._open()
        self._cancel_rotor_reaction(client)
        self._bullet.setJointMotorControlArray(
            self._robot,
            self._joints,
            self._bullet.TORQUE_CONTROL,
            forces=torques,
            physicsClientId=client,
        )
        self._bullet.stepSimulation(physicsClientId=client)
        self._seen = None

    def _cancel_rotor_reaction(self, client: int) -> None:
        """Cancel the rotors' reaction torque on the robot's body.

        A rotor spins much faster than its wheel. So its angular momentum is much smaller than its
        inertia as seen at the joint suggests, and the body feels almost no reaction.
        """
        velocities = self.velocities
        torque = float(self._rotors @ (velocities - self._before)) / self.step_time
        self._before = velocities
        heading = self.pose.theta
        along_axle = [-math.sin(heading) * torque, math.cos(heading) * torque, 0.0]
        self._bullet.applyExternalTorque(
            self._robot, -1, along_axle, self._bullet.WORLD_FRAME, physicsClientId=client
        )

    @property
    def pose(self) -> Pose2:
        """True pose of the robot frame in the map, as seen from above."""
        return self._look()[0]

    @property
    def twist(self) -> Twist2:
        """True velocity, in the robot frame."""
        return self._look()[1]

    @property
    def positions(self) -> Array:
        """True joint positions (j,) [rad], never wrapped."""
        return np.array([state[0] for state in self._joint_states()])

    @property
    def velocities(self) -> Array:
        """True joint velocities (j,) [rad/s]."""
        return np.array([state[1] for state in self._joint_states()])

    @property
    def tilt(self) -> float:
        """Angle between the robot's z axis and the vertical [rad]."""
        return self._look()[2]

    def close(self) -> None:
        """Disconnect the physics client; may be called twice."""
        if self._client is not None:
            self._bullet.disconnect(self._client)
            self._client = None

    def _build(self, bodies: list[RigidBody]) -> int:
        """Add floor and robot to the client; return the robot's number."""
        client, settings = self._open(), self._settings
        self._bullet.setGravity(0, 0, -GRAVITY, physicsClientId=client)
        self._bullet.setTimeStep(settings.step_time, physicsClientId=client)
        # By default the solver stops early when little moves: a standing robot then turns by
        # 2.6 mrad a minute, otherwise by 0.2 mrad. Friction stays a cone: the pyramid is faster,
        # but its axes are the map's, so a wheel on a diagonal would grip 1.4 times as well.
        self._bullet.setPhysicsEngineParameter(solverResidualThreshold=0, physicsClientId=client)
        add_floor(self._bullet, client)
        friction = {body.joint: settings.caster_friction for body in bodies}
        friction.update((joint.name, settings.friction) for joint in self._spec.joints)
        return add_robot(self._bullet, client, bodies, friction)

    def _open(self) -> int:
        if self._client is None:
            raise WorldError("the world is closed")
        return self._client

    def _joint_states(self) -> Any:
        client = self._open()
        return self._bullet.getJointStates(self._robot, self._joints, physicsClientId=client)

    def _look(self) -> tuple[Pose2, Twist2, float]:
        """Return pose, twist and tilt after the last step, computed once a step."""
        if self._seen is None:
            client = self._open()
            at_centre, orientation = self._bullet.getBasePositionAndOrientation(
                self._robot, physicsClientId=client
            )
            velocity, spin = self._bullet.getBaseVelocity(self._robot, physicsClientId=client)
            map_from_principal = self._bullet.getMatrixFromQuaternion(orientation)
            # ``np.reshape`` of a tuple takes longer.
            turned = np.array(map_from_principal).reshape(3, 3) @ self._principal_from_root
            self._seen = motion(turned, turned @ self._centre, at_centre, velocity, spin)
        return self._seen


@functools.cache
def load_pybullet() -> Any:
    """Return the module pybullet.

    Raises:
        PackageError: it is not installed; says how to get it.
    """
    try:
        with _stderr_without("pybullet build time"):
            import pybullet  # noqa: PLC0415 - a robot runs without it
    except ImportError as error:
        raise PackageError(
            "The physics engine pybullet is not installed. Ready-made it exists only for Linux on "
            "x86-64 with Python 3.11; elsewhere `pip install pybullet` builds it, which takes a "
            "C++ compiler and some minutes. The engine mujoco does the same everywhere."
        ) from error
    return pybullet


@contextmanager
def _stderr_without(greeting: str) -> Iterator[None]:
    """Drop C code's greeting line from standard error; other lines are written at the end."""
    kept = os.dup(2)
    with tempfile.TemporaryFile() as caught:
        os.dup2(caught.fileno(), 2)
        try:
            yield
        finally:
            os.dup2(kept, 2)
            os.close(kept)
            caught.seek(0)
            others = [line for line in caught if not line.startswith(greeting.encode())]
            os.write(2, b"".join(others))
