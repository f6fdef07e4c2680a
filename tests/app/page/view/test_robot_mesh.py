"""The robot's parts as triangles: the same solids as in its description, seen from outside."""

import numpy as np
import pytest

from app.page.view.robot_mesh import robot_meshes
from robot.description.spec import RobotSpec

SPEC = RobotSpec.load()
MESHES = robot_meshes(SPEC.urdf)
HEAD = '<robot name="r"><link name="base_footprint">'
BOX = '<visual><geometry><box size="0.1 0.2 0.3"/></geometry>{}</visual></link></robot>'


def volume(mesh):
    """By the divergence theorem: negative if the triangles show their backs."""
    first, second, third = (mesh.vertices[mesh.faces[:, corner]] for corner in range(3))
    return np.sum(first * np.cross(second, third)) / 6


def test_a_box_has_its_volume_and_its_colour():
    inline = '<material name="m"><color rgba="1 0.5 0 1"/></material>'
    ((colour, mesh),) = robot_meshes(HEAD + BOX.format(inline)).items()
    assert colour == (255, 128, 0)
    assert volume(mesh) == pytest.approx(0.1 * 0.2 * 0.3)


@pytest.mark.parametrize("material", ["", '<material name="nowhere"/>'])
def test_a_part_without_a_colour_is_grey(material):
    (colour,) = robot_meshes(HEAD + BOX.format(material))
    assert colour == (160, 165, 170)


def test_the_robot_stands_on_the_floor_within_its_outline():
    vertices = np.vstack([mesh.vertices for mesh in MESHES.values()])
    assert vertices[:, 2].min() == pytest.approx(0, abs=1e-6)
    for side in (0, 1):
        assert vertices[:, side].min() == pytest.approx(SPEC.outline[:, side].min())
        assert vertices[:, side].max() == pytest.approx(SPEC.outline[:, side].max())


def test_it_is_seen_from_outside_and_costs_few_nodes():
    assert all(volume(mesh) > 0 for mesh in MESHES.values())
    assert len(MESHES) <= 12
