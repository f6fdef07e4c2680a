"""Rays are those of the scan that can see anything, as the robot sees them."""

from __future__ import annotations

import math

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from robot import ray_columns as column
from robot.geometry import Array, Pose2
from robot.scan import Scan, rays_of

BEARINGS = np.linspace(-0.5, 0.5, 11)
RANGES = np.linspace(0.2, 1.2, 11)


def ends(rays: Array) -> Array:
    """Of the rays that returned (n, 2) [m]."""
    hit = np.isfinite(rays[:, column.RANGE])
    directions = rays[hit, column.DIRECTION]
    toward = np.column_stack([np.cos(directions), np.sin(directions)])
    found: Array = rays[hit, :2] + rays[hit, 3:4] * toward
    return found


@given(st.floats(-1, 1), st.floats(-1, 1), st.floats(-3.1, 3.1))
def test_rays_end_where_the_points_of_the_scan_are(x: float, y: float, theta: float) -> None:
    scan = Scan(0.0, BEARINGS, RANGES, Pose2(x, y, theta))
    np.testing.assert_allclose(ends(rays_of(scan, 99)), scan.points(), atol=1e-12)


def test_a_ray_that_returned_nothing_is_a_ray() -> None:
    ranges = RANGES.copy()
    ranges[3] = math.inf
    rays = rays_of(Scan(0.0, BEARINGS, ranges, Pose2(0.1, 0.2, 0.3)), 99)
    assert len(rays) == 11
    np.testing.assert_allclose(rays[3, :4], [0.1, 0.2, 0.3 + BEARINGS[3], math.inf])


def test_a_scan_without_limits_sees_from_its_centre_to_anywhere() -> None:
    rays = rays_of(Scan(0.0, BEARINGS, RANGES), 99)
    np.testing.assert_array_equal(rays[:, 4:6], np.tile([0, math.inf], (11, 1)))


def test_a_ray_has_the_clearness_of_its_picture_and_is_clear_without() -> None:
    clear = np.linspace(0, 1, 11)
    np.testing.assert_array_equal(rays_of(Scan(0.0, BEARINGS, RANGES), 99)[:, 6], 1)
    rays = rays_of(Scan(0.0, BEARINGS, RANGES, clear=clear), 4)
    np.testing.assert_array_equal(rays[:, column.CLEAR], clear[[0, 3, 6, 10]])


def test_each_ray_keeps_its_own_limits_of_sight() -> None:
    sight = np.column_stack([0.1 + 0.01 * np.arange(11), 0.5 + 0.01 * np.arange(11)])
    rays = rays_of(Scan(0.0, BEARINGS, RANGES, sight=sight), 4)
    np.testing.assert_array_equal(rays[:, 4:6], sight[[0, 3, 6, 10]])
    np.testing.assert_array_equal(rays[:, column.DIRECTION], BEARINGS[[0, 3, 6, 10]])
    np.testing.assert_array_equal(rays[:, column.RANGE], RANGES[[0, 3, 6, 10]])


def test_rays_that_see_nowhere_are_marked() -> None:
    sight = np.tile([0.1, 0.5], (11, 1))
    sight[[0, 4]] = math.nan
    rays = rays_of(Scan(0.0, BEARINGS, RANGES, sight=sight), 99)
    np.testing.assert_array_equal(np.flatnonzero(np.isnan(rays[:, column.NEAR])), [0, 4])


@given(st.integers(0, 40), st.integers(1, 30))
def test_there_are_no_more_than_asked_for_and_they_span_the_scan(count: int, most: int) -> None:
    bearings = np.linspace(-0.5, 0.5, count)
    rays = rays_of(Scan(0.0, bearings, np.ones(count)), most)
    assert rays.shape == (min(count, most), 9)
    if min(count, most) > 1:
        directions = rays[:, column.DIRECTION]
        assert directions[0] == bearings[0] and directions[-1] == bearings[-1]
        assert (np.diff(directions) > 0).all()
