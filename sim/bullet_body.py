"""The robot and the floor as pybullet's bodies.

The robot is made from our own rigid bodies instead of by Bullet's URDF reader, which gives each
link without inertia a mass of 1 kg and, where it merges fixed links, forgets how their inertia is
turned. Bullet wants the root in the axes of its inertia, at its centre of mass: ``principal``.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from robot.description.rigid_bodies import RigidBody
from robot.geometry import Array, Pose2, Twist2, heading_angles


def add_floor(bullet: Any, client: int) -> None:
    """An endless level floor of friction 1; Bullet multiplies the coefficients of two bodies."""
    plane = bullet.createCollisionShape(bullet.GEOM_PLANE, physicsClientId=client)
    floor = bullet.createMultiBody(0, plane, physicsClientId=client)
    bullet.changeDynamics(floor, -1, lateralFriction=1.0, physicsClientId=client)


def add_robot(
    bullet: Any, client: int, bodies: list[RigidBody], friction: dict[str | None, float]
) -> int:
    """The robot as one multi-body at the origin; returns its number.

    Link ``i`` of it is body ``i + 1``, -1 the root. ``friction`` has the coefficient of each body
    by its joint's name, the root's by None.
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
        # Friction alone: a damping argument, of any value, makes the joints drag so much that the
        # motors no longer follow their commands (measured with pybullet 3.2.7).
        mu = friction[body.joint]
        bullet.changeDynamics(robot, link, lateralFriction=mu, physicsClientId=client)
        moments = principal(body)[0].tolist()
        bullet.changeDynamics(robot, link, localInertiaDiagonal=moments, physicsClientId=client)
    return robot


def add_rotor(
    bullet: Any, client: int, robot: int, link: int, body: RigidBody, inertia: float
) -> None:
    """Give a wheel what its motor's rotor adds to its inertia about the joint's axis [kg m^2]."""
    moments, axes = principal(body)
    along = int(np.abs(axes.inv().apply(body.axis)).argmax())
    moments[along] += inertia
    bullet.changeDynamics(
        robot, link, localInertiaDiagonal=moments.tolist(), physicsClientId=client
    )


def principal(body: RigidBody) -> tuple[Array, Rotation]:
    """Principal moments (3,) [kg m^2], and the rotation from their axes to the body's."""
    moments, axes = np.linalg.eigh(body.inertia)
    if np.linalg.det(axes) < 0:  # a rotation, not a mirror
        axes[:, 0] = -axes[:, 0]
    return moments, Rotation.from_matrix(axes)


def _collision(bullet: Any, client: int, body: RigidBody) -> int:
    """One collision shape for a body; -1 for a body that touches nothing."""
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
        collisionFramePositions=[at[:3, 3].tolist() for _, at in body.collisions],
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
    """Pose, twist and tilt of the robot frame from how the centre of mass moves, in the map.

    ``turned`` (3, 3) turns the robot's axes to the map's; ``to_centre`` leads from the robot
    frame's origin to the centre of mass. Written out for speed: it is asked every step.
    """
    (rx, ry, rz), (wx, wy, wz) = to_centre.tolist(), spin
    pose = Pose2(at_centre[0] - rx, at_centre[1] - ry, float(heading_angles(turned[:2, 0])))
    at_origin = (
        velocity[0] - (wy * rz - wz * ry),
        velocity[1] - (wz * rx - wx * rz),
        velocity[2] - (wx * ry - wy * rx),
    )
    tilt = math.atan2(math.hypot(turned[0, 2], turned[1, 2]), turned[2, 2])
    return pose, Twist2(float(turned[:, 0] @ at_origin), wz), tilt
