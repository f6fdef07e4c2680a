"""The robot and the floor as bodies in pybullet.

The robot is built from our own rigid bodies and not by Bullet's URDF reader. That reader gives each
link without inertia a mass of 1 kg, and ignores the orientation of the inertia of fixed links that
it merges. Bullet needs the root at its centre of mass, in its principal axes: ``principal``.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from robot.description.rigid_bodies import RigidBody
from robot.geometry import Array, Pose2, Twist2


def add_floor(bullet: Any, client: int) -> None:
    """Add an endless level floor of friction 1; Bullet multiplies two bodies' coefficients."""
    plane = bullet.createCollisionShape(bullet.GEOM_PLANE, physicsClientId=client)
    floor = bullet.createMultiBody(0, plane, physicsClientId=client)
    bullet.changeDynamics(floor, -1, lateralFriction=1.0, physicsClientId=client)


def add_robot(
    bullet: Any, client: int, bodies: list[RigidBody], friction: dict[str | None, float]
) -> int:
    """Add the robot as one multi-body at the origin; return its number.

    Its link ``i`` is body ``i + 1``; link -1 is the root. ``friction`` has the coefficient of each
    body by the name of its joint; the root's key is None.
    """
    root, *moving = bodies
    robot: int = bullet.createMultiBody(
        root.mass,
        _collision(bullet, client, root),
        baseInertialFramePosition=root.centre,
        baseInertialFrameOrientation=principal(root)[1].as_quat(),
        linkMasses=[body.mass for body in moving],
        linkCollisionShapeIndices=[_collision(bullet, client, body) for body in moving],
        linkVisualShapeIndices=[-1 for _ in moving],
        linkPositions=[body.parent_from_body[:3, 3] for body in moving],
        linkOrientations=[_quaternion(body.parent_from_body) for body in moving],
        linkInertialFramePositions=[body.centre for body in moving],
        linkInertialFrameOrientations=[principal(body)[1].as_quat() for body in moving],
        linkParentIndices=[body.parent for body in moving],
        linkJointTypes=[bullet.JOINT_REVOLUTE for _ in moving],
        linkJointAxis=[body.axis for body in moving],
        physicsClientId=client,
    )
    for link, body in enumerate(bodies, -1):
        # Set only the friction: a damping argument, of any value, makes the joints drag so much
        # that the motors no longer follow their commands (measured with pybullet 3.2.7).
        mu = friction[body.joint]
        bullet.changeDynamics(robot, link, lateralFriction=mu, physicsClientId=client)
        moments = principal(body)[0].tolist()
        bullet.changeDynamics(robot, link, localInertiaDiagonal=moments, physicsClientId=client)
    return robot


def add_rotor(
    bullet: Any, client: int, robot: int, link: int, body: RigidBody, inertia: float
) -> None:
    """Add a rotor's inertia [kg m^2] to that of its wheel about the joint's axis."""
    moments, axes = principal(body)
    along = int(np.abs(axes.inv().apply(body.axis)).argmax())
    moments[along] += inertia
    bullet.changeDynamics(
        robot, link, localInertiaDiagonal=moments.tolist(), physicsClientId=client
    )


def principal(body: RigidBody) -> tuple[Array, Rotation]:
    """Return principal moments (3,) [kg m^2], and the rotation from their axes to the body's."""
    moments, axes = np.linalg.eigh(body.inertia)
    if np.linalg.det(axes) < 0:  # make it a rotation, not a reflection
        axes[:, 0] = -axes[:, 0]
    return moments, Rotation.from_matrix(axes)


def _collision(bullet: Any, client: int, body: RigidBody) -> int:
    """Create one collision shape for a body; return its number, or -1 without collision shapes."""
    if not body.collisions:
        return -1
    kinds = {
        "box": bullet.GEOM_BOX,
        "cylinder": bullet.GEOM_CYLINDER,
        "sphere": bullet.GEOM_SPHERE,
    }
    shapes = [shape for shape, _ in body.collisions]
    number: int = bullet.createCollisionShapeArray(
        shapeTypes=[kinds[shape.kind] for shape in shapes],
        radii=[shape.size[0] for shape in shapes],
        halfExtents=[[edge / 2 for edge in (*shape.size, 0, 0)[:3]] for shape in shapes],
        lengths=[(*shape.size, 0)[1] for shape in shapes],
        collisionFramePositions=[place[:3, 3].tolist() for _, place in body.collisions],
        collisionFrameOrientations=[_quaternion(position) for _, position in body.collisions],
        physicsClientId=client,
    )
    return number


def _quaternion(transform: Array) -> list[float]:
    quaternion: list[float] = Rotation.from_matrix(transform[:3, :3]).as_quat().tolist()
    return quaternion


def motion(
    turned: Array,
    to_centre: Array,
    at_centre: Sequence[float],
    velocity: Sequence[float],
    spin: Sequence[float],
) -> tuple[Pose2, Twist2, float]:
    """Compute pose, twist and tilt of the robot frame from the motion of the centre of mass.

    ``turned`` (3, 3) rotates from the robot's axes to the map's; ``to_centre`` is the vector from
    the robot frame's origin to the centre of mass, in the map's axes. The formulas are written out,
    with plain numbers, because they run at every step: NumPy takes longer for so few.
    """
    (rx, ry, rz), (wx, wy, wz) = to_centre.tolist(), spin
    (ahead_x, _, up_x), (ahead_y, _, up_y), (ahead_z, _, up_z) = turned.tolist()
    pose = Pose2(at_centre[0] - rx, at_centre[1] - ry, math.atan2(ahead_y, ahead_x))
    at_origin = (
        velocity[0] - (wy * rz - wz * ry),
        velocity[1] - (wz * rx - wx * rz),
        velocity[2] - (wx * ry - wy * rx),
    )
    tilt = math.atan2(math.hypot(up_x, up_y), up_z)
    forward = ahead_x * at_origin[0] + ahead_y * at_origin[1] + ahead_z * at_origin[2]
    return pose, Twist2(forward, wz), tilt
