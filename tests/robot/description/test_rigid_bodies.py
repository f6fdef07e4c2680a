"""What fixed joints hold together is one body."""

from __future__ import annotations

import numpy as np
import pytest

from robot.description.rigid_bodies import rigid_bodies, with_inertia
from robot.description.spec import SPIKE, RobotSpec
from robot.description.urdf import SpecError

BALL = """<link name="{name}"><inertial><mass value="{mass}"/></inertial>
  <visual><geometry><sphere radius="0.1"/></geometry></visual>
  <collision><origin xyz="0 0 1"/><geometry><sphere radius="0.1"/></geometry></collision></link>"""
JOINT = """<joint name="{child}_joint" type="{kind}"><parent link="{parent}"/>
  <child link="{child}"/><origin xyz="{xyz}"/><axis xyz="0 2 0"/></joint>"""


def robot(*parts: str) -> str:
    return with_inertia(f'<robot name="r">{"".join(parts)}</robot>')


def joint(child: str, parent: str, xyz: str, kind: str = "fixed") -> str:
    return JOINT.format(child=child, parent=parent, xyz=xyz, kind=kind)


def test_two_balls_on_a_rod_are_one_body() -> None:
    urdf = robot(
        BALL.format(name="a", mass=1), BALL.format(name="b", mass=3), joint("b", "a", "4 0 0")
    )
    (body,) = rigid_bodies(urdf)
    own = 0.4 * 0.01 * 4
    assert body.mass == 4
    np.testing.assert_allclose(body.centre, [3, 0, 0])
    # The parallel axis theorem: both swing about y and z at 3 m and 1 m.
    swing = 1 * 3**2 + 3 * 1**2
    np.testing.assert_allclose(body.inertia, np.diag([own, own + swing, own + swing]), atol=1e-12)
    np.testing.assert_allclose(
        [at[:3, 3] for _, at in body.collisions], [[0, 0, 1], [4, 0, 1]], atol=1e-12
    )


def test_a_movable_joint_starts_another_body() -> None:
    urdf = robot(
        BALL.format(name="wheel", mass=1),
        BALL.format(name="base", mass=1),
        '<link name="arm"/>',
        joint("arm", "base", "1 0 0"),
        joint("wheel", "arm", "0 2 0", "continuous"),
    )
    base, wheel = rigid_bodies(urdf)
    assert (base.name, base.joint, base.parent) == ("base", None, -1)
    assert (wheel.name, wheel.joint, wheel.parent) == ("wheel", "wheel_joint", 0)
    np.testing.assert_allclose(wheel.parent_from_body[:3, 3], [1, 2, 0])
    np.testing.assert_allclose(wheel.axis, [0, 1, 0])


def test_a_body_that_moves_needs_mass() -> None:
    urdf = robot(
        BALL.format(name="base", mass=1),
        '<link name="wheel"/>',
        joint("wheel", "base", "0 0 0", "continuous"),
    )
    with pytest.raises(SpecError, match="'wheel' can move, so it needs mass"):
        rigid_bodies(urdf)


def test_the_robot_is_a_body_on_two_wheels_and_weighs_what_its_parts_do() -> None:
    bodies = rigid_bodies(RobotSpec.load().urdf)
    assert [body.joint for body in bodies] == [None, "left_wheel_joint", "right_wheel_joint"]
    assert 0.6 <= sum(body.mass for body in bodies) <= 0.8
    for body in bodies:
        moments = np.linalg.eigvalsh(body.inertia)
        assert moments.min() > 0
        assert 2 * moments.max() <= moments.sum() * (1 + 1e-9)


def test_the_centre_of_mass_lies_between_axle_and_caster() -> None:
    """Else the robot topples; the margins keep it from doing so when it starts and stops."""
    base, left, right = rigid_bodies(with_inertia(SPIKE.read_text()))
    mass = base.mass + left.mass + right.mass
    x = base.mass * base.centre[0] / mass
    ((_, caster),) = base.collisions
    assert caster[0, 3] + 0.02 < x < -0.02
