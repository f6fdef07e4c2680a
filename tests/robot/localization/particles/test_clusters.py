"""Particles in cells that touch are one cluster; what is far apart takes no memory."""

from __future__ import annotations

import math
import tracemalloc

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from robot.geometry import Array
from robot.localization.particles.clusters import Cells, find_clusters

CELLS = Cells(0.05, 36)


def rng(seed: int = 0) -> np.random.Generator:
    return np.random.default_rng(seed)


def even(poses: Array) -> Array:
    return np.full(len(poses), 1 / len(poses))


def blob(x: float, y: float, theta: float, count: int = 200) -> Array:
    poses = rng(count).normal([x, y, theta], [0.02, 0.02, 0.05], (count, 3))
    poses[:, 2] = (poses[:, 2] + math.pi) % (2 * math.pi) - math.pi
    return poses


def occupied(cells: Cells, poses: Array) -> int:
    return int(find_clusters(poses, even(poses), cells).cells.max()) + 1


def in_cells(*cells: tuple[int, int, int], turns: int = 36) -> Array:
    """Particles in the middles of cells; theta counts from -pi."""
    index = np.array(cells, dtype=float) + 0.5
    index[:, :2] *= 0.05
    index[:, 2] = index[:, 2] * (2 * math.pi / turns) - math.pi
    return index


def test_two_blobs_are_two_clusters_with_their_weights_means_and_spreads() -> None:
    light, heavy = blob(0, 0, 1.0), blob(1, 0.5, -1.0, 300)
    poses = np.vstack([light, heavy])
    weights = np.concatenate([np.full(200, 0.3 / 200), np.full(300, 0.7 / 300)])
    found = find_clusters(poses, weights, CELLS)
    assert [h.weight for h in found.hypotheses] == pytest.approx([0.7, 0.3])
    assert (found.labels == np.repeat([1, 0], [200, 300])).all()
    first, second = found.hypotheses
    assert (first.pose.x, first.pose.y) == pytest.approx((1, 0.5), abs=0.01)
    assert (second.pose.x, second.pose.theta) == pytest.approx((0, 1.0), abs=0.02)
    np.testing.assert_allclose(second.covariance, np.cov(light.T), atol=1e-9)


def test_one_blob_is_one_cluster_with_all_the_weight() -> None:
    found = find_clusters(blob(0.3, 0.2, 0.1), even(blob(0, 0, 0)), CELLS)
    assert len(found.hypotheses) == 1
    assert found.hypotheses[0].weight == pytest.approx(1)


def test_a_blob_across_half_a_turn_is_one() -> None:
    poses = blob(0, 0, math.pi)
    found = find_clusters(poses, even(poses), CELLS)
    assert len(found.hypotheses) == 1
    assert abs(abs(found.hypotheses[0].pose.theta) - math.pi) < 0.02
    assert found.hypotheses[0].covariance[2, 2] == pytest.approx(0.05**2, rel=0.3)


def count(poses: Array, cells: Cells = CELLS) -> int:
    found = find_clusters(poses, even(poses), cells, most=len(poses))
    assert found.labels.min() == 0 and found.labels.max() == len(found.hypotheses) - 1
    return len(found.hypotheses)


@pytest.mark.parametrize("step", [(1, 0, 0), (0, -1, 0), (0, 0, 1), (1, 1, 0), (1, -1, 1),
                                  (-1, -1, -1), (-1, 1, 1)])  # fmt: skip
def test_cells_that_touch_also_by_a_corner_are_one_cluster(step: tuple[int, int, int]) -> None:
    beside = (5 + step[0], 5 + step[1], 5 + step[2])
    assert count(in_cells((5, 5, 5), beside)) == 1
    apart = (5 + 2 * step[0], 5 + 2 * step[1], 5 + 2 * step[2])
    assert count(in_cells((5, 5, 5), apart)) == 2


@pytest.mark.parametrize("turns", [1, 2, 3, 36])
def test_the_last_cell_of_a_turn_touches_the_first(turns: int) -> None:
    cells = Cells(0.05, turns)
    assert count(in_cells((0, 0, 0), (0, 0, turns - 1), turns=turns), cells) == 1
    assert count(in_cells((0, 0, 0), (1, 1, turns - 1), turns=turns), cells) == 1
    assert count(in_cells((0, 0, 0), (2, 0, turns - 1), turns=turns), cells) == 2


def test_the_first_column_does_not_touch_the_last() -> None:
    assert count(in_cells((0, 0, 0), (3, 0, 0), (0, 3, 0))) == 3
    assert count(in_cells((0, 4, 0), (1, 0, 0), (2, 4, 0), (3, 0, 0))) == 4


def test_a_ring_of_cells_round_the_turn_falls_apart_where_it_is_cut_twice() -> None:
    ring = [(0, 0, turn) for turn in range(36)]
    assert count(in_cells(*ring)) == 1
    assert count(in_cells(*[c for c in ring if c[2] not in (9, 10)])) == 1
    assert count(in_cells(*[c for c in ring if c[2] not in (9, 10, 27, 28)])) == 2


@given(
    st.lists(
        st.tuples(st.integers(0, 6), st.integers(0, 6), st.integers(0, 5)),
        min_size=1,
        max_size=40,
    )
)
def test_clusters_are_those_of_plain_flood_fill(cells: list[tuple[int, int, int]]) -> None:
    poses = in_cells(*cells, turns=6)
    found = find_clusters(poses, even(poses), Cells(0.05, 6), most=40)
    left, groups = set(cells), []
    while left:
        front, group = [left.pop()], set()
        while front:
            x, y, t = front.pop()
            group.add((x, y, t))
            near = {c for c in left if abs(c[0] - x) < 2 and abs(c[1] - y) < 2
                    and (c[2] - t) % 6 in (0, 1, 5)}  # fmt: skip
            left -= near
            front += near
        groups.append(group)
    expected = sorted((sum(c in g for c in cells) for g in groups), reverse=True)
    assert sorted(np.bincount(found.labels), reverse=True) == expected
    for group in groups:
        labels = {int(found.labels[i]) for i, c in enumerate(cells) if c in group}
        assert len(labels) == 1


def test_of_many_clusters_the_heaviest_are_described() -> None:
    """Twelve places, their weights rising; the four lightest are only numbered."""
    places = rng().permutation(12)
    poses = np.vstack([blob(float(place), 0, 0, 20) for place in places])
    weights = np.repeat(places + 1.0, 20) / (20 * 78)
    found = find_clusters(poses, weights, CELLS, most=8)
    assert len(found.hypotheses) == 8
    assert [h.weight for h in found.hypotheses] == pytest.approx(np.arange(12, 4, -1) / 78)
    assert [round(h.pose.x) for h in found.hypotheses] == list(range(11, 3, -1))
    assert set(found.labels) == set(range(12))
    np.testing.assert_array_equal(found.labels, np.repeat(11 - places, 20))


def test_the_covariance_of_few_heavy_particles_is_not_too_small() -> None:
    """On average it is the true one, though the mean is taken from the same particles."""
    chance, found = rng(), []
    for _ in range(4000):
        poses = chance.normal(0, [0.01, 0.02, 0.03], (6, 3))
        weights = chance.uniform(0.1, 1, 6)
        one = find_clusters(poses, weights / weights.sum(), Cells(100.0, 1)).hypotheses[0]
        found.append(np.diag(one.covariance))
    np.testing.assert_allclose(np.mean(found, axis=0), [1e-4, 4e-4, 9e-4], rtol=0.04)


def test_a_cluster_without_weight_is_no_hypothesis() -> None:
    poses = np.vstack([blob(0, 0, 0, 10), blob(1, 1, 1, 10)])
    weights = np.repeat([0.1, 0.0], 10)
    found = find_clusters(poses, weights, CELLS)
    assert len(found.hypotheses) == 1
    assert (found.labels[10:] == 1).all()


@pytest.mark.parametrize("weight", [1e-120, 1e-200, 5e-324])
def test_nor_is_one_whose_weight_has_no_square(weight: float) -> None:
    poses = np.vstack([blob(0, 0, 0), blob(0.5, 0.5, 0)])
    weights = np.repeat([1 / 200, weight], 200)
    (one,) = find_clusters(poses, weights, CELLS).hypotheses
    assert one.weight == pytest.approx(1) and abs(one.pose.x) < 0.02


def test_a_single_particle_is_a_cluster_without_spread() -> None:
    found = find_clusters(np.array([[3.0, -2.0, 0.5]]), np.ones(1), CELLS)
    assert found.hypotheses[0].pose.to_array() == pytest.approx([3, -2, 0.5])
    np.testing.assert_array_equal(found.hypotheses[0].covariance, np.zeros((3, 3)))


def test_particles_scattered_over_a_city_take_no_more_memory_than_on_a_table() -> None:
    poses = rng().uniform([-5e3, -5e3, -math.pi], [5e3, 5e3, math.pi], (4000, 3))
    tracemalloc.start()
    found = find_clusters(poses, even(poses), CELLS)
    most = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert most < 20e6
    assert len(found.hypotheses) == 8
    assert occupied(CELLS, poses) == 4000


# --- cells


def test_cells_are_boxes_of_their_size() -> None:
    cells = Cells(0.5, 4)
    poses = np.array([
        [0.0, -0.1, -math.pi], [0.49, 0.4, -math.pi / 2 + 1e-9], [0.51, 0.51, 0.1], [-0.01, 0, 3.1]
    ])  # fmt: skip
    assert occupied(cells, poses) == 4
    assert occupied(cells, np.repeat(poses, 5, axis=0)) == 4
    beside = poses + np.array([0.003, 0.003, 0.01])
    assert occupied(cells, np.vstack([poses, beside])) == 4


def test_a_heading_of_half_a_turn_is_in_the_cell_of_minus_half_a_turn() -> None:
    either = np.array([[0, 0, math.pi], [0, 0, -math.pi], [0, 0, 3 * math.pi]])
    assert occupied(CELLS, either) == 1
    just_under = np.array([[0, 0, math.nextafter(math.pi, 0)]])
    assert count(np.vstack([just_under, [[0, 0, -math.pi]]])) == 1
