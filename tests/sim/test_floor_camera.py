"""Pictures show the floor where projection says, and err as a real camera does."""

from __future__ import annotations

import dataclasses
import math
import tracemalloc

import cv2
import numpy as np
import pytest
from floor_looks import grey_at
from numpy.typing import NDArray
from places import MAPS

from robot.camera import FloorView, Lens
from robot.description.spec import RobotSpec
from robot.fields.field_loading import load_field
from robot.fields.floor_picture import FloorPicture
from robot.geometry import Array, Pose2, Twist2
from sim.clutter import add_uneven_light
from sim.floor_camera import CameraSettings, FloorCamera
from sim.floor_samples import FloorSamples

SPEC = RobotSpec.load()
STUB = load_field("stub", MAPS).floor
SQUARE = load_field("square", MAPS).floor
IDEAL = CameraSettings(exposure=0, blur=0, noise=0, vignetting=0)
STILL = Twist2()
LIGHT, DARK = 213, 34
TILT = np.eye(4)
TILT[:2, :2] = [[math.cos(0.1), -math.sin(0.1)], [math.sin(0.1), math.cos(0.1)]]


def view_of(*, width: int = 640, readout: float = 0.0) -> FloorView:
    """The robot's camera with another size and readout [s]."""
    scale = width / 640
    matrix = SPEC.lens.matrix * scale
    matrix[:2, 2] += (scale - 1) / 2  # pixel centres are whole, the border is half a pixel out
    matrix[2, 2] = 1
    lens = Lens(width, round(480 * scale), matrix, SPEC.lens.distortion, readout)
    return FloorView(lens, SPEC.robot_from_camera)


def camera_of(
    view: FloorView, floor: FloorPicture, settings: CameraSettings, seed: int = 0
) -> FloorCamera:
    return FloorCamera(view, floor, settings, np.random.default_rng(seed))


def even_floor(grey: int) -> FloorPicture:
    return FloorPicture(np.full((400, 400), grey, dtype=np.uint8), 0.01, (-2.0, -2.0, 2.0, 2.0))


@pytest.fixture(scope="module")
def ideal() -> FloorCamera:
    return camera_of(view_of(), STUB, IDEAL)


@pytest.fixture(scope="module")
def small() -> FloorView:
    return view_of(width=160)


def test_a_pixel_shows_the_mean_of_the_floor_that_it_sees(small: FloorView) -> None:
    """Against brute force: each pixel as 8 x 8 places of the floor picture."""
    pose = Pose2(-0.1, 0.15, 2.2)
    picture = camera_of(small, STUB, IDEAL).picture(pose, STILL)
    part = (np.arange(8) + 0.5) / 8 - 0.5
    rows = (np.arange(120)[:, None] + part).ravel()
    columns = (np.arange(160)[:, None] + part).ravel()
    pixels = np.stack(np.meshgrid(columns, rows), axis=-1).reshape(-1, 2)
    seen = grey_at(STUB, pose.apply(small.floor_points(pixels)))
    mean = seen.reshape(120, 8, 160, 8).mean(axis=(1, 3))
    off = picture - mean
    assert abs(off.mean()) < 0.1
    assert np.abs(off).mean() < 0.8
    assert np.percentile(np.abs(off), 99.5) < 40


def test_what_is_too_fine_to_be_seen_is_grey_and_not_a_pattern(small: FloorView) -> None:
    """Stripes across the view, 2 mm dark and 2 mm light, where a pixel covers 9 mm and more."""
    image = np.full((3000, 1000), 255, dtype=np.uint8)
    image[:, np.arange(1000) % 4 < 2] = 0
    floor = FloorPicture(image, 0.001, (0.0, -1.5, 1.0, 1.5))
    picture = camera_of(small, floor, IDEAL).picture(Pose2(), STILL)
    far = small.floor_points(np.array([[79.5, 21.5], [79.5, 22.5]]))
    assert far[0, 0] - far[1, 0] > 0.009
    assert picture[3:22, 60:100].std() < 15, "an alias would swing by the full 120"
    assert picture[3:22, 60:100].mean() == pytest.approx(127.5, abs=3)


def crossing(levels: Array) -> float:
    """Where a row of grey levels that falls from light to dark is half way, in pixels."""
    middle = (LIGHT + DARK) / 2
    first = int(np.flatnonzero((levels[:-1] >= middle) & (levels[1:] < middle))[0])
    return first + float((levels[first] - middle) / (levels[first] - levels[first + 1]))


def seen_edge(picture: NDArray[np.uint8], columns: NDArray[np.intp]) -> Array:
    """Row of the tape's near edge in each column, looking up from the lower border."""
    return np.array([479 - crossing(picture[::-1, u].astype(float)) for u in columns])


def true_edge(view: FloorView, robot: Pose2, columns: NDArray[np.intp]) -> Array:
    """Row in which the square's edge x = 0.475 m lies in each column."""
    y = np.linspace(-0.47, 0.47, 2000)
    edge = robot.inverse().apply(np.column_stack([np.full_like(y, 0.475), y]))
    pixels = view.pixels(edge)
    pixels = pixels[np.isfinite(pixels).all(axis=1)]
    order = np.argsort(pixels[:, 0])
    return np.interp(columns, pixels[order, 0], pixels[order, 1])


@pytest.mark.parametrize("ahead", [0.2, 0.3, 0.5])
def test_an_edge_is_where_projection_says_to_a_fiftieth_of_a_pixel(ahead: float) -> None:
    view = view_of()
    camera = camera_of(view, SQUARE, dataclasses.replace(IDEAL, blur=0.7))
    robot, columns = Pose2(0.475 - ahead, 0.02, 0.06), np.arange(220, 420, 3)
    off = seen_edge(camera.picture(robot, STILL), columns) - true_edge(view, robot, columns)
    assert abs(off.mean()) < 0.02
    assert off.std() < 0.06


def width_of(picture: NDArray[np.uint8], column: int) -> float:
    """Rows from 90 % to 10 % of the step from floor to tape, looking up from the border."""
    levels = picture[::-1, column].astype(float)
    steps = [LIGHT - part * (LIGHT - DARK) for part in (0.1, 0.9)]
    high, low = (
        next(
            i + (levels[i] - step) / (levels[i] - levels[i + 1])
            for i in range(len(levels) - 1)
            if levels[i] >= step > levels[i + 1]
        )
        for step in steps
    )
    return low - high


def test_motion_blur_widens_an_edge_and_does_not_move_it() -> None:
    view = view_of()
    robot, columns = Pose2(0.2, 0.0, 0.0), np.arange(250, 390, 5)
    sharp = camera_of(view, SQUARE, dataclasses.replace(IDEAL, blur=0.7))
    slow = camera_of(view, SQUARE, dataclasses.replace(IDEAL, blur=0.7, exposure=0.04))
    still, moving = sharp.picture(robot, STILL), slow.picture(robot, Twist2(0.3, 0))
    off = seen_edge(moving, columns) - seen_edge(still, columns)
    assert abs(off.mean()) < 0.15, "12 mm on the way are 9 pixels"
    near, far = (view.pixels(np.array([[x, 0.0]]))[0, 1] for x in (0.269, 0.281))
    widening = width_of(moving, 320) - width_of(still, 320)
    assert 0.5 * (near - far) < widening < near - far
    standing = slow.picture(robot, STILL)
    assert width_of(standing, 320) == pytest.approx(width_of(still, 320), abs=0.1)
    np.testing.assert_allclose(seen_edge(standing, columns), seen_edge(still, columns), atol=0.1)


def test_a_blurred_edge_has_no_steps() -> None:
    """Each step was an edge of its own: tape close to a fast robot was judged bent."""
    slow = camera_of(view_of(), SQUARE, dataclasses.replace(IDEAL, blur=0.7, exposure=0.03))
    moving = slow.picture(Pose2(0.2, 0.0, 0.0), Twist2(0.3, 0))
    levels = moving[:, 320].astype(float)
    falls = -np.diff(levels)[::-1]
    edge = falls[np.argmax(falls > 3) :][: int(width_of(moving, 320))]
    assert len(edge) > 4
    assert edge.min() > 0.4 * edge.max()


@pytest.fixture(scope="module")
def clouds() -> FloorPicture:
    """A floor on which every row of every picture shows something."""
    rough = np.random.default_rng(0).normal(size=(1000, 1000)).astype(np.float32)
    smooth = cv2.GaussianBlur(rough, (0, 0), 8)
    image = np.clip(127 + 60 * smooth / smooth.std(), 0, 255).astype(np.uint8)
    return FloorPicture(image, 0.002, (-1.0, -1.0, 1.0, 1.0))


def test_a_moving_picture_is_the_mean_of_still_ones_along_the_way(
    small: FloorView, clouds: FloorPicture
) -> None:
    twist, robot = Twist2(0.3, 2.0), Pose2(0.1, -0.1, 0.4)
    exposed = camera_of(small, clouds, dataclasses.replace(IDEAL, exposure=0.06))
    at_once = camera_of(small, clouds, IDEAL)
    times = 0.06 * ((np.arange(40) + 0.5) / 40 - 0.5)
    stills = [at_once.picture(robot @ twist.integrate(float(t)), STILL) for t in times]
    off = exposed.picture(robot, twist) - np.mean(stills, axis=0)
    assert abs(off.mean()) < 0.1
    assert off.std() < 2.5
    assert (exposed.picture(robot, STILL) - np.mean(stills, axis=0)).std() > 10


@pytest.mark.parametrize("twist", [Twist2(0.3, 0), Twist2(0, 2.5), Twist2(-0.2, -1.5)])
def test_each_row_is_exposed_later_than_the_one_above(twist: Twist2, clouds: FloorPicture) -> None:
    """A row of the moving picture is that row of a still picture from where the robot then is."""
    view = view_of(width=320, readout=0.03)
    camera, robot = camera_of(view, clouds, IDEAL), Pose2(0.1, 0.05, 0.3)
    moving = camera.picture(robot, twist).astype(int)
    for row in (0, 60, 180, 239):
        late = 0.03 * (row / 239 - 0.5)
        off = moving[row] - camera.picture(robot @ twist.integrate(late), STILL)[row]
        skewed = moving[row] - camera.picture(robot, STILL)[row].astype(int)
        assert off.std() < 0.5 and np.abs(off).max() <= 3
        assert skewed.std() > 3


def test_vignetting_takes_its_share_in_the_corners_and_nothing_in_the_middle() -> None:
    view = view_of(width=320)
    settings = dataclasses.replace(IDEAL, vignetting=0.4)
    picture = camera_of(view, even_floor(200), settings).picture(Pose2(), STILL)
    np.testing.assert_allclose(picture[[0, 0, -1, -1], [0, -1, 0, -1]], 200 * 0.6, atol=1)
    assert picture[119:121, 159:161] == pytest.approx(200, abs=1)
    np.testing.assert_allclose(picture[[0, -1, 120, 120], [160, 160, 0, -1]], 200 * 0.8, atol=1.5)
    np.testing.assert_array_equal(picture, picture[::-1, ::-1])


@pytest.mark.parametrize("sd", [1.0, 3.0, 15.0])
def test_noise_is_as_wide_as_set_and_moves_no_mean(sd: float, small: FloorView) -> None:
    camera = camera_of(small, even_floor(128), dataclasses.replace(IDEAL, noise=sd))
    pictures = np.array([camera.picture(Pose2(), STILL) for _ in range(10)], dtype=float)
    assert pictures.std() == pytest.approx(math.hypot(sd, 12**-0.5), rel=0.05)
    assert pictures.mean() == pytest.approx(128, abs=0.1 * sd)
    rows = np.corrcoef(pictures.reshape(10, -1))
    assert np.abs(rows[~np.eye(10, dtype=bool)]).max() < 0.05, "no two pictures share their noise"
    one = pictures[0]
    assert abs(np.corrcoef(one[:, 1:].ravel(), one[:, :-1].ravel())[0, 1]) < 0.05, "it is white"


@pytest.mark.parametrize("grey", [0, 255])
def test_noise_does_not_turn_black_into_white(grey: int, small: FloorView) -> None:
    camera = camera_of(small, even_floor(grey), dataclasses.replace(IDEAL, noise=20))
    assert np.abs(camera.picture(Pose2(), STILL).astype(int) - grey).max() < 120


def test_without_noise_a_picture_is_the_same_each_time(ideal: FloorCamera) -> None:
    first = ideal.picture(Pose2(0.1, 0, 1), Twist2(0.2, 1))
    assert np.array_equal(first, ideal.picture(Pose2(0.1, 0, 1), Twist2(0.2, 1)))
    assert (first.dtype, first.shape) == (np.uint8, (480, 640))


def test_a_robot_that_stands_is_not_drawn_again_and_one_that_moves_is(small: FloorView) -> None:
    camera = camera_of(small, STUB, IDEAL)
    place = Pose2(0.1, 0, 1)
    stands = camera.expose(place, STILL)
    assert camera.expose(place, STILL) is stands
    assert not np.array_equal(camera.expose(Pose2(0.1, 0.02, 1), STILL), stands)
    camera.turn(dataclasses.replace(small, robot_from_camera=SPEC.robot_from_camera @ TILT))
    assert not np.array_equal(camera.expose(place, STILL), stands)


def test_the_same_seed_gives_the_same_pictures_bit_for_bit(small: FloorView) -> None:
    def pictures(seed: int) -> list[bytes]:
        camera = camera_of(small, STUB, CameraSettings(), seed)
        return [camera.picture(Pose2(0.1, 0, a), Twist2(0.2, a)).tobytes() for a in range(3)]

    assert pictures(5) == pictures(5)
    assert all(one != other for one, other in zip(pictures(5), pictures(6), strict=True))


def test_beyond_the_floor_and_above_the_horizon_is_the_tone_of_its_border() -> None:
    level = np.array([[0, 0, 1, 0], [-1, 0, 0, 0], [0, -1, 0, 0.16], [0, 0, 0, 1.0]])
    view = FloorView(view_of(width=160).lens, level)
    picture = camera_of(view, STUB, IDEAL).picture(Pose2(0.6, 0.6, 0.8), STILL)
    np.testing.assert_array_equal(picture, STUB.border)


def test_the_left_of_the_floor_is_on_the_left_and_far_is_above(ideal: FloorCamera) -> None:
    """From the middle of the square, looking along x: dark only at the stub's place."""
    spot = np.full((2000, 2000), LIGHT, dtype=np.uint8)
    spot[895:905, 1345:1355] = DARK  # x = 0.35 m, y = +0.10 m
    floor = FloorPicture(spot, 0.001, (-1.0, -1.0, 1.0, 1.0))
    view = view_of()
    picture = camera_of(view, floor, IDEAL).picture(Pose2(), STILL)
    rows, columns = np.nonzero(picture < 120)
    seen = view.floor_points(np.array([[columns.mean(), rows.mean()]]))[0]
    np.testing.assert_allclose(seen, [0.35, 0.10], atol=5e-4)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["square", "stub", "town"])
def test_floor_of_one_tone_is_not_sampled_and_gives_the_same_picture(name: str) -> None:
    """To the last bit, also off the drawing, at any speed and where the light is uneven."""
    floor = load_field(name, MAPS).floor
    if name == "stub":
        floor = add_uneven_light(floor, 0.5, np.random.default_rng(0))
    quick, thorough = (FloorSamples(view_of(readout=0.015), floor, 0.03) for _ in range(2))
    # Now no strip lies on one tone, and no tile.
    seen = thorough._seen
    tiles = seen.tiles + np.array([0, 0, 1e6, 0])
    thorough._seen = dataclasses.replace(seen, spread=seen.spread + 1e6, tiles=tiles)
    rng = np.random.default_rng(1)
    for _ in range(10):
        pose = Pose2(*rng.uniform(-1.2, 1.2, 2), rng.uniform(-math.pi, math.pi))
        twist = Twist2(rng.uniform(-0.3, 0.3), rng.uniform(-2, 2))
        assert np.array_equal(quick.average(pose, twist), thorough.average(pose, twist))


def test_cameras_of_one_kind_above_one_floor_share_their_tables():
    """Students' robots are copies of a process that has had one: what is the same is there."""
    view, settings = view_of(), CameraSettings(noise=0)
    first = camera_of(view, SQUARE, settings)
    noise_table = (480 + 64) * (640 + 64) * 2
    tracemalloc.start()
    try:
        second = camera_of(view, SQUARE, settings)
        taken, _ = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    assert taken < noise_table + 100_000
    there = Pose2(0.1, 0.2, 0.3)
    np.testing.assert_array_equal(first.picture(there, STILL), second.picture(there, STILL))
