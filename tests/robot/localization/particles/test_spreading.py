"""Copies are spread as wide as their cluster is, whatever chance drew."""

from __future__ import annotations

import math

import numpy as np
import pytest

from robot.geometry import Array
from robot.localization.kernels.spread_copies import lower_root
from robot.localization.particles.clusters import Cells, Clusters, find_clusters
from robot.localization.particles.resampling import low_variance, regularize


def rng(seed: int = 0) -> np.random.Generator:
    return np.random.default_rng(seed)


def all_of(poses: Array) -> Array:
    """Each particle once."""
    return np.arange(len(poses))


def find_start_clusters(poses: Array) -> Clusters:
    return find_clusters(poses, np.full(len(poses), 1 / len(poses)), Cells(0.05, 36))


def sausage(count: int = 4000) -> Array:
    """Particles along a wall: 0.3 m one way, 2 mm the other, and slanted."""
    values = rng().normal(0, [0.3, 0.002, 0.01], (count, 3))
    turn = np.array([[math.cos(0.5), math.sin(0.5)], [-math.sin(0.5), math.cos(0.5)]])
    values[:, :2] = values[:, :2] @ turn
    return values


def one_cluster(poses: Array) -> Clusters:
    """Cells so large that all is one."""
    found = find_clusters(poses, np.full(len(poses), 1 / len(poses)), Cells(100.0, 1))
    assert len(found.hypotheses) == 1
    return found


def test_no_scale_is_no_spread() -> None:
    poses = sausage()
    drawn = np.repeat(all_of(poses)[::2], 2)
    spread = regularize(poses, one_cluster(poses), drawn, 0.0, rng())
    np.testing.assert_array_equal(spread, poses[drawn])


def test_copies_of_one_particle_are_spread_by_the_bandwidth_along_each_axis() -> None:
    """Most along the wide direction of its cluster, hardly across it."""
    poses = sausage()
    found = one_cluster(poses)
    poses[0] = found.means[0]
    spread = regularize(poses, found, np.zeros(4000, dtype=np.int64), 1.0, rng(1)) - poses[0]
    bandwidth = (4 / (5 * 4000)) ** (1 / 7)
    np.testing.assert_allclose(
        np.cov(spread.T), bandwidth**2 * found.covariances[0], rtol=0.1, atol=2e-5
    )
    across = spread[:, :2] @ (-math.sin(0.5), math.cos(0.5))
    along = spread[:, :2] @ (math.cos(0.5), math.sin(0.5))
    assert along.std() == pytest.approx(bandwidth * 0.3, rel=0.05)
    assert across.std() < 0.002


@pytest.mark.parametrize("scale", [0.35, 1.0, 2.0])
@pytest.mark.parametrize("copied", [1, 10])
def test_a_cluster_keeps_its_mean_and_its_covariance(scale: float, copied: int) -> None:
    """Else, where nothing is measured, it would grow with every scan, or die out."""
    poses = sausage()
    poses[:, 2] += math.pi - 0.01
    poses[:, 2] = (poses[:, 2] + math.pi) % (2 * math.pi) - math.pi
    found = one_cluster(poses)
    spread = regularize(
        poses, found, np.repeat(all_of(poses)[:: 4 * copied], copied), scale, rng(1)
    )
    assert ((spread[:, 2] >= -math.pi) & (spread[:, 2] < math.pi)).all()
    before, after = found.hypotheses[0], one_cluster(spread).hypotheses[0]
    assert after.pose.distance_to(before.pose) < 1e-9
    assert abs(after.pose.turn_to(before.pose)) < 1e-9
    np.testing.assert_allclose(after.covariance, before.covariance, atol=1e-9)


def test_copies_are_near_the_particles_that_they_are_of() -> None:
    """The shape of a cluster stays: here two lumps within one cell, and nothing in between."""
    lumps = rng().normal(0, 0.05, (2000, 3)) + np.repeat([[-1.0, 0, 0], [1.0, 0, 0]], 1000, axis=0)
    drawn = all_of(lumps)
    spread = regularize(lumps, one_cluster(lumps), drawn, 0.3, rng())
    assert np.mean(np.abs(spread[:, 0]) < 0.5) < 0.001


def test_each_cluster_is_spread_by_its_own_width() -> None:
    wide, narrow = rng().normal(0, 0.03, (500, 3)), rng(1).normal(0, 0.001, (400, 3))
    narrow[:, 0] += 2
    poses = np.vstack([narrow, wide])
    found = find_start_clusters(poses)
    spread = regularize(poses, found, all_of(poses), 1.0, rng())
    far = spread[:, 0] > 1
    assert far.sum() == 400
    np.testing.assert_allclose(np.cov(spread[far].T), np.cov(narrow.T), atol=1e-9)
    np.testing.assert_allclose(np.cov(spread[~far].T), found.covariances[0], atol=1e-9)


def test_particles_of_no_described_cluster_and_single_ones_stay() -> None:
    poses = np.vstack([rng().normal(0, 0.01, (50, 3)), [[1.0, 1.0, 0.5]]])
    for most in (1, 8):
        found = find_clusters(poses, np.full(51, 1 / 51), Cells(0.05, 36), most)
        spread = regularize(poses, found, all_of(poses), 1.0, rng())
        np.testing.assert_allclose(spread[spread[:, 0] > 0.5], poses[50:], atol=1e-15)
        assert len(spread) == 51


def test_where_all_particles_are_one_all_copies_are() -> None:
    poses = np.tile([1.0, 2.0, 3.0], (100, 1))
    spread = regularize(poses, one_cluster(poses), all_of(poses), 1.0, rng())
    np.testing.assert_allclose(spread, poses, atol=1e-12)


def test_the_given_poses_stay_as_they_were() -> None:
    poses = rng().normal([0, 0, math.pi], [0.01, 0.01, 0.3], (300, 3))
    poses[:, 2] = (poses[:, 2] + math.pi) % (2 * math.pi) - math.pi
    before = poses.copy()
    found = find_start_clusters(poses)
    spread = regularize(poses, found, all_of(poses), 1.0, rng())
    assert ((spread[:, 2] >= -math.pi) & (spread[:, 2] < math.pi)).all()
    np.testing.assert_array_equal(poses, before)


def test_a_root_is_lower_triangular_and_its_square_the_covariance() -> None:
    for seed in range(20):
        rows = rng(seed).normal(0, [1, 0.01, 0.1], (4, 3))
        root = lower_root(rows.T @ rows)
        np.testing.assert_allclose(root @ root.T, rows.T @ rows, rtol=1e-9)
        assert (np.triu(root, 1) == 0).all()
    assert (lower_root(np.zeros((3, 3))) == 0).all()


def drawn_often(scale: float, seed: int) -> Array:
    """Weighed by chance 600 times: nothing is learnt of anything. 0.1 wide at the start."""
    poses, chance = rng().normal(0, 0.1, (300, 3)), rng(seed)
    for _ in range(600):
        weights = chance.uniform(0.2, 1, 300)
        weights /= weights.sum()
        cluster = find_clusters(poses, weights, Cells(100.0, 1))
        poses = regularize(poses, cluster, low_variance(weights, 300, chance), scale, chance)
    return poses


def test_without_it_only_copies_of_a_few_particles_are_left() -> None:
    assert len(np.unique(drawn_often(0.0, 2), axis=0)) < 15


def test_spread_by_it_a_width_neither_dies_out_nor_grows() -> None:
    """Chance still makes it wander: not to one side, over 24 variances, and not far."""
    ends = [drawn_often(1.0, seed) for seed in range(8)]
    widths = np.array([one.std(axis=0) / 0.1 for one in ends])
    assert all(len(np.unique(one, axis=0)) == 300 for one in ends)
    assert 0.6 < np.mean(widths**2) < 1.4
    assert np.abs(np.log(widths)).max() < 1.2
