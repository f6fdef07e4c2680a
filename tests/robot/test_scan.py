"""A scan is ranges by bearing around a centre."""

from __future__ import annotations

import math

import numpy as np

from robot.geometry import Pose2
from robot.scan import Scan


def test_a_scan_knows_its_hits_and_their_places() -> None:
    scan = Scan(1.0, np.array([0, math.pi / 2, 1.0]), np.array([2.0, 1.0, np.inf]), Pose2(0.1))
    assert scan.hit.tolist() == [True, True, False]
    np.testing.assert_allclose(scan.points(), [[2.1, 0], [0.1, 1]], atol=1e-12)
    turned = Scan(1.0, np.zeros(1), np.ones(1), Pose2(0, 0, math.pi / 2))
    np.testing.assert_allclose(turned.points(), [[0, 1]], atol=1e-12)


def test_rays_that_end_see_and_return_nothing_beyond() -> None:
    ranges, ends = np.array([0.2, 0.6, np.inf, 0.6]), np.array([0.4, 0.4, 0.4, np.inf])
    sight = np.array([[0.0, 1.0], [0.1, 0.3], [0.5, 1.0], [0.0, 1.0]])
    scan = Scan(1.0, np.zeros(4), ranges, sight=sight)
    left = scan.until(ends)
    assert left.ranges.tolist() == [0.2, np.inf, np.inf, 0.6]
    np.testing.assert_array_equal(
        left.sight,
        [[0, 0.4], [0.1, 0.3], [np.nan, np.nan], [0, 1]],  # type: ignore[arg-type]
    )
    assert scan.until(np.full(4, np.inf)) is scan


def test_a_range_that_is_too_short_tells_nothing_and_one_too_long_is_none() -> None:
    scan = Scan(1.0, np.zeros(3), np.array([0.05, 0.5, 2.0]))
    left = scan.within(0.1, 1.0)
    assert left.ranges.tolist() == [np.inf, 0.5, np.inf]
    assert left.sight is not None
    assert np.isnan(left.sight).any(axis=1).tolist() == [True, False, False]
    assert scan.within(0.0, 3.0) is scan
