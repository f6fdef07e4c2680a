"""Rays of the scanner lie on the floor where they should, and in the picture."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from robot.camera import FloorView
from robot.description.spec import RobotSpec
from robot.scanning.edge_search import PARTS, REACH, SLANTED
from robot.scanning.ray_table import MARGIN_PX, RayTable

VIEW = RobotSpec.load().floor_view


@pytest.fixture(scope="module")
def table() -> RayTable:
    bearings = np.radians([-31.0, -20.0, 0.0, 5.0, 31.0, 90.0])
    return RayTable.build(VIEW, bearings, centre_x=0.0, range_max=1.0, step_px=0.75)


def test_samples_of_a_ray_lie_on_it_at_even_steps_in_the_picture(table: RayTable) -> None:
    for ray, bearing in enumerate(table.bearings[:5]):
        used = table.counts[ray]
        distances, pixels = table.distances[ray, :used], table.pixels[ray, :used]
        assert (np.diff(distances) > 0).all()
        floor = VIEW.floor_points(pixels.astype(np.float64))
        along = distances[:, None] * (math.cos(bearing), math.sin(bearing))
        # Pixels are kept as 32-bit numbers: at a metre, that is a few micrometres of floor.
        np.testing.assert_allclose(floor, along, atol=2e-5)
        steps = np.linalg.norm(np.diff(pixels, axis=0), axis=1)
        np.testing.assert_allclose(steps, 0.75, atol=0.01)
        assert VIEW.inside(pixels.astype(np.float64), MARGIN_PX - 1e-3).all()
        assert table.distances[ray, used:] == pytest.approx(distances[-1])


def test_a_ray_begins_and_ends_where_the_picture_does(table: RayTable) -> None:
    near, far = table.limits[2]
    rows = np.array([[319.5, 476.0], [319.5, 3.0]])
    first, last = VIEW.floor_points(rows)[:, 0]
    assert near == pytest.approx(first, abs=1e-3)
    assert far == pytest.approx(last, abs=5e-3)


def test_a_ray_that_the_camera_does_not_see_has_no_samples(table: RayTable) -> None:
    assert table.counts[5] == 0
    assert np.isnan(table.limits[5]).all()
    assert (table.counts[:5] > 100).all()


def test_a_ray_is_drawn_from_its_first_sample_to_its_last(table: RayTable) -> None:
    lines = table.lines(9)
    assert lines.shape == (6, 9, 2)
    np.testing.assert_array_equal(lines[:, 0], table.pixels[:, 0])
    np.testing.assert_array_equal(lines[2, -1], table.pixels[2, table.counts[2] - 1])


def test_each_sample_has_the_index_of_the_nearest_pixel(table: RayTable) -> None:
    rows, columns = np.divmod(table.pixel_indices.astype(int), VIEW.lens.width)
    apart = np.stack([columns, rows], axis=-1)[:5] - table.pixels[:5]
    assert np.abs(apart).max() <= 0.5


def test_equal_arguments_have_one_table_and_any_other_argument_another() -> None:
    told = {"centre_x": 0.0, "range_max": 1.0, "step_px": 0.75}
    ahead = np.zeros(1)
    one = RayTable.build(VIEW, ahead, **told)
    again = FloorView(replace(VIEW.lens), VIEW.robot_from_camera.copy())
    assert RayTable.build(again, ahead.copy(), **told) is one
    assert RayTable.build(VIEW, ahead + 0.1, **told) is not one
    for name, value in told.items():
        assert RayTable.build(VIEW, ahead, **told | {name: value + 0.01}) is not one
    lens, mounting = VIEW.lens, VIEW.robot_from_camera
    for other in (
        FloorView(replace(lens, matrix=lens.matrix + np.diag([1.0, 0.0, 0.0])), mounting),
        FloorView(replace(lens, distortion=1.01 * lens.distortion), mounting),
        FloorView(replace(lens, height=lens.height - 1), mounting),
        FloorView(replace(lens, readout=lens.readout + 1e-3), mounting),
        FloorView(lens, mounting + 1e-6 * np.eye(4)),
    ):
        assert other != VIEW
        assert RayTable.build(other, ahead, **told) is not one


def test_a_shorter_range_ends_a_ray_there() -> None:
    table = RayTable.build(VIEW, np.zeros(1), centre_x=0.1, range_max=0.3, step_px=0.5)
    assert table.limits[0, 1] == pytest.approx(0.3, abs=1e-3)
    floor = VIEW.floor_points(table.pixels[0, -1:].astype(np.float64))
    np.testing.assert_allclose(floor[0], [0.4, 0], atol=1e-3)


def searched(table: RayTable, kernel: int) -> np.ndarray:
    """Ends (n, 2) of all searches for an edge's place that there can be, as ``find_edges`` does."""
    found = []
    ends = kernel + REACH / PARTS
    for ray, count in enumerate(table.counts):
        place = np.arange(kernel + 1, count - kernel - 1)
        pixels = table.pixels[ray].astype(np.float64)
        half = (pixels[place + 1] - pixels[place - 1]) / 2
        room = (np.minimum(place, count - 1 - place) + 1) / ends
        for scale in (np.ones(len(place)), np.clip(room, 1.0, SLANTED)):
            away = (ends * scale)[:, None] * half
            found += [pixels[place] - away, pixels[place] + away]
    return np.concatenate(found)


@pytest.mark.parametrize("step", [0.25, 1.5, 2.5, 4.0])
@pytest.mark.parametrize("kernel", [1, 2, 20])
def test_edges_are_searched_within_the_picture_whatever_the_step(step: float, kernel: int) -> None:
    bearings = np.radians(np.linspace(-40, 40, 41))
    table = RayTable.build(VIEW, bearings, centre_x=0.0, range_max=10.0, step_px=step)
    ends = searched(table, kernel)
    assert len(ends) > 1000
    # Interpolated between four pixels: one more to the right and below.
    assert (ends >= 0).all()
    assert (ends < [VIEW.lens.width - 1, VIEW.lens.height - 1]).all()
