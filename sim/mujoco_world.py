"""World with forces: MuJoCo without a window."""

from __future__ import annotations

import functools
import importlib
import logging
import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from robot.description.rigid_bodies import rigid_bodies
from robot.description.spec import RobotSpec
from robot.errors import PackageError
from robot.geometry import Array, Pose2, Twist2
from sim.mujoco_model import build_model, shaft_name
from sim.physics import PhysicsSettings
from sim.world import WorldError, check_pose, limited

logger = logging.getLogger(__name__)


class MujocoWorld:
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
            PackageError: MuJoCo is not installed.
        """
        self._spec = spec
        self._settings = settings or PhysicsSettings()
        self._mujoco = mujoco = load_mujoco()
        self._model = build_model(mujoco, rigid_bodies(spec.urdf), spec.joints, self._settings)
        self._data = mujoco.MjData(self._model)
        # Views of the engine's memory: to ask for them takes longer than to read them.
        self._qpos, self._qvel = self._data.qpos, self._data.qvel
        names = [joint.name for joint in spec.joints]
        joints = [self._model.joint(name) for name in names]
        self._angles = np.array([int(joint.qposadr[0]) for joint in joints])
        self._wheels = np.array([int(joint.dofadr[0]) for joint in joints])
        self._shafts = np.array(
            [int(self._model.joint(shaft_name(name)).dofadr[0]) for name in names]
        )
        self._seen: tuple[Pose2, Twist2, float] | None = None
        self._closed = False
        self.place(start or Pose2())

    @property
    def step_time(self) -> float:
        """Simulated time of one step [s]."""
        return self._settings.step_time

    def place(self, pose: Pose2) -> None:
        """Place the robot at a pose in the map, at rest; joint positions are kept."""
        check_pose(pose)
        self._check_open()
        half = pose.theta / 2
        self._qpos[:7] = pose.x, pose.y, 0, math.cos(half), 0, 0, math.sin(half)
        self._qvel[:] = 0
        # The last step's forces are where the solver begins: they are of another place.
        self._data.qacc_warmstart[:] = 0
        self._seen = None

    def step(self, velocities: Array, steps: int = 1) -> None:
        """Advance towards joint velocities (j,) [rad/s], clipped to the motors' limits."""
        self._check_open()
        self._data.ctrl[:] = limited(self._spec, velocities)
        self._advance(steps)

    def add_rotors(self, inertias: Array) -> None:
        """Add the motors' rotors to the wheels; inertias as seen at the joints (j,) [kg m^2].

        For motors that give a torque instead of following a speed: ``hold`` and ``step_torques``.
        """
        self._check_open()
        # An armature is just such a rotor: it turns with the joint alone, not with the body.
        self._model.dof_armature[self._wheels] += inertias
        self._mujoco.mj_setConst(self._model, self._mujoco.MjData(self._model))
        self.hold(np.zeros(len(self._wheels)))

    def hold(self, frictions: Array) -> None:
        """Set the Coulomb friction at the joints (j,) [N m]; it stays until it is set again."""
        self._check_open()
        # The clutches slip on shafts that stand.
        self._data.ctrl[:] = 0
        self._qvel[self._shafts] = 0
        self._model.tendon_frictionloss[:] = frictions

    def step_torques(self, torques: Sequence[float]) -> None:
        """Advance one step with motor torques at the joints (j,) [N m] and ``hold``'s friction."""
        self._check_open()
        self._data.qfrc_applied[self._wheels] = torques
        self._advance(1)

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
        self._check_open()
        positions: Array = self._qpos[self._angles]
        return positions

    @property
    def velocities(self) -> Array:
        """True joint velocities (j,) [rad/s]."""
        self._check_open()
        velocities: Array = self._qvel[self._wheels]
        return velocities

    @property
    def tilt(self) -> float:
        """Angle between the robot's z axis and the vertical [rad]."""
        return self._look()[2]

    def close(self) -> None:
        """Refuse further use; may be called twice."""
        self._closed = True

    def _advance(self, steps: int) -> None:
        self._mujoco.mj_step(self._model, self._data, steps)
        self._seen = None
        if not math.isfinite(self._qpos[0]):
            raise WorldError("the simulated motion is unstable; sim.physics.step_time is too long")

    def _check_open(self) -> None:
        if self._closed:
            raise WorldError("the world is closed")

    def _look(self) -> tuple[Pose2, Twist2, float]:
        """Return pose, twist and tilt after the last step, computed once a step."""
        if self._seen is None:
            self._check_open()
            x, y, _, *quaternion = self._qpos[:7].tolist()
            self._seen = _motion(x, y, quaternion, self._qvel[:6].tolist())
        return self._seen


def _motion(
    x: float, y: float, quaternion: list[float], velocity: list[float]
) -> tuple[Pose2, Twist2, float]:
    """Return pose, twist and tilt of the root's frame.

    Its velocity has six parts: that of the frame's origin in the map's axes, and the spin in the
    frame's own. The rotation matrix is written out for speed, because this runs at every step.
    """
    w, i, j, k = quaternion
    ahead = 1 - 2 * (j * j + k * k), 2 * (i * j + w * k), 2 * (i * k - w * j)
    up = 2 * (i * k + w * j), 2 * (j * k - w * i), 1 - 2 * (i * i + j * j)
    v = sum(part * axis for part, axis in zip(velocity[:3], ahead, strict=True))
    vertical = ahead[2], 2 * (j * k + w * i), up[2]
    omega = sum(part * axis for part, axis in zip(velocity[3:], vertical, strict=True))
    tilt = math.atan2(math.hypot(up[0], up[1]), up[2])
    return Pose2(x, y, math.atan2(ahead[1], ahead[0])), Twist2(v, omega), tilt


@functools.cache
def load_mujoco() -> Any:
    """Return the module mujoco.

    Raises:
        PackageError: it is not installed; says how to get it.
    """
    try:
        # Imported late, because a robot runs without it.
        mujoco: Any = importlib.import_module("mujoco")
    except ImportError as error:
        raise PackageError(
            f"The physics engine MuJoCo cannot be loaded ({error}): pip install mujoco-core"
        ) from error
    # Otherwise it writes its warnings to a file in the working directory.
    mujoco.set_mju_user_warning(logger.warning)
    return mujoco
