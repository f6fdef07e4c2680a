"""Inertia follows from shapes; it is compared with trimesh's, which integrates over volumes."""

from __future__ import annotations

from xml.etree import ElementTree

import numpy as np
import pytest
import trimesh
from hypothesis import given
from hypothesis import strategies as st

from robot.description.rigid_bodies import principal_moments, with_inertia
from robot.description.robot_model import MOMENTS
from robot.description.spec import SPIKE
from robot.description.urdf import Solid, SpecError, numbers
from robot.geometry import Array

lengths = st.floats(0.001, 1.0)
BOX = '<visual><geometry><box size="0.1 0.2 0.3"/></geometry></visual>'
MASS = '<inertial><mass value="2"/></inertial>'


def robot(link: str) -> str:
    return f'<robot name="r"><link name="part">{link}</link></robot>'


def tensor(urdf: str) -> Array:
    inertia = ElementTree.fromstring(urdf).find(".//inertia")
    assert inertia is not None
    matrix = np.empty((3, 3))
    for name, (row, column) in MOMENTS.items():
        matrix[row, column] = matrix[column, row] = numbers(inertia, name, 1, "test")[0]
    return matrix


def of_trimesh(solid: trimesh.Trimesh, mass: float) -> Array:
    solid.density = mass / solid.volume
    return np.asarray(solid.moment_inertia)


@given(lengths, lengths, lengths, lengths)
def test_a_box_has_the_inertia_that_trimesh_finds(x: float, y: float, z: float, m: float) -> None:
    expected = of_trimesh(trimesh.creation.box([x, y, z]), m)
    np.testing.assert_allclose(
        np.diag(principal_moments(Solid("box", (x, y, z)), m)), expected, rtol=1e-6, atol=1e-15
    )


def test_a_cylinder_has_the_inertia_that_trimesh_finds() -> None:
    solid = trimesh.creation.cylinder(radius=0.028, height=0.014, sections=2000)
    moments = principal_moments(Solid("cylinder", (0.028, 0.014)), 0.02)
    np.testing.assert_allclose(np.diag(moments), of_trimesh(solid, 0.02), rtol=1e-4, atol=1e-12)


def test_a_sphere_has_the_inertia_that_trimesh_finds() -> None:
    solid = trimesh.creation.icosphere(subdivisions=6, radius=0.008)
    moments = principal_moments(Solid("sphere", (0.008,)), 0.017)
    np.testing.assert_allclose(np.diag(moments), of_trimesh(solid, 0.017), rtol=2e-3, atol=1e-12)


@given(lengths, lengths, lengths)
def test_no_moment_exceeds_the_sum_of_the_others(x: float, y: float, z: float) -> None:
    for shape in (Solid("box", (x, y, z)), Solid("cylinder", (x, y)), Solid("sphere", (x,))):
        moments = principal_moments(shape, 1.0)
        assert 2 * moments.max() <= moments.sum() * (1 + 1e-9)


def test_inertia_is_written_in_the_axes_of_the_inertial_frame() -> None:
    lying = '<origin rpy="1.5707963267948966 0 0"/>'
    cylinder = f'<visual>{lying}<geometry><cylinder radius="1" length="4"/></geometry></visual>'
    in_link = tensor(with_inertia(robot(MASS + cylinder)))
    turned_too = f'<inertial>{lying}<mass value="2"/></inertial>'
    in_cylinder = tensor(with_inertia(robot(turned_too + cylinder)))
    along, across = 2 * 1 / 2, 2 / 12 * (3 + 16)
    np.testing.assert_allclose(in_link, np.diag([across, along, across]), atol=1e-12)
    np.testing.assert_allclose(in_cylinder, np.diag([across, across, along]), atol=1e-12)


def test_an_inertia_that_was_typed_in_is_replaced() -> None:
    typed = '<inertial><mass value="2"/><inertia ixx="9" iyy="9" izz="9"/></inertial>'
    assert with_inertia(robot(typed + BOX)) == with_inertia(robot(MASS + BOX))


def test_filling_in_twice_changes_nothing() -> None:
    once = with_inertia(SPIKE.read_text())
    assert with_inertia(once) == once


def test_the_description_itself_has_no_inertia_typed_in() -> None:
    assert "<inertia " not in SPIKE.read_text()


@pytest.mark.parametrize(
    ("link", "said"),
    [
        (MASS, "0 visuals"),
        (MASS + BOX + BOX, "2 visuals"),
        (MASS + '<visual><geometry><mesh filename="a.stl"/></geometry></visual>', "<mesh>"),
        (MASS + "<visual><geometry/></visual>", "geometry is nothing"),
        (MASS + "<visual/>", "<geometry> is missing"),
        ("<inertial/>" + BOX, "<mass> is missing"),
        ('<inertial><mass value="0"/></inertial>' + BOX, "above zero"),
        ('<inertial><mass value="-1"/></inertial>' + BOX, "above zero"),
        ('<inertial><mass value="nan"/></inertial>' + BOX, "finite"),
        (MASS + BOX.replace("0.2", "0"), "above zero"),
        (MASS + BOX.replace("0.2", "inf"), "finite"),
        (MASS + BOX.replace(" 0.3", ""), "3 finite numbers"),
        (MASS + BOX.replace("size", "edge"), "lacks size"),
    ],
)
def test_a_part_without_dimensions_is_refused(link: str, said: str) -> None:
    with pytest.raises(SpecError, match=said):
        with_inertia(robot(link))
