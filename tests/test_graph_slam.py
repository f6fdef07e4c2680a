"""Walls by a pose graph: scan matches, the search in a window, loops, and whole drives."""

import functools
import math
from pathlib import Path

import numpy as np
import pytest
import rooms
from hypothesis import given, settings
from hypothesis import strategies as st
from laser_office import LASER, START, office_map

from app.command_line import main
from robot.fields.ray_casting import cast_rays
from robot.geometry import Array, Pose2
from robot.mapping.graph.branch_and_bound import Window, best_pose
from robot.mapping.graph.graph_slam import GraphSettings, GraphSlam
from robot.mapping.graph.key_frames import KeyFrames
from robot.mapping.graph.likelihood_pyramid import CELL, LikelihoodPyramid
from robot.mapping.graph.loop_closing import Closure, LoopCloser
from robot.mapping.graph.point_to_line import match_scans
from robot.mapping.graph.pose_graph import Edge, PoseGraph, _Parts
from robot.mapping.graph.surfaces import Surfaces
from robot.mapping.grid.beams import Beams
from robot.scan import Scan

NOISE_M = 0.01
EXACT = np.diag([1e4, 1e4, 1e6])


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


def ring(seed: int, nodes: int = 12) -> tuple[PoseGraph, Array]:
    """A drive around a ring, measured well from step to step, and its true poses."""
    rng = np.random.default_rng(seed)
    step = Pose2(0.5, 0.0, 2 * math.pi / nodes)
    graph, true = PoseGraph(Pose2()), [Pose2()]
    for node in range(1, nodes):
        true.append(true[-1] @ step)
        moved = step @ Pose2(*rng.normal(0, 0.01, 3))
        graph.add_pose(graph.pose(node - 1) @ moved)
        graph.add_edge(Edge(node - 1, node, moved, EXACT))
    return graph, np.array([pose.to_array() for pose in true])


@settings(max_examples=20, deadline=None)
@given(st.integers(0, 10**6))
def test_the_jacobian_is_that_of_finite_differences(seed: int) -> None:
    rng = np.random.default_rng(seed)
    graph, _ = ring(seed, 5)
    graph.add_edge(Edge(1, 4, Pose2(*rng.uniform(-2, 2, 3)), np.diag(rng.uniform(1, 9, 3))))
    parts, poses = _Parts.of(graph.edges), graph.poses
    jacobian = parts.jacobian(poses, np.ones(len(graph.edges))).toarray()
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
    graph.add_edge(Edge(0, 11, moved, EXACT))
    graph.adjust()
    assert np.hypot(*(graph.poses - true)[-1, :2]) < 0.5 * before
    assert np.trace(graph.covariance(11, 0)) < 0.5 * np.trace(uncertain)


def test_the_covariance_is_that_of_a_dense_inverse() -> None:
    graph, _ = ring(2, 4)
    jacobian = _Parts.of(graph.edges).jacobian(graph.poses, np.ones(3)).toarray()[:, 3:]
    dense = np.linalg.inv(jacobian.T @ jacobian)
    assert graph.covariance(2, 0) == pytest.approx(dense[3:6, 3:6], rel=0.05, abs=1e-7)


def test_a_wrong_edge_does_not_bend_the_graph() -> None:
    graph, true = ring(3)
    for node in (6, 8, 10):
        here = Pose2.from_array(true[0]).inverse() @ Pose2.from_array(true[node])
        graph.add_edge(Edge(0, node, here, EXACT))
    graph.adjust()
    right = graph.poses.copy()
    graph.add_edge(Edge(0, 7, Pose2(3.0, -2.0, 1.0), EXACT))
    graph.adjust()
    assert np.hypot(*(graph.poses - right)[:, :2].T).max() < 0.01


def test_loops_that_contradict_each_other_or_stand_alone_are_not_closed() -> None:
    graph, _ = ring(4, 40)
    frames = KeyFrames(Pose2(), surfaces_at(START))
    frames.graph = graph
    closer, poses = LoopCloser(frames), graph.poses.copy()
    for node, off in ((30, 1.0), (32, -1.0), (34, 2.5)):
        moved = graph.pose(2).inverse() @ graph.pose(node) @ Pose2(off, 0.3 * off, 0.1)
        closer._confirm(Closure(node, [Edge(2, node, moved, EXACT)]))
    assert closer.count == 0
    np.testing.assert_array_equal(graph.poses, poses)


def drawn(steps: list[Pose2], scans: list[Scan], start: Pose2) -> GraphSlam:
    slam = GraphSlam(GraphSettings(), start)
    for step, scan in zip(steps, scans, strict=True):
        slam.update(step, Beams.of_scan(scan, 20.0))
    slam.finish()
    return slam


@functools.cache
def lap(seed: int) -> tuple[GraphSlam, list[Pose2]]:
    true, steps, scans = rooms.lap(seed)
    return drawn(steps, scans, true[0]), true


def errors(slam: GraphSlam, true: list[Pose2]) -> list[float]:
    return [math.dist(p[:2], (at.x, at.y)) for p, at in zip(slam.path, true, strict=True)]


def test_a_lap_in_a_room_becomes_its_walls() -> None:
    slam, true = lap(1)
    assert max(errors(slam, true)) < 0.03
    assert np.quantile(rooms.from_walls(slam.ends), 0.9) < 0.03
    places = np.argwhere(slam.grid.occupied)[:, ::-1] + 0.5
    assert (rooms.from_walls(slam.grid.origin.apply(places * slam.grid.resolution)) < 0.1).all()
    assert slam.loops > 0
    assert slam.position_sd().max() < 0.05


def test_the_same_drive_gives_the_same_bytes() -> None:
    true, steps, scans = rooms.lap(1)
    again, (slam, _) = drawn(steps, scans, true[0]), lap(1)
    assert again.path.tobytes() == slam.path.tobytes()
    assert again.grid.data.tobytes() == slam.grid.data.tobytes()


def test_odometry_that_jumps_is_not_believed() -> None:
    true, steps, scans = rooms.lap(2)
    steps[20] = Pose2(0.9, -0.6, 0.5) @ steps[20]
    slam = drawn(steps, scans, true[0])
    assert max(errors(slam, true)) < 0.04


def test_scans_that_tell_nothing_are_bridged_by_odometry() -> None:
    true, steps, scans = rooms.lap(3)
    for k in (0, 12, 13, 30):
        nothing = np.full(len(rooms.BEARINGS), np.inf)
        scans[k] = Scan(scans[k].stamp, rooms.BEARINGS, nothing)
    slam = drawn(steps, scans, true[0])
    assert max(errors(slam, true)) < 0.1


def test_without_any_return_the_path_is_that_of_odometry() -> None:
    _, steps, scans = rooms.lap(4, 10)
    scans = [Scan(scan.stamp, rooms.BEARINGS, np.full(180, np.inf)) for scan in scans]
    slam = drawn(steps, scans, Pose2())
    expected = Pose2()
    for step in steps:
        expected = expected @ step
    assert Pose2.from_array(slam.path[-1]).distance_to(expected) < 1e-6
    assert slam.loops == 0
    assert slam.position_sd()[-1] > 0.1


def test_along_a_corridor_only_odometry_tells_the_way_and_the_path_says_so() -> None:
    slam = GraphSlam(GraphSettings(), Pose2())
    x = np.linspace(-8, 8, 100)
    for seed in range(16):
        y = np.random.default_rng(seed).normal(0, NOISE_M, (2, 100))
        ends = np.vstack([np.column_stack([x, y[0] - 1]), np.column_stack([x, y[1] + 1])[::-1]])
        beams = Beams(np.zeros_like(ends), ends, ends, np.ones(200, bool))
        # The wheels are bent to the left, which the walls tell.
        slam.update(Pose2(0.5, 0.0, 0.03) if seed else Pose2(), beams)
    slam.finish()
    x, y, theta = slam.path[-1]
    assert x == pytest.approx(7.5, abs=0.3)
    assert abs(y) < 0.03
    assert abs(theta) < 0.005
    assert slam.position_sd()[-1] == pytest.approx(0.05 * math.sqrt(15), rel=0.3)
    assert slam.loops == 0


@pytest.mark.parametrize(
    ("looks", "words"), [(60, "matches closed loops; the path is known to"), (15, "no loop was")]
)
def test_the_command_says_whether_a_loop_was_closed(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], looks: int, words: str
) -> None:
    _, steps, scans = rooms.lap(6)
    rooms.write_log(tmp_path / "room.log", steps[:looks], scans[:looks], Pose2())
    arguments = ["map", str(tmp_path / "room.log"), "--out", str(tmp_path / "room.yaml")]
    assert main(arguments) == 0
    assert words in capsys.readouterr().out


def test_a_graph_needs_a_laser(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["map", "no-recording", "--method", "graph"]) == 2
    assert "needs the scans of a laser" in capsys.readouterr().err


def through_a_yard(step: Pose2) -> tuple[GraphSlam, Pose2]:
    """A lap in a room, a yard where nothing is in reach, and a lap in a room that looks the same.

    Return also where the second lap ended if the yard led back to the first room.
    """
    true, steps, scans = rooms.lap(7, 40)
    nothing = Scan(0.0, rooms.BEARINGS, np.full(180, np.inf))
    way = [*steps, *[step] * 24, true[-1].inverse() @ true[0], *steps[1:]]
    return drawn(way, [*scans, *[nothing] * 24, *scans], true[0]), true[-1]


def test_a_room_is_recognized_behind_a_yard() -> None:
    # A circle, which the wheels see bent: they come back half a metre beside.
    slam, end = through_a_yard(Pose2(0.51, 0.0, 2 * math.pi / 24 + 0.008))
    assert slam.loops > 0
    assert Pose2.from_array(slam.path[-1]).distance_to(end) < 0.05


def test_a_room_that_looks_the_same_elsewhere_is_another_one() -> None:
    slam, end = through_a_yard(Pose2(0.5, 0.0, 0.0))
    assert Pose2.from_array(slam.path[-1]).distance_to(end) == pytest.approx(12.0, abs=1.0)


def test_few_beams_are_enough() -> None:
    true, steps, scans = rooms.lap(5)
    few = [scan.only(np.arange(0, 180, 6)) for scan in scans]
    assert max(errors(drawn(steps, few, true[0]), true)) < 0.1
