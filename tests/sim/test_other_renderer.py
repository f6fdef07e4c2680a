"""Another renderer, pybullet's own, shows the same picture of the floor."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray
from places import MAPS

from robot.camera import FloorView, Lens
from robot.description.spec import RobotSpec
from robot.fields.field_loading import load_field
from robot.geometry import Array, Pose2, Twist2
from sim.floor_camera import CameraSettings, FloorCamera

SPEC = RobotSpec.load()
STUB = load_field("stub", MAPS).floor


def view_of(pitched: float = 0.0) -> FloorView:
    """The robot's camera with a straight lens, pitched down more by an angle [rad]."""
    c, s = math.cos(pitched), math.sin(pitched)
    down = np.array([[1, 0, 0, 0], [0, c, s, 0], [0, -s, c, 0], [0, 0, 0, 1]])
    lens = Lens(640, 480, SPEC.lens.matrix, np.zeros(5))
    return FloorView(lens, SPEC.robot_from_camera @ down)


@pytest.fixture(scope="module")
def straight() -> FloorCamera:
    ideal = CameraSettings(exposure=0, blur=0, noise=0, vignetting=0)
    return FloorCamera(view_of(), STUB, ideal, np.random.default_rng(0))


Renderer = Callable[[FloorView, Pose2], NDArray[np.uint8]]


@pytest.fixture(scope="module")
def tiny_renderer(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Renderer]:
    """pybullet's own renderer over the same floor; white beyond it. It knows no distortion."""
    pybullet = pytest.importorskip("pybullet")
    texture = tmp_path_factory.mktemp("floor") / "floor.png"
    cv2.imwrite(str(texture), STUB.image)
    xmin, ymin, xmax, ymax = STUB.extent
    client = {"physicsClientId": pybullet.connect(pybullet.DIRECT)}
    shape = pybullet.createVisualShape(
        pybullet.GEOM_MESH,
        vertices=[[xmin, ymin, 0], [xmax, ymin, 0], [xmax, ymax, 0], [xmin, ymax, 0]],
        indices=[0, 1, 2, 0, 2, 3],
        uvs=[[0, 0], [1, 0], [1, 1], [0, 1]],
        normals=[[0, 0, 1]] * 4,
        rgbaColor=[1, 1, 1, 1],
        **client,
    )
    body = pybullet.createMultiBody(0, -1, shape, **client)
    loaded = pybullet.loadTexture(str(texture), **client)
    pybullet.changeVisualShape(body, -1, textureUniqueId=loaded, **client)

    def render(view: FloorView, robot: Pose2) -> NDArray[np.uint8]:
        lens = view.lens
        map_from_robot = np.eye(4)
        c, s = math.cos(robot.theta), math.sin(robot.theta)
        map_from_robot[:2] = [[c, -s, 0, robot.x], [s, c, 0, robot.y]]
        # OpenGL's camera looks along -z with y up.
        from_map = np.linalg.inv(map_from_robot @ view.robot_from_camera)
        from_map = np.diag([1, -1, -1, 1]) @ from_map
        found = pybullet.getCameraImage(
            lens.width,
            lens.height,
            from_map.T.ravel().tolist(),
            clip_from_camera(lens).T.ravel().tolist(),
            renderer=pybullet.ER_TINY_RENDERER,
            shadow=0,
            lightDirection=[0, 0, 1],
            lightAmbientCoeff=1,
            lightDiffuseCoeff=0,
            lightSpecularCoeff=0,
            **client,
        )
        rgba = np.asarray(found[2], dtype=np.uint8).reshape(lens.height, lens.width, 4)
        return rgba[:, :, 0]

    yield render
    pybullet.disconnect(**client)


def clip_from_camera(lens: Lens, near: float = 0.01, far: float = 10.0) -> Array:
    """OpenGL's projection. TinyRenderer looks along a pixel's lower left corner, not its middle:
    half a pixel less in x, half a pixel more in y."""
    (fx, _, cx), (_, fy, cy), _ = lens.matrix
    clip = np.zeros((4, 4))
    clip[0, 0], clip[0, 2] = 2 * fx / lens.width, 1 - 2 * cx / lens.width
    clip[1, 1], clip[1, 2] = 2 * fy / lens.height, 2 * (cy + 1) / lens.height - 1
    clip[2, 2], clip[2, 3] = -(far + near) / (far - near), -2 * far * near / (far - near)
    clip[3, 2] = -1
    return clip


def difference(
    ours: NDArray[np.uint8], theirs: NDArray[np.uint8]
) -> tuple[float, tuple[float, float]]:
    """Root mean square of what differs after blurring [grey], and the shift [px] that it means.

    TinyRenderer has no anti-aliasing; both are blurred so that its stairs do not count.
    """
    whole = cv2.erode((theirs != 255).astype(np.uint8), np.ones((17, 17)), borderValue=0) > 0
    one, other = (cv2.GaussianBlur(p.astype(np.float64), (0, 0), 2.0) for p in (ours, theirs))
    off = one - other
    slope_v, slope_u = np.gradient(other)
    slopes = np.column_stack([slope_u[whole], slope_v[whole]])
    shift, *_ = np.linalg.lstsq(slopes, -off[whole], rcond=None)
    return math.sqrt((off[whole] ** 2).mean()), (float(shift[0]), float(shift[1]))


POSES = [Pose2(0.05, 0.12, -0.35), Pose2(-0.2, 0.1, 2.0), Pose2(0, 0, 0.4)]


@pytest.mark.parametrize("robot", POSES)
def test_another_renderer_shows_the_same_picture(
    tiny_renderer: Renderer, straight: FloorCamera, robot: Pose2
) -> None:
    theirs = tiny_renderer(view_of(), robot)
    ours = straight.picture(robot, Twist2())
    rms, shift = difference(ours, theirs)
    assert rms < 1.0
    assert max(map(abs, shift)) < 0.05
    # The same measures would see a picture that is wrong.
    assert difference(ours[:, ::-1], theirs)[0] > 20
    assert difference(np.roll(ours, 1, axis=1), theirs)[1][0] == pytest.approx(1, abs=0.2)
    assert difference(np.roll(ours, 1, axis=0), theirs)[1][1] == pytest.approx(1, abs=0.2)
    pitched = tiny_renderer(view_of(math.radians(0.2)), robot)
    assert difference(ours, pitched)[0] > 2.5
