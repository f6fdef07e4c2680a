"""Boxes of poses are cut, put together and filled without moving what they stand for."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from stub_drive import draw_poses

from robot.geometry import Array, Pose2, mean_pose, pose_covariance
from robot.localization.filter import Cloud
from robot.localization.grid.pose_grid import (
    Boxes,
    Indices,
    PoseGrid,
    cloud_grid,
    even_grid,
    normal_grid,
    sum_alike,
)

BOXES = Boxes(0.00125, 1024)


def moments(grid: PoseGrid) -> tuple[Pose2, Array]:
    mean = mean_pose(grid.poses, grid.mass)
    return mean, pose_covariance(grid.poses, grid.mass, mean)


cells = arrays(np.int64, st.tuples(st.integers(1, 60), st.just(3)), elements=st.integers(-3, 3))


@settings(max_examples=30)
@given(cells)
def test_what_is_in_one_box_is_summed(places: Indices) -> None:
    mass: Array = 1.0 + np.arange(len(places), dtype=np.float64)
    once, total = sum_alike(places, mass)
    expected, inverse = np.unique(places, axis=0, return_inverse=True)
    order = np.lexsort(once.T[::-1])
    np.testing.assert_array_equal(once[order], expected)
    np.testing.assert_allclose(total[order], np.bincount(inverse.ravel(), mass))


def test_boxes_without_mass_are_left_out_and_far_ones_kept_apart() -> None:
    far = 2**40
    places = np.array([[far, 0, 0], [0, far, 0], [-far, 0, 0], [0, 0, 0], [far, 0, 0]])
    once, total = sum_alike(places, np.array([1.0, 2, 3, 0, 4]))
    assert dict(zip(once[:, 0].tolist(), total.tolist(), strict=True)) == {far: 5, 0: 2, -far: 3}


def some_grid(level: int = 2) -> PoseGrid:
    f = normal_grid(BOXES, Pose2(0.1, -0.2, 3.1), np.diag([1e-4, 4e-4, 4e-3]), 100_000)
    while f.boxes.level < level:
        f = f.coarser()
    return f


def test_headings_beyond_the_half_turn_are_those_on_the_other_side() -> None:
    grid = some_grid()
    assert set(grid.cells[:, 2]) <= set(range(grid.boxes.turns))
    assert (grid.poses[:, 2] < -3).any() and (grid.poses[:, 2] > 3).any()
    assert (np.abs(grid.poses[:, 2]) < np.pi).all()


def test_cut_and_put_together_again_it_is_the_same_grid() -> None:
    grid = some_grid()
    again = grid.finer().coarser()
    assert again.boxes == grid.boxes
    before = dict(zip(map(tuple, grid.cells.tolist()), grid.mass, strict=True))
    after = dict(zip(map(tuple, again.cells.tolist()), again.mass, strict=True))
    assert before == pytest.approx(after)


def test_boxes_cut_into_eight_lie_where_the_one_was() -> None:
    grid = some_grid()
    finer = grid.finer()
    assert len(finer.mass) == 8 * len(grid.mass)
    np.testing.assert_allclose(finer.boxes.size, grid.boxes.size / 2)
    middles = finer.poses.reshape(-1, 8, 3)
    np.testing.assert_allclose(middles.mean(axis=1), grid.poses, atol=1e-12)
    assert finer.mass.sum() == pytest.approx(1)


def test_headings_are_cut_no_coarser_than_an_eighth_and_boxes_then_into_four() -> None:
    grid = PoseGrid.of(Boxes(0.00125, 1024, 9), np.array([[3, -2, 5]]), np.ones(1))
    assert grid.boxes.turns == 8
    assert len(grid.finer().mass) == 4
    np.testing.assert_allclose(grid.finer().coarser().poses, grid.poses)


@settings(max_examples=30)
@given(
    st.tuples(st.floats(-1, 1), st.floats(-1, 1), st.floats(-3.14, 3.14)),
    st.tuples(*[st.sampled_from([0.0, 0.001, 0.01, 0.1])] * 2, st.sampled_from([0.0, 0.01, 0.3])),
    st.sampled_from([1000, 40_000]),
)
def test_a_normal_distribution_has_its_moments(
    mean: tuple[float, ...], sds: tuple[float, ...], most: int
) -> None:
    grid = normal_grid(BOXES, Pose2(*mean), np.diag(np.square(sds)), most)
    size = grid.boxes.size
    assert len(grid.mass) <= most
    found, covariance = moments(grid)
    off = np.array([found.x - mean[0], found.y - mean[1], Pose2(*mean).turn_to(found)])
    assert (np.abs(off) < 0.05 * size).all()
    # It is half a box wide at least, and cut off where it is thin.
    expected = np.sqrt(np.square(sds) + np.square(size) / 4)
    np.testing.assert_allclose(np.sqrt(np.diag(covariance)), expected, rtol=0.12)


def test_a_normal_distribution_of_any_heading_goes_once_round() -> None:
    grid = normal_grid(BOXES, Pose2(0, 0, 0.1), np.diag(np.square([0.01, 0.01, 3.0])), 10_000)
    by_heading = np.bincount(grid.cells[:, 2], grid.mass, grid.boxes.turns)
    assert (by_heading > 0).all()
    # The box on the other side must not be counted from both.
    opposite = grid.boxes.places(np.array([[0, 0, 0.1 - np.pi]]))[0, 2]
    assert by_heading[int(opposite)] < by_heading.mean()


def test_a_cloud_is_put_into_boxes_that_hold_several_each() -> None:
    poses = draw_poses(np.random.default_rng(0), Pose2(0, 0, 3.1), (0.03, 0.02, 0.1), 4000)
    weights = np.linspace(0, 1, 4000) / np.linspace(0, 1, 4000).sum()
    grid = cloud_grid(BOXES, Cloud(poses, weights))
    inside = np.unique(np.floor(grid.boxes.places(poses)), axis=0)
    assert 4000 / 32 < len(inside) <= 4000 / 4
    found, covariance = moments(grid)
    wanted = mean_pose(poses, weights)
    assert found.distance_to(wanted) < 1e-9 and abs(found.turn_to(wanted)) < 1e-3
    expected = pose_covariance(poses, weights, wanted)
    assert (np.diag(covariance) < np.diag(expected) + np.square(grid.boxes.size) / 4 + 1e-9).all()
    assert (np.diag(covariance) > np.diag(expected)).all()


def test_a_few_poses_are_put_into_the_finest_boxes() -> None:
    poses = np.array([[0.1, 0.2, 0.3], [-0.4, 0.1, 2.0]])
    grid = cloud_grid(BOXES, Cloud(poses, np.array([0.75, 0.25])))
    assert grid.boxes.level == 0
    for pose, weight in zip(poses, (0.75, 0.25), strict=True):
        here = (np.abs(grid.poses - pose) < grid.boxes.size).all(axis=1)
        assert grid.mass[here].sum() == pytest.approx(weight)
        np.testing.assert_allclose(grid.mass[here] @ grid.poses[here] / weight, pose, atol=1e-9)


@pytest.mark.parametrize("count", [9, 20, 50, 100, 127])
def test_some_poses_all_over_the_map_are_put_into_boxes_as_wide_as_it(count: int) -> None:
    """However wide, boxes hold a quarter of the map and an eighth of a turn each: up to 32."""
    rng = np.random.default_rng(count)
    poses = rng.uniform([-0.6, -0.6, -3.14], [0.6, 0.6, 3.14], (count, 3))
    grid = cloud_grid(BOXES, Cloud.even(poses))
    assert grid.boxes.turns == 8 and 0.1 < grid.boxes.size[0] <= 1.28
    here = np.floor(grid.boxes.places(poses)).astype(int).tolist()
    assert {tuple(cell) for cell in here} <= {tuple(cell) for cell in grid.cells.tolist()}
    assert grid.mass @ grid.poses[:, :2] == pytest.approx(poses[:, :2].mean(axis=0))


def test_an_even_grid_weighs_boxes_by_how_much_of_them_is_free() -> None:
    rng = np.random.default_rng(0)
    places = rng.uniform([-0.5, -0.5], [0.5, 0.06], (200_000, 2))
    grid = even_grid(BOXES, places, 20_000)
    xy = grid.boxes.size[0]
    assert 20_000 / 8 < len(grid.mass) <= 20_000
    for turn in range(grid.boxes.turns):
        assert grid.mass[grid.cells[:, 2] == turn].sum() == pytest.approx(1 / grid.boxes.turns)
    x, y = grid.poses[:, 0], grid.poses[:, 1]
    full = grid.mass[(np.abs(x) < 0.4) & (y < -0.1) & (y > -0.4)]
    cut = grid.mass[(np.abs(x) < 0.4) & (np.abs(y - 0.06) <= xy / 2)]
    share = (0.06 % xy) / xy
    assert 0 < share < 1
    assert cut.mean() / full.mean() == pytest.approx(share, rel=0.05)
    assert full.std() / full.mean() < 0.15
