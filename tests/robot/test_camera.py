"""The lens maps directions to pixels one to one; the floor view maps pixels to the floor."""

from __future__ import annotations

import math

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from robot.camera import FloorView, Lens
from robot.description.spec import RobotSpec
from robot.geometry import Array

VIEW = RobotSpec.load().floor_view
LENS = VIEW.lens


def lens_of(distortion: tuple[float, ...], focal: float = 530.0) -> Lens:
    matrix = np.array([[focal, 0, 319.5], [0, focal * 1.01, 239.5], [0, 0, 1]])
    return Lens(640, 480, matrix, np.array(distortion))


def grid(lens: Lens, step: int = 16) -> Array:
    """Pixels over the whole picture, its corners included."""
    columns = np.append(np.arange(0, lens.width - 1, step), lens.width - 1.0)
    rows = np.append(np.arange(0, lens.height - 1, step), lens.height - 1.0)
    return np.stack(np.meshgrid(columns, rows), axis=-1).reshape(-1, 2)


def on_plane(radii: Array, angle: float) -> Array:
    """Points in front of the camera, by the tangent of their angle to the view."""
    across = radii[:, None] * (math.cos(angle), math.sin(angle))
    return np.column_stack([across, np.ones(len(radii))])


REAL_LENSES = [
    (0.16, -0.28, 0.0, 0.0, 0.0),
    (0.0, 0.0, 0.0, 0.0, 0.0),
    (-0.30, 0.10, 0.001, -0.002, 0.0),
    (0.20, -0.50, 0.002, 0.001, 0.3),
]


@pytest.mark.parametrize("distortion", REAL_LENSES)
def test_every_pixel_of_the_picture_looks_along_the_direction_that_it_shows(
    distortion: tuple[float, ...],
) -> None:
    lens = lens_of(distortion)
    pixels = grid(lens)
    directions = lens.unproject(pixels)
    assert directions.shape == (len(pixels), 3)
    np.testing.assert_array_equal(directions[:, 2], 1)
    np.testing.assert_allclose(lens.project(directions), pixels, atol=1e-6)
    np.testing.assert_allclose(lens.project(7.0 * directions), pixels, atol=1e-6)


@pytest.mark.parametrize("distortion", REAL_LENSES)
def test_the_lens_bends_as_opencv_has_it(distortion: tuple[float, ...]) -> None:
    lens = lens_of(distortion)
    points = np.random.default_rng(1).uniform([-0.5, -0.4, 0.7], [0.5, 0.4, 1.3], (200, 3))
    expected, _ = cv2.projectPoints(
        points, np.zeros(3), np.zeros(3), lens.matrix, np.array(distortion)
    )
    np.testing.assert_allclose(lens.project(points), expected.reshape(-1, 2), atol=1e-9)


def test_the_middle_of_the_picture_looks_straight_ahead_and_x_is_right_and_y_down() -> None:
    middle = LENS.matrix[:2, 2]
    np.testing.assert_allclose(LENS.project(np.array([[0, 0, 2.0]]))[0], middle)
    right, below = LENS.project(np.array([[0.1, 0, 1], [0, 0.1, 1]]))
    assert right[0] > middle[0] + 50 and right[1] == pytest.approx(middle[1])
    assert below[1] > middle[1] + 50 and below[0] == pytest.approx(middle[0])


def test_nothing_asked_is_nothing_answered() -> None:
    assert LENS.unproject(np.empty((0, 2))).shape == (0, 3)
    assert LENS.project(np.empty((0, 3))).shape == (0, 2)
    assert VIEW.floor_points(np.empty((0, 2))).shape == (0, 2)
    assert VIEW.pixels(np.empty((0, 2))).shape == (0, 2)


@pytest.mark.parametrize("z", [0.0, -1.0, -1e-12])
def test_what_is_not_in_front_of_the_camera_has_no_pixel(z: float) -> None:
    assert np.isnan(LENS.project(np.array([[0.0, 0.0, z], [0.01, 0.1, z]]))).all()


@pytest.mark.parametrize("k3", [0.0, 1e-17, -1e-17, 1e-300])
def test_points_far_outside_never_come_back_into_the_picture(k3: float) -> None:
    """k2 < 0: the polynomial turns back at 45 degrees and is through the middle at 65."""
    radii = np.linspace(0, 12, 3000)
    lens = lens_of((0.16, -0.28, 0, 0, k3))
    for angle in np.linspace(0, 2 * math.pi, 24):
        pixels = lens.project(on_plane(radii, angle))
        inside = VIEW.inside(pixels)
        reached = np.linalg.norm(pixels[inside] - lens.matrix[:2, 2], axis=1)
        assert (np.diff(reached) > 0).all(), "further out is further out in the picture"
        assert radii[inside].max() < 0.8
        assert np.isnan(pixels[radii > 1.02]).all()


@given(
    st.tuples(
        st.floats(-0.5, 0.5), st.floats(-0.5, 0.5), st.floats(-2e-3, 2e-3), st.floats(-2e-3, 2e-3),
        st.floats(-0.2, 0.2),
    ),
    st.floats(200, 800),
    st.integers(0, 2**32 - 1),
)  # fmt: skip
@settings(max_examples=60)
def test_no_two_directions_share_a_pixel(
    distortion: tuple[float, ...], focal: float, seed: int
) -> None:
    """A pixel leads back to the direction that it came from, or to none, never to another."""
    lens = lens_of(distortion, focal)
    rng = np.random.default_rng(seed)
    directions = np.column_stack([rng.uniform(-3, 3, (100, 2)), np.ones(100)])
    pixels = lens.project(directions)
    inside = FloorView(lens, np.eye(4)).inside(pixels)
    back = lens.unproject(pixels[inside])
    found = np.isfinite(back).all(axis=1)
    np.testing.assert_allclose(lens.project(back[found]), pixels[inside][found], atol=0.01)
    # Where the picture is all but folded, a hundredth of a pixel is a wide angle.
    slack = 0.01 / steepness(lens, directions[inside][found])
    off = np.linalg.norm(back[found] - directions[inside][found], axis=1)
    assert (off < 10 * slack + 1e-6).all()


def steepness(lens: Lens, directions: Array) -> Array:
    """Pixels by tangent, the least over two ways, near directions (n, 3)."""
    steps = np.array([[1e-4, 0, 0], [0, 1e-4, 0], [7e-5, 7e-5, 0], [7e-5, -7e-5, 0]])
    with np.errstate(invalid="ignore"):
        moved = [lens.project(directions + step) - lens.project(directions) for step in steps]
    slopes = np.linalg.norm(moved, axis=2) / 1e-4
    return np.maximum(np.nan_to_num(slopes.min(axis=0), nan=0.0), 1e-3)


def test_a_pixel_that_the_lens_sends_no_light_to_looks_nowhere() -> None:
    """k1 alone, -0.5: nothing arrives further out than 0.544 f."""
    lens = lens_of((-0.5, 0, 0, 0, 0))
    pixels = grid(lens)
    away = np.linalg.norm((pixels - [319.5, 239.5]) / [530, 530 * 1.01], axis=1)
    directions = lens.unproject(pixels)
    assert np.isnan(directions[away > 0.5444]).all()
    assert np.isfinite(directions[away < 0.52]).all()
    view = FloorView(lens, VIEW.robot_from_camera)
    assert np.isnan(view.floor_points(pixels[away > 0.5444])).all()


def test_the_floor_lies_where_the_mounting_says() -> None:
    """Without distortion and along the middle column: height / tan(pitch + angle of the row)."""
    view = FloorView(lens_of((0, 0, 0, 0, 0)), VIEW.robot_from_camera)
    rows = np.array([0.0, 100.0, 239.5, 479.0])
    points = view.floor_points(np.column_stack([np.full(4, 319.5), rows]))
    down = math.radians(35) + np.arctan((rows - 239.5) / (530 * 1.01))
    np.testing.assert_allclose(points[:, 0], 0.060 + 0.160 / np.tan(down), atol=1e-5)
    np.testing.assert_allclose(points[:, 1], 0, atol=1e-9)


def test_the_left_of_the_picture_is_the_left_of_the_robot() -> None:
    left, right = VIEW.floor_points(np.array([[100.0, 300.0], [539.0, 300.0]]))
    assert left[1] > 0.01 and right[1] == pytest.approx(-left[1])


def test_floor_and_picture_lead_into_each_other() -> None:
    pixels = grid(LENS)
    floor = VIEW.floor_points(pixels)
    assert np.isfinite(floor).all(), "this camera sees floor everywhere"
    np.testing.assert_allclose(VIEW.pixels(floor), pixels, atol=1e-6)


def test_no_floor_is_seen_at_or_above_the_horizon() -> None:
    level = np.array([[0, 0, 1, 0], [-1, 0, 0, 0], [0, -1, 0, 0.16], [0, 0, 0, 1.0]])
    view = FloorView(LENS, level)
    points = view.floor_points(np.array([[319.5, 0], [319.5, 239.5], [319.5, 240.5]]))
    assert np.isnan(points[:2]).all()
    assert points[2, 0] == pytest.approx(0.16 * 530, rel=1e-3)


def test_floor_behind_the_camera_has_no_pixel() -> None:
    assert np.isnan(VIEW.pixels(np.array([[-0.5, 0.0], [-0.05, 0.2]]))).all()
    assert np.isfinite(VIEW.pixels(np.array([[0.3, 0.0]]))).all()


def test_the_projective_transform_is_the_one_through_four_points() -> None:
    floor = np.array([[0.2, 0.1], [0.2, -0.1], [0.7, 0.3], [0.6, -0.3]])
    ideal = LENS.unproject(VIEW.pixels(floor))[:, :2]
    expected = cv2.getPerspectiveTransform(ideal.astype(np.float32), floor.astype(np.float32))
    found = VIEW.floor_from_picture
    np.testing.assert_allclose(found / found[2, 2], expected / expected[2, 2], rtol=2e-5, atol=2e-5)


def test_inside_means_between_the_middles_of_the_border_pixels() -> None:
    pixels = np.array([[0, 0], [639, 479], [-0.1, 5], [5, 479.1], [np.nan, 5], [2.9, 9], [3, 476]])
    assert VIEW.inside(pixels).tolist() == [True, True, False, False, False, True, True]
    assert VIEW.inside(pixels, 3).tolist() == [False] * 6 + [True]
