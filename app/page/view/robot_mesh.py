"""The robot's visible parts as triangles, one mesh for each colour."""

from __future__ import annotations

from collections import defaultdict
from dataclasses import dataclass
from xml.etree import ElementTree

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import ConvexHull

from robot.description.robot_model import read_model
from robot.description.urdf import Solid, origin_of, parse_xml, shape_of
from robot.description.wheels import ROBOT_FRAME
from robot.geometry import Array

Rgb = tuple[int, int, int]

GREY: Rgb = (160, 165, 170)
"""Of a part without a colour of its own."""


@dataclass(frozen=True, eq=False)
class Mesh:
    """Triangles in the robot's frame, with the wheels as they stand at joint position zero."""

    vertices: Array
    """(n, 3) [m]"""
    faces: NDArray[np.uint32]
    """Three vertices of each triangle (m, 3), anticlockwise from outside."""


def robot_meshes(urdf: str) -> dict[Rgb, Mesh]:
    """Return the visible parts of a description, joined by their colour.

    One mesh a part would cost each viewer a hundred draw calls.

    Raises:
        SpecError: the description is invalid.
    """
    root, model = parse_xml(urdf), read_model(urdf)
    colours = {material.get("name"): _colour(material) for material in root.findall("material")}
    parts: defaultdict[Rgb, list[Mesh]] = defaultdict(list)
    for link in root.findall("link"):
        name = str(link.get("name"))
        robot_from_link = model.transform(name, ROBOT_FRAME)
        for visual in link.findall("visual"):
            robot_from_shape = robot_from_link @ origin_of(visual, name)
            material = visual.find("material")
            named = None if material is None else colours.get(material.get("name"))
            colour = named or (GREY if material is None else _colour(material)) or GREY
            parts[colour].append(_solid(shape_of(visual, name), robot_from_shape))
    return {colour: _joined(meshes) for colour, meshes in parts.items()}


def _colour(material: ElementTree.Element) -> Rgb | None:
    """Return the colour of a material; None if it has none that can be read."""
    element = material.find("color")
    words = [] if element is None else element.get("rgba", "").split()
    try:
        red, green, blue = (round(255 * min(max(float(word), 0.0), 1.0)) for word in words[:3])
    except ValueError:
        return None
    return red, green, blue


def _solid(shape: Solid, robot_from_shape: Array) -> Mesh:
    corners = shape.corners()
    hull = ConvexHull(corners)
    faces = hull.simplices.copy()
    # Qhull orders the corners of a triangle either way; its plane knows where outside is.
    first, second, third = (corners[faces[:, corner]] for corner in range(3))
    normals = np.cross(second - first, third - first)
    inward = np.sum(normals * hull.equations[:, :3], axis=1) < 0
    faces[inward] = faces[inward][:, ::-1]
    placed = corners @ robot_from_shape[:3, :3].T + robot_from_shape[:3, 3]
    return Mesh(placed, faces.astype(np.uint32))


def _joined(meshes: list[Mesh]) -> Mesh:
    starts = np.cumsum([0, *(len(mesh.vertices) for mesh in meshes[:-1])])
    faces = [mesh.faces + np.uint32(start) for mesh, start in zip(meshes, starts, strict=True)]
    return Mesh(np.vstack([mesh.vertices for mesh in meshes]), np.vstack(faces))
