"""Rays are paired with exact edges, and their differences are counted right."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from sensor_trials import BEARINGS, FIELD, TRUTH, scan_at

from app.features.lab.model_fits.range_pairs import (
    FAR_OFF,
    RangePairs,
    by_bearing,
    by_distance,
    overall,
    pair_ranges,
)
from robot.fields.field import Field
from robot.geometry import Array, Pose2
from robot.localization.models.beam import MISSED_AT_END, MISSED_AT_START
from robot.scan import Scan


def facing(*distances: float) -> Field:
    """Edges across the x axis, met from the origin."""
    edges = np.array([[x, 9.0, x, -9.0] for x in distances])
    return replace(FIELD, edges=edges)


def pair_of(field: Field, measured: float, sight: Array | None = None) -> RangePairs:
    """One ray along x from the origin."""
    scan = Scan(0.0, np.zeros(1), np.array([measured]), sight=sight)
    return pair_ranges(field, [scan], [Pose2()], 1.0)


@pytest.mark.parametrize("ahead", [0.0, 0.06])
def test_perfect_scans_are_as_expected(ahead: float) -> None:
    poses = [TRUTH, TRUTH @ Pose2(0.05, 0.02, 0.3)]
    scans = [scan_at(pose, ahead=ahead) for pose in poses]
    pairs = pair_ranges(FIELD, scans, poses, 1.0)
    np.testing.assert_allclose(pairs.measured, pairs.expected, atol=1e-12)
    assert (pairs.sure == pairs.returned).all()
    assert (pairs.empty == ~pairs.returned).all()
    np.testing.assert_array_equal(pairs.scan, np.repeat([0, 1], len(BEARINGS)))
    np.testing.assert_array_equal(pairs.ray, np.tile(np.arange(len(BEARINGS)), 2))
    np.testing.assert_array_equal(pairs.bearings, np.tile(BEARINGS, 2))


def test_another_pose_than_the_true_one_is_told_by_the_residuals() -> None:
    scan = scan_at(Pose2(-0.01), bearings=np.zeros(1))
    pairs = pair_ranges(FIELD, [scan], [Pose2()], 1.0)
    assert pairs.residuals == pytest.approx(0.01)


@pytest.mark.parametrize(
    ("expected", "sight", "sure"),
    [
        (0.5, (0.1, 0.6), True),
        (0.5, (0.1, 0.5 + MISSED_AT_END - 0.001), False),
        (0.5, (0.5 - MISSED_AT_START + 0.001, 0.9), False),
        (0.5, (0.5 - MISSED_AT_START - 0.001, 0.9), True),
    ],
)
def test_an_edge_is_surely_seen_where_the_beam_model_has_it_seen(
    expected: float, sight: tuple[float, float], sure: bool
) -> None:
    pairs = pair_of(facing(expected), math.inf, np.array([sight]))
    assert pairs.sure == sure
    assert not pairs.empty


def test_an_edge_below_the_view_hides_nothing_and_one_beyond_it_is_not_there() -> None:
    pairs = pair_of(facing(0.05, 0.5), 0.5, np.array([[0.2, 0.9]]))
    assert pairs.expected == pytest.approx(0.5)
    assert pair_of(facing(0.7), math.inf, np.array([[0.2, 0.6]])).empty
    assert pair_of(facing(1.2), math.inf).expected == math.inf


def test_a_return_from_just_before_sight_is_of_the_edge_there() -> None:
    """Scanners find where rays meet an edge's line, also if beside the ray only is it seen."""
    pairs = pair_of(facing(0.195, 0.5), 0.1951, np.array([[0.2, 0.9]]))
    assert pairs.residuals == pytest.approx(1e-4)
    assert not pairs.sure


def test_rays_that_see_nowhere_are_left_out_and_far_returns_are_none() -> None:
    sight = np.array([[0.0, 2.0], [math.nan, math.nan], [0.0, 2.0]])
    scan = Scan(0.0, np.array([0.0, 0.1, 0.2]), np.array([1.4, 0.3, 0.4]), sight=sight)
    pairs = pair_ranges(facing(0.5), [scan], [Pose2()], 1.0)
    assert pairs.ray.tolist() == [0, 2]
    assert pairs.measured.tolist() == [math.inf, 0.4]
    assert pairs.sight[:, 1].max() == 1.0


def test_scans_without_their_poses_are_refused() -> None:
    with pytest.raises(ValueError, match="2 scans and 1 poses"):
        pair_ranges(FIELD, [scan_at(TRUTH)] * 2, [TRUTH], 1.0)
    with pytest.raises(ValueError, match="0 scans"):
        pair_ranges(FIELD, [], [], 1.0)


# --- statistics


def rays(measured: list[float], expected: list[float], sure: list[bool]) -> RangePairs:
    count = len(measured)
    return RangePairs(
        np.array(measured),
        np.array(expected),
        np.linspace(-0.5, 0.5, count),
        np.zeros(count, dtype=int),
        np.arange(count),
        np.array(sure),
        np.tile([0.0, 1.0], (count, 1)),
    )


MIXED = rays(
    [0.301, 0.303, math.inf, 0.1, 0.7, math.inf, 0.602, math.inf],
    [0.3, 0.3, 0.3, 0.3, math.inf, math.inf, 0.6, 0.95],
    [True, True, True, True, False, False, True, False],
)


def test_figures_are_those_counted_by_hand() -> None:
    found = overall(MIXED)
    assert (found.count, found.expected, found.returns) == (3, 5, 5)
    assert found.bias == pytest.approx(0.002)
    assert found.sd == pytest.approx(0.001)
    assert found.robust_sd == pytest.approx(1.4826e-3)
    assert found.missed == pytest.approx(2 / 5)
    assert found.false == pytest.approx(2 / 5)


def test_bins_hold_what_was_expected_and_what_was_returned_there() -> None:
    near, middle, far = by_distance(MIXED, np.array([0.0, 0.2, 0.5, 0.9]))
    assert (near.count, near.expected, near.returns, near.false) == (0, 0, 1, 1.0)
    assert math.isnan(near.bias) and math.isnan(near.missed)
    assert (middle.count, middle.expected, middle.missed, middle.false) == (2, 4, 0.5, 0.0)
    assert (far.count, far.expected, far.returns, far.false) == (1, 1, 2, 0.5)
    assert far.bias == pytest.approx(0.002)
    assert math.isnan(far.sd)


def test_bins_of_bearings_hold_all_rays() -> None:
    bins = by_bearing(MIXED, np.array([-0.6, 0.0, 0.6]))
    assert [one.expected for one in bins] == [4, 1]
    assert sum(one.count for one in bins) == overall(MIXED).count
    assert bins[0].bias == pytest.approx(0.002)


def test_a_few_wild_ranges_do_not_widen_the_robust_spread() -> None:
    off = np.random.default_rng(0).normal(0.0005, 0.001, 4000)
    off[:40] = 0.9 * FAR_OFF
    found = overall(rays((0.5 + off).tolist(), [0.5] * 4000, [True] * 4000))
    assert found.robust_sd == pytest.approx(0.001, rel=0.06)
    assert found.sd > 0.002
