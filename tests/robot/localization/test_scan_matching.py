"""A scan laid on the edges gives the pose, and how well it is known in each direction."""

from __future__ import annotations

import math

import numpy as np
import pytest
from floor_looks import cast_ray
from hypothesis import given
from hypothesis import strategies as st
from stub_drive import MAPS, STUB, Drive, near

from robot import ray_columns as column
from robot.fields.edge_index import index_edges
from robot.fields.field import Field
from robot.fields.field_loading import load_field
from robot.geometry import Array, Pose2
from robot.localization.scan_matching import TAIL, ScanMatcher
from robot.scan import rays_of

SQUARE = load_field("square", MAPS)
SD = 0.01
OFFSET = Pose2(0.05, 0.03, 0.4)
CORNER = Pose2(-0.1, 0.1, 2.3)
"""From here a corner is seen, which tells all three."""
BEFORE_A_WALL = Pose2(-0.2, 0.2, math.pi / 2)
"""From here only one side is seen, which lies along x."""
WALL = index_edges(np.array([[1.0, 1.0, 1.0, -1.0]]))


def matcher(of: Field = STUB, gate: float = 0.08) -> ScanMatcher:
    return ScanMatcher(of.edge_index, 1.0, SD, gate)


def rays_at(true: Pose2, robot_from_scan: Pose2 = Pose2(), of: Field = STUB) -> Array:
    """With hardly any noise."""
    return rays_of(Drive(true, robot_from_scan=robot_from_scan, edges_of=of).scan(), 99)


def expected(pose: Array, ray: Array) -> tuple[float, int]:
    """What a ray should measure at a pose, and on which edge."""
    start = Pose2.from_array(pose) @ Pose2(ray[0], ray[1], ray[2])
    return cast_ray(start.x, start.y, start.theta, STUB.edge_index, 1.0)


# --- what it says of how well the pose is known


@pytest.mark.parametrize("offset", [Pose2(), OFFSET], ids=["centre", "offset"])
@pytest.mark.parametrize("true", [CORNER, Pose2(0.05, -0.1, -0.6), Pose2(0, 0.02, 0.1)], ids=str)
def test_information_is_that_of_the_change_of_ranges(true: Pose2, offset: Pose2) -> None:
    """J^T W J with J by differences of cast rays, W for ends that err evenly across edges."""
    rays, h = rays_at(true, offset), 1e-6
    chosen, wanted = [], np.zeros((3, 3))
    for ray in rays:
        steps = h * np.vstack([np.eye(3), -np.eye(3)])
        cast = [expected(true.to_array() + step, ray) for step in steps]
        edges = {edge for _, edge in cast}
        if len(edges) > 1 or -1 in edges:
            continue
        chosen.append(ray)
        ranges = np.array([distance for distance, _ in cast])
        J = (ranges[:3] - ranges[3:]) / (2 * h)
        along = np.diff(STUB.edges[edges.pop()].reshape(2, 2), axis=0)[0]
        angle = math.atan2(along[1], along[0]) - (true.theta + ray[2])
        wanted += np.outer(J, J) * math.sin(angle) ** 2 / SD**2
    assert len(chosen) > 40
    match = matcher().match(true, np.array(chosen))
    assert match.used == len(chosen)
    np.testing.assert_allclose(match.information, wanted, rtol=0.01, atol=1e-3 * wanted.max())


def test_the_pose_errs_as_the_information_says() -> None:
    """Ends that err across edges by the spread supposed: 3 is the mean of an honest one."""
    rng, squared = np.random.default_rng(0), []
    exact = rays_at(CORNER)
    for _ in range(150):
        rays = exact.copy()
        for ray in rays:
            distance, edge = expected(CORNER.to_array(), ray)
            along = np.diff(STUB.edges[edge].reshape(2, 2), axis=0)[0]
            sine = math.sin(math.atan2(along[1], along[0]) - CORNER.theta - ray[2])
            ray[3] = distance + 0.3 * SD * rng.standard_normal() / abs(sine)
        match = ScanMatcher(STUB.edge_index, 1.0, 0.3 * SD, 0.08).match(CORNER, rays)
        off = match.pose.to_array() - CORNER.to_array()
        squared.append(off @ match.information @ off)
    assert 2.5 < np.mean(squared) < 3.8


def test_along_a_wall_it_says_nothing_and_stays() -> None:
    start = BEFORE_A_WALL @ Pose2(0.01, 0.02, 0.03)
    match = matcher().match(start, rays_at(BEFORE_A_WALL))
    assert match.pose.x == pytest.approx(start.x, abs=1e-4)
    assert match.pose.y == pytest.approx(BEFORE_A_WALL.y, abs=5e-4)
    assert match.pose.theta == pytest.approx(BEFORE_A_WALL.theta, abs=2e-3)
    values, axes = np.linalg.eigh(match.information)
    assert values[0] < 1e-6 * values[1]
    np.testing.assert_allclose(np.abs(axes[:, 0]), [1, 0, 0], atol=0.01)


# --- where it ends


@pytest.mark.parametrize("offset", [Pose2(), OFFSET], ids=["centre", "offset"])
@pytest.mark.parametrize("turn", [-0.05, 0.05])
@pytest.mark.parametrize("direction", np.arange(0, 6.28, math.pi / 4))
def test_it_finds_the_pose_from_three_centimetres_and_degrees(
    direction: float, turn: float, offset: Pose2
) -> None:
    start = Pose2(
        CORNER.x + 0.03 * math.cos(direction),
        CORNER.y + 0.03 * math.sin(direction),
        CORNER.theta + turn,
    )
    match = matcher().match(start, rays_at(CORNER, offset))
    assert near(match.pose, CORNER, 0.001, 0.003)


def test_what_was_known_pulls_as_much_as_it_weighs() -> None:
    """One ray straight at a wall: the pose is the mean, weighed by information."""
    for known, sd in ((1.0, SD), (1e3, SD), (1e4, SD), (1e6, SD), (100.0, 0.1), (3.0, 1.0)):
        # So close that Cauchy's weights are one.
        ray = np.array([[0.0, 0, 0, 1.002, 0, np.inf, 1.0]])
        information = np.diag([known, 7.0, 9.0])
        match = ScanMatcher(WALL, 2.0, sd, 0.1).match(Pose2(0.0003 - 0.002), ray, information)
        measured = 1 / sd**2
        wanted = -0.002 + known * 0.0003 / (known + measured)
        # It stops where a step would be shorter than a thousandth of what is known.
        assert abs(match.pose.x - wanted) < 1e-3 / math.sqrt(known + measured)
        assert (match.pose.y, match.pose.theta) == (0, 0)
        wanted_information = information + np.diag([measured, 0, 0])
        np.testing.assert_allclose(match.information, wanted_information, rtol=2e-4)


@pytest.mark.parametrize("known", [1.0, 1e3, 3e4])
def test_what_surprises_pulls_less(known: float) -> None:
    """Five standard deviations off: where prior and Cauchy's pull are in balance."""
    ray = np.array([[0.0, 0, 0, 1.02, 0, np.inf, 1.0]])
    match = ScanMatcher(WALL, 2.0, SD, 0.1).match(Pose2(0.03), ray, np.diag([known, 7.0, 9.0]))
    x = match.pose.x
    residual = x + 0.02
    weight = 1 / SD**2 / (1 + residual**2 / SD**2 / TAIL)
    assert known * (0.03 - x) == pytest.approx(weight * residual, rel=0.02, abs=0.1)
    # Beyond the tail it pulls still, but tells nothing for sure.
    told = weight if residual**2 / SD**2 < TAIL else 0.0
    assert match.information[0, 0] == pytest.approx(known + told, rel=0.01)


@given(st.floats(-0.02, 0.02), st.floats(-0.04, 0.04), st.sampled_from([0.0, 1e3, 1e5]))
def test_a_heading_is_the_same_across_the_half_turn(
    aside: float, turn: float, known: float
) -> None:
    """On a square, which looks the same from the other side."""
    information = np.diag([known, known, known / 10])
    true = Pose2(0.15, 0.1, 0.02)
    start = true @ Pose2(0.01, aside, turn)
    for quarter in range(4):
        turned = Pose2(0, 0, quarter * math.pi / 2)
        rays = rays_at(true, of=SQUARE)
        here = matcher(SQUARE).match(start, rays, information)
        there = matcher(SQUARE).match(turned @ start, rays, information)
        assert near(turned @ here.pose, there.pose, 1e-5, 1e-5)


def test_what_was_known_of_the_heading_pulls_the_short_way_across_the_half_turn() -> None:
    """The ray turns it from just below the half turn to above it; the prior hardly pulls back."""
    here = Pose2(0.0, 0.2, math.pi - 0.01)
    length = 0.475 / math.cos(0.02) + 0.3 * math.tan(0.02)
    rays = np.array([[0.0, 0.3, 0.0, length, 0, np.inf, 1.0]])
    match = matcher(SQUARE).match(here, rays, np.diag([1e9, 1e9, 30.0]))
    measured = 0.3**2 / SD**2
    assert here.turn_to(match.pose) * (1 + 30 / measured) == pytest.approx(0.03, rel=0.05)


def test_a_heading_that_comes_out_is_within_a_half_turn() -> None:
    true = Pose2(0.15, 0.1, math.pi - 0.001)
    start = (true @ Pose2(0.01, 0.01, -0.03)).to_array()
    true = true @ Pose2(0, 0, 0.003)
    found = matcher().match(Pose2.from_array(start), rays_at(true)).pose.to_array()
    assert found[2] == pytest.approx(true.theta, abs=0.001)


# --- which rays count


def test_ranges_beyond_the_gate_do_not_count() -> None:
    rays = rays_at(CORNER)
    rays[::4, column.RANGE] += 0.09
    strict, lenient = matcher().match(CORNER, rays), matcher(gate=0.2).match(CORNER, rays)
    assert strict.used == len(rays) - len(rays[::4])
    assert near(strict.pose, CORNER, 0.0005, 0.002)
    assert lenient.used == len(rays) and not near(lenient.pose, CORNER, 0.005, 0.01)


@pytest.mark.parametrize("rays", [np.zeros((0, 7)), rays_at(Pose2(3, 3, 0))], ids=["none", "miss"])
def test_without_returns_the_pose_stays(rays: Array) -> None:
    information = np.diag([1.0, 2.0, 3.0])
    match = matcher().match(CORNER, rays, information)
    assert match.pose == CORNER and match.used == 0
    np.testing.assert_array_equal(match.information, information)


def test_a_return_where_no_edge_is_does_not_count() -> None:
    outside = Pose2(0.7, 0.7, 0.8)
    rays = rays_at(CORNER)
    assert matcher().match(outside, rays).used == 0


def test_an_edge_nearer_than_sight_begins_is_not_the_one_that_was_met() -> None:
    """Across the stub: 0.175 m off is its edge, 0.675 m off the side behind it."""
    here = Pose2(0.3, 0.2, -math.pi / 2)
    ray = np.array([[0.0, 0, 0, 0.665, 0, np.inf, 1.0]])
    assert matcher().match(here, ray).used == 0
    ray[0, 4] = 0.25
    match = matcher().match(here, ray)
    assert match.used == 1
    assert match.pose.y == pytest.approx(0.19, abs=1e-4)


# --- a step is taken only if the cost falls


def cost_of(pose: Pose2, start: Pose2, known: Array, rays: Array, gate: float = 0.08) -> float:
    """Of the prior and of all rays, by Cauchy; a ray that fits no edge costs as one at the gate."""
    off = start.to_array() - pose.to_array()
    off[2] = pose.turn_to(start)
    cost = float(off @ known @ off)
    for ray in rays[np.isfinite(rays[:, column.RANGE])]:
        away, edge = expected(pose.to_array(), ray)
        square = (gate / SD) ** 2
        if edge >= 0 and abs(ray[3] - away) <= gate:
            x0, y0, x1, y1 = STUB.edges[edge]
            sine = math.sin(math.atan2(y1 - y0, x1 - x0) - pose.theta - ray[2])
            square = ((ray[3] - away) * sine / SD) ** 2
        cost += TAIL * math.log1p(square / TAIL)
    return cost


@pytest.mark.parametrize("known", [0.0, 100.0, 1e5])
def test_a_match_never_costs_more_than_where_it_began(known: float) -> None:
    """From anywhere, also where rays change over from one edge to another."""
    rng, moved = np.random.default_rng(0), 0
    information = np.diag([known, known, known / 10])
    for _ in range(60):
        true = Pose2.from_array(STUB.free_poses(rng, 1)[0])
        rays = rays_at(true)
        start = true @ Pose2(*rng.normal(0, 0.05, 2), rng.normal(0, 0.2))
        found = matcher().match(start, rays, information).pose
        before, after = (cost_of(pose, start, information, rays) for pose in (start, found))
        assert after <= before + 1e-9
        moved += after < before
    assert moved > 50


def test_rays_to_another_edge_do_not_pull() -> None:
    """A fifth of the rays end 70 mm before the edge that they should meet, within the gate."""
    rays = rays_at(CORNER)
    wrong = rays.copy()
    wrong[::5, 3] -= 0.07
    clean, pulled = (matcher().match(CORNER, one) for one in (rays, wrong))
    # Where all ranges are as good as exact beside their spread, it is least squares.
    squares = ScanMatcher(STUB.edge_index, 1.0, 1.0, 0.08).match(CORNER, wrong)
    assert pulled.used == clean.used == len(rays)
    assert squares.pose.distance_to(clean.pose) > 0.008
    assert pulled.pose.distance_to(clean.pose) < 0.5 * squares.pose.distance_to(clean.pose)
    assert np.trace(pulled.information) < 0.95 * np.trace(clean.information)


def test_far_ranges_pull_less_by_the_slope() -> None:
    ray = np.array([[0.0, 0, 0, 0.5, 0, np.inf, 1.0]])
    wall = index_edges(np.array([[0.5, 1.0, 0.5, -1.0]]))
    found = ScanMatcher(wall, 1.0, SD, 0.08, slope=8.0).match(Pose2(), ray)
    spread = SD * (1 + 8.0 * 0.5**2)
    assert found.information[0, 0] == pytest.approx(1 / spread**2)
