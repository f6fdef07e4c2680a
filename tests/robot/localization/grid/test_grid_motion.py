"""A step moves a belief in boxes by its mean and its variance, however short it is."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from robot.geometry import Array, Pose2, mean_pose, pose_covariance
from robot.localization.grid.grid_motion import moved_grid
from robot.localization.grid.pose_grid import Boxes, PoseGrid

BOXES = Boxes(0.00125, 1024)


def moments(grid: PoseGrid) -> tuple[Pose2, Array]:
    mean = mean_pose(grid.poses, grid.mass)
    return mean, pose_covariance(grid.poses, grid.mass, mean)


def one_box(heading: float, level: int = 0) -> PoseGrid:
    boxes = replace(BOXES, level=level)
    place = np.floor(boxes.places(np.array([[0.1, -0.2, heading]]))).astype(np.int64)
    return PoseGrid.of(boxes, place, np.ones(1))


steps = st.builds(Pose2, st.floats(-0.2, 0.2), st.floats(-0.2, 0.2), st.floats(-3, 3))
shares = st.tuples(*[st.floats(0.5, 1.4)] * 2)


@settings(max_examples=30)
@given(st.floats(-3.14, 3.14), steps, shares, st.integers(0, 4))
def test_a_step_that_errs_by_half_a_box_has_its_mean_and_variance(
    heading: float, step: Pose2, sds: tuple[float, ...], level: int
) -> None:
    """Though it be shorter than a box, and its end between the middles of boxes."""
    grid = one_box(heading, level)
    size = grid.boxes.size
    noise = np.diag(np.square(np.array([sds[0], sds[0], sds[1]]) * size))
    start = Pose2(*grid.poses[0].tolist())
    after = moved_grid(grid, step, noise)
    assert after.boxes == grid.boxes
    assert after.mass.sum() == pytest.approx(1) and (after.mass > 0).all()
    found, covariance = moments(after)
    wanted = start @ step
    assert found.distance_to(wanted) < 1e-9 and abs(found.turn_to(wanted)) < 1e-3 * size[2]
    np.testing.assert_allclose(np.diag(covariance), np.diag(noise), rtol=1e-3)


@settings(max_examples=30)
@given(st.floats(-3.14, 3.14), steps)
def test_a_step_without_noise_keeps_the_mean_and_blurs_by_half_a_box_at_most(
    heading: float, step: Pose2
) -> None:
    grid = one_box(heading)
    found, covariance = moments(moved_grid(grid, step, np.zeros((3, 3))))
    wanted = Pose2(*grid.poses[0].tolist()) @ step
    assert found.distance_to(wanted) < 1e-9 and abs(found.turn_to(wanted)) < 1e-6
    assert (np.diag(covariance) <= np.square(grid.boxes.size) / 4 + 1e-12).all()


@pytest.mark.parametrize("heading", [0.0, 1.0, math.pi / 2])
def test_noise_is_spread_along_the_heading(heading: float) -> None:
    grid = one_box(heading)
    turned = Pose2(*grid.poses[0].tolist()).theta
    sd = grid.boxes.size[0]
    noise = np.array([[1.0, 0.3, 0], [0.3, 0.4, 0], [0, 0, 0]]) * sd**2
    _, covariance = moments(moved_grid(grid, Pose2(), noise))
    c, s = math.cos(turned), math.sin(turned)
    R = np.array([[c, -s], [s, c]])
    expected = np.diag(R @ noise[:2, :2] @ R.T)
    np.testing.assert_allclose(np.diag(covariance)[:2], expected, atol=1e-9)


def test_a_step_that_errs_by_many_boxes_makes_them_coarser_and_is_as_wide() -> None:
    grid = one_box(0.5)
    sds = (0.03, 0.03, 0.1)
    after = moved_grid(grid, Pose2(0.01), np.diag(np.square(sds)))
    assert after.boxes.level > 0
    _, covariance = moments(after)
    np.testing.assert_allclose(np.sqrt(np.diag(covariance)), sds, rtol=0.12)


@pytest.mark.parametrize("sd", [0.9, 1.2, 1.5, 2.0, 3.2])
def test_a_heading_that_errs_by_more_than_the_widest_boxes_is_as_vague_as_the_noise(
    sd: float,
) -> None:
    """Of a direction noise leaves a mean of the length exp(-sd^2 / 2)."""
    grid = one_box(0.5)
    after = moved_grid(grid, Pose2(0, 0, 1.0), np.diag(np.square([0.05, 0.05, sd])))
    assert after.mass.sum() == pytest.approx(1)
    toward = after.mass @ np.exp(1j * after.poses[:, 2])
    assert abs(toward) == pytest.approx(math.exp(-(sd**2) / 2), abs=0.04)
    if sd < 2:
        assert abs(Pose2(0, 0, np.angle(toward)).turn_to(Pose2(0, 0, 1.5))) < 0.2
    # Places are cut no coarser than headings make it.
    assert after.boxes == Boxes(0.00125, 1024, 7)
    off = after.mass @ after.poses[:, :2] - grid.poses[0, :2]
    assert (np.abs(off) < after.boxes.size[:2] / 2).all()
