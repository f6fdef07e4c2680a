"""Graphs of poses: adjustment, covariance, and loops that are refused."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from robot.geometry import Array, Pose2
from robot.mapping.graph.constraints import Constraint, ConstraintArrays
from robot.mapping.graph.key_frames import KeyFrames
from robot.mapping.graph.loop_closing import Closure, LoopCloser
from robot.mapping.graph.pose_graph import PoseGraph
from robot.mapping.graph.surfaces import Surfaces

EXACT = np.diag([1e4, 1e4, 1e6])
NOTHING = Surfaces(np.zeros((0, 2)), np.zeros((0, 2)), np.zeros(0), np.zeros(0, bool))


def ring(seed: int, nodes: int = 12) -> tuple[PoseGraph, Array]:
    """A drive around a ring, measured well from step to step, and its true poses."""
    rng = np.random.default_rng(seed)
    step = Pose2(0.5, 0.0, 2 * math.pi / nodes)
    graph, true = PoseGraph(Pose2()), [Pose2()]
    for node in range(1, nodes):
        true.append(true[-1] @ step)
        moved = step @ Pose2(*rng.normal(0, 0.01, 3))
        graph.add_pose(graph.pose(node - 1) @ moved)
        graph.add_constraints([Constraint(node - 1, node, moved, EXACT)])
    return graph, np.array([pose.to_array() for pose in true])


@settings(max_examples=20, deadline=None)
@given(st.integers(0, 10**6))
def test_the_jacobian_is_that_of_finite_differences(seed: int) -> None:
    rng = np.random.default_rng(seed)
    graph, _ = ring(seed, 5)
    graph.add_constraints(
        [Constraint(1, 4, Pose2(*rng.uniform(-2, 2, 3)), np.diag(rng.uniform(1, 9, 3)))]
    )
    parts, poses = ConstraintArrays.of(graph.constraints), graph.poses
    jacobian = parts.jacobian(poses, np.ones(len(graph.constraints))).toarray()
    tiny = 1e-6
    for column in range(poses.size):
        change = np.zeros(poses.size)
        change[column] = tiny
        ahead, behind = (parts.residuals(poses + sign * change.reshape(-1, 3)) for sign in (1, -1))
        assert jacobian[:, column] == pytest.approx((ahead - behind).ravel() / (2 * tiny), abs=1e-3)


def test_a_loop_is_closed_and_makes_the_end_certain() -> None:
    graph, true = ring(1)
    before = np.hypot(*(graph.poses - true)[-1, :2])
    uncertain = graph.covariance(11, 0)
    moved = Pose2.from_array(true[11])
    graph.add_constraints([Constraint(0, 11, moved, EXACT)])
    graph.adjust()
    assert np.hypot(*(graph.poses - true)[-1, :2]) < 0.5 * before
    assert np.trace(graph.covariance(11, 0)) < 0.5 * np.trace(uncertain)


def test_the_covariance_is_that_of_a_dense_inverse() -> None:
    graph, _ = ring(2, 4)
    jacobian = (
        ConstraintArrays.of(graph.constraints).jacobian(graph.poses, np.ones(3)).toarray()[:, 3:]
    )
    dense = np.linalg.inv(jacobian.T @ jacobian)
    assert graph.covariance(2, 0) == pytest.approx(dense[3:6, 3:6], rel=0.05, abs=1e-7)


def test_a_wrong_constraint_does_not_bend_the_graph() -> None:
    graph, true = ring(3)
    for node in (6, 8, 10):
        here = Pose2.from_array(true[0]).inverse() @ Pose2.from_array(true[node])
        graph.add_constraints([Constraint(0, node, here, EXACT)])
    graph.adjust()
    right = graph.poses.copy()
    graph.add_constraints([Constraint(0, 7, Pose2(3.0, -2.0, 1.0), EXACT)])
    graph.adjust()
    assert np.hypot(*(graph.poses - right)[:, :2].T).max() < 0.01


def test_loops_that_contradict_each_other_or_stand_alone_are_not_closed() -> None:
    graph, _ = ring(4, 40)
    frames = KeyFrames(Pose2(), NOTHING)
    frames.graph = graph
    closer, poses = LoopCloser(frames), graph.poses.copy()
    for node, off in ((30, 1.0), (32, -1.0), (34, 2.5)):
        moved = graph.pose(2).inverse() @ graph.pose(node) @ Pose2(off, 0.3 * off, 0.1)
        closer._confirm(Closure(node, [Constraint(2, node, moved, EXACT)]))
    assert closer.count == 0
    np.testing.assert_array_equal(graph.poses, poses)
