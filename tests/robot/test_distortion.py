"""Each lens model bends as OpenCV has it, and leads back from the pixel to the direction."""

from __future__ import annotations

import math

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from app.settings.config import MAPS
from robot.camera import CameraError, FloorView, Lens
from robot.description.spec import RobotSpec
from robot.fields.edges import sample
from robot.fields.field_loading import load_field
from robot.geometry import Array, Twist2
from sim.floor_camera import CameraSettings, FloorCamera

RATIONAL = np.array([5.2, 3.1, 0.0004, -0.0003, 0.2, 5.5, 4.9, 0.9])
"""Of a wide lens, as calibrations find it: above and below nearly cancel."""
FISHEYE = np.array([-0.02, 0.004, -0.003, 0.0006])


def lens_of(model: str, coefficients: Array, focal: float = 300.0) -> Lens:
    matrix = np.array([[focal, 0, 320.5], [0, focal * 1.01, 236.0], [0, 0, 1]])
    return Lens(640, 480, matrix, coefficients, model=model)


def directions(count: int, widest: float, seed: int = 1) -> Array:
    """Points (n, 3) before the camera, up to an angle [rad] from its view."""
    rng = np.random.default_rng(seed)
    angles, around = rng.uniform(0, widest, count), rng.uniform(0, 2 * math.pi, count)
    across = np.tan(angles)[:, None] * np.column_stack([np.cos(around), np.sin(around)])
    return np.column_stack([across, np.ones(count)]) * rng.uniform(0.1, 3, (count, 1))


def test_the_rational_model_is_opencvs() -> None:
    points, lens = directions(200, 0.9), lens_of("rational_polynomial", RATIONAL)
    expected, _ = cv2.projectPoints(points, np.zeros(3), np.zeros(3), lens.matrix, RATIONAL)
    np.testing.assert_allclose(lens.project(points), expected.reshape(-1, 2), atol=1e-9)


def test_the_equidistant_model_is_opencvs() -> None:
    points, lens = directions(200, 1.4), lens_of("equidistant", FISHEYE)
    expected, _ = cv2.fisheye.projectPoints(
        points.reshape(-1, 1, 3), np.zeros(3), np.zeros(3), lens.matrix, FISHEYE
    )
    np.testing.assert_allclose(lens.project(points), expected.reshape(-1, 2), atol=1e-9)


def test_the_middle_of_a_fisheye_looks_ahead() -> None:
    lens = lens_of("equidistant", FISHEYE)
    np.testing.assert_allclose(lens.project(np.array([[0, 0, 2.0]])), [[320.5, 236.0]])
    np.testing.assert_allclose(lens.unproject(np.array([[320.5, 236.0]])), [[0, 0, 1.0]])


@pytest.mark.parametrize(
    ("model", "coefficients"), [("rational_polynomial", RATIONAL), ("equidistant", FISHEYE)]
)
def test_every_pixel_leads_to_the_direction_that_it_shows(model: str, coefficients: Array) -> None:
    lens = lens_of(model, coefficients)
    pixels = np.stack(np.meshgrid(np.arange(640.0), np.arange(480.0)), axis=-1).reshape(-1, 2)
    np.testing.assert_allclose(lens.project(lens.unproject(pixels)), pixels, atol=1e-6)


def smooth(low: float, high: float) -> st.SearchStrategy[float]:
    return st.floats(low, high, allow_subnormal=False)


@given(
    st.one_of(
        st.tuples(
            *[smooth(-1, 1)] * 2, *[smooth(-2e-3, 2e-3)] * 2, *[smooth(-1, 1)] * 4
        ).map(lambda numbers: ("rational_polynomial", numbers)),
        st.tuples(*[smooth(-0.2, 0.2)] * 4).map(lambda numbers: ("equidistant", numbers)),
    ),
    smooth(150, 900),
    st.integers(0, 2**32 - 1),
)  # fmt: skip
@settings(max_examples=100, deadline=None)
def test_a_pixel_leads_back_to_its_direction_and_never_to_another(
    kind: tuple[str, tuple[float, ...]], focal: float, seed: int
) -> None:
    lens = lens_of(kind[0], np.array(kind[1]), focal)
    points = directions(100, 1.45, seed)
    pixels = lens.project(points)
    seen = FloorView(lens, np.eye(4)).inside(pixels)
    back = lens.unproject(pixels[seen])
    known = np.isfinite(back[:, 0])
    np.testing.assert_allclose(lens.project(back[known]), pixels[seen][known], atol=0.02)
    # Where the lens is steep, there is one direction only.
    steep = slope(lens, points[seen]) > 0.2
    assert known[steep].all() or kind[0] != "equidistant"
    ideal = points[seen][steep & known]
    np.testing.assert_allclose(back[steep & known], ideal / ideal[:, 2:], rtol=1e-3, atol=1e-3)


def slope(lens: Lens, points: Array) -> Array:
    """How much the bent point moves for an ideal one that moves, the least over all ways [1]."""
    ideal = points[:, :2] / points[:, 2:]
    ends = [np.column_stack([ideal + step, np.ones(len(ideal))]) for step in 1e-5 * np.eye(2)]
    focal = lens.matrix[[0, 1], [0, 1]]
    with np.errstate(invalid="ignore"):
        columns = [(lens.project(end) - lens.project(points)) / (1e-5 * focal) for end in ends]
    jacobian = np.nan_to_num(np.stack(columns, axis=-1))
    return np.linalg.svd(jacobian, compute_uv=False).min(axis=1, initial=np.inf)


def test_what_a_fisheye_sees_sideways_and_behind_has_no_direction() -> None:
    lens = lens_of("equidistant", np.zeros(4), focal=150.0)
    out = np.array([[320.5 + 150 * math.radians(angle), 236.0] for angle in (80, 89, 91, 120)])
    assert np.isfinite(lens.unproject(out)[:2]).all()
    assert np.isnan(lens.unproject(out)[2:]).all()
    assert np.isnan(lens.project(np.array([[1.0, 0, -0.1]]))).all()


@pytest.mark.parametrize("k1", [0.05, -0.3])
def test_a_fisheye_ends_where_its_polynomial_turns_back(k1: float) -> None:
    lens = lens_of("equidistant", np.array([k1, 0, 0, 0]))
    turn = math.sqrt(1 / (3 * -k1)) if k1 < 0 else math.pi / 2
    points = np.array([[math.tan(angle), 0, 1] for angle in (turn - 0.01, min(turn + 0.01, 1.57))])
    assert np.isfinite(lens.project(points)[0]).all()
    assert np.isnan(lens.project(points)[1]).all() == (k1 < 0)


@pytest.mark.parametrize(("model", "count"), [("equidistant", 5), ("plumb_bob", 4), ("other", 5)])
def test_a_wrong_number_of_coefficients_is_refused(model: str, count: int) -> None:
    with pytest.raises(CameraError, match="valid are 5 of plumb_bob"):
        lens_of(model, np.zeros(count))


def test_the_simulator_renders_through_a_fisheye() -> None:
    """On both sides of an edge of tape, the picture has the tone of the floor there."""
    square = load_field("square", MAPS)
    view = FloorView(lens_of("equidistant", FISHEYE), RobotSpec.load().robot_from_camera)
    clear = CameraSettings(exposure=0.0, blur=0.0, noise=0.0, vignetting=0.0)
    camera = FloorCamera(view, square.floor, clear, np.random.default_rng(0))
    picture = camera.picture(square.start, Twist2())
    points, normals = sample(square.edges, 0.02)
    for side in (0.008, -0.008):
        pixels = view.pixels(square.start.inverse().apply(points + side * normals))
        near = view.inside(pixels, 3) & (view.floor_points(pixels)[:, 0] < 0.5)
        columns, rows = np.rint(pixels[near]).astype(int).T
        assert len(rows) > 30
        assert ((picture[rows, columns] > 128) == (side > 0)).all()
