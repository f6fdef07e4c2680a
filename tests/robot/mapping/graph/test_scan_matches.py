"""Scans that are laid on each other, and looked for in a window."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from laser_office import LASER, START, office_map

from robot.fields.ray_casting import cast_rays
from robot.geometry import Pose2
from robot.mapping.graph.branch_and_bound import Window, best_pose
from robot.mapping.graph.likelihood_pyramid import CELL, LikelihoodPyramid
from robot.mapping.graph.point_to_line import match_scans
from robot.mapping.graph.surfaces import Surfaces
from robot.mapping.grid.beams import Beams
from robot.scan import Scan

NOISE_M = 0.01


def beams_at(pose: Pose2, rng: np.random.Generator, noise: float = NOISE_M) -> Beams:
    """What the office's laser sees."""
    exact = np.empty((1, LASER.beams))
    sensor = (pose @ LASER.place).to_array()[None]
    cast_rays(sensor, LASER.bearings, office_map().field.edge_index, LASER.reach, exact)
    ranges = exact[0] + rng.normal(0, noise, LASER.beams)
    return Beams.of_scan(Scan(0.0, LASER.bearings, ranges, LASER.place), 20.0)


def surfaces_at(pose: Pose2, seed: int = 0, noise: float = NOISE_M) -> Surfaces:
    return Surfaces.of_beams(beams_at(pose, np.random.default_rng(seed), noise))


def test_surfaces_face_the_laser() -> None:
    surfaces = surfaces_at(START, noise=0.001)
    known = np.isfinite(surfaces.spread)
    assert known.mean() > 0.85
    toward = LASER.place.to_array()[:2] - surfaces.points[known]
    assert ((toward * surfaces.normals[known]).sum(axis=1) > 0).all()
    # Walls of the office are along the axes, seen from a robot that has turned.
    turned = np.arctan2(*surfaces.normals[known].T[::-1]) + START.theta
    assert np.quantile(np.abs(np.sin(2 * turned)), 0.9) < 0.05


@settings(max_examples=30, deadline=None)
@given(st.integers(0, 10**6))
def test_a_match_tells_a_displacement_within_millimetres(seed: int) -> None:
    rng = np.random.default_rng(seed)
    moved = Pose2(*rng.uniform(-0.4, 0.4, 2), rng.uniform(-0.4, 0.4))
    supposed = Pose2(*(moved.to_array() + rng.uniform(-1, 1, 3) * (0.1, 0.1, 0.05)))
    match = match_scans(
        surfaces_at(START @ moved, seed), surfaces_at(START, -seed % 97), supposed, 0.3
    )
    assert match.pose.distance_to(moved) < 0.012
    assert abs(match.pose.turn_to(moved)) < 0.004
    assert match.share > 0.9
    off = match.pose.offset_to(moved)
    assert off @ match.information @ off < 16  # 99.9 %


def test_matches_err_by_millimetres_on_average() -> None:
    far = []
    for seed in range(20):
        moved = Pose2(0.2, -0.1, 0.2)
        match = match_scans(
            surfaces_at(START @ moved, seed), surfaces_at(START, 100 + seed), moved, 0.3
        )
        far.append(match.pose.distance_to(moved))
    assert np.median(far) < 0.004


def corridor(seed: int) -> Surfaces:
    """Two walls of 20 m, 2 m apart, with neither end in sight."""
    x = np.linspace(-10, 10, 120)
    rng = np.random.default_rng(seed)
    left = np.column_stack([x, 1 + rng.normal(0, NOISE_M, 120)])
    right = np.column_stack([x, -1 + rng.normal(0, NOISE_M, 120)])
    ends = np.vstack([right, left[::-1]])
    return Surfaces.of_beams(Beams(np.zeros_like(ends), ends, ends, np.ones(240, bool)))


def test_a_corridor_does_not_tell_how_far_along_it() -> None:
    for seed in range(5):
        match = match_scans(corridor(seed), corridor(50 + seed), Pose2(0.15, 0.05, 0.01), 0.3)
        assert abs(match.pose.y) < 0.005
        assert match.information[0, 0] < 1 / 0.1**2
        assert match.information[1, 1] > 1 / 0.02**2


@settings(max_examples=15, deadline=None)
@given(st.integers(0, 10**6))
def test_branch_and_bound_finds_what_a_whole_search_does(seed: int) -> None:
    rng = np.random.default_rng(seed)
    lines = rng.uniform(-2, 2, (6, 4))
    points = rng.uniform(-1.5, 1.5, (12, 2))
    window = Window(
        Pose2(*rng.uniform(-0.3, 0.3, 3)), np.array([0.4, 0.3, 0.2]), rng.uniform(0, 3, 3)
    )
    quick = best_pose(LikelihoodPyramid([lines], 5), points, window, 0.0)
    slow = best_pose(LikelihoodPyramid([lines], 1), points, window, 0.0)
    assert quick is not None and slow is not None
    assert quick[1] == pytest.approx(slow[1], abs=1e-6)


@pytest.mark.parametrize("seed", range(3))
def test_a_search_finds_a_robot_that_is_metres_off(seed: int) -> None:
    rng = np.random.default_rng(seed)
    moved = Pose2(*rng.uniform(-1, 1, 2), rng.uniform(-0.6, 0.6))
    field = LikelihoodPyramid([surfaces_at(START).lines(Pose2())], 6)
    window = Window(Pose2(), np.array([2.0, 2.0, 0.8]))
    found = best_pose(field, surfaces_at(START @ moved, seed).points, window, 0.5)
    assert found is not None
    assert found[0].distance_to(moved) < 2 * CELL
    assert abs(found[0].turn_to(moved)) < 0.02
    assert best_pose(field, rng.uniform(-5, 5, (100, 2)), window, 0.5) is None
