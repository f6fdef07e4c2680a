"""Whole drives whose walls are drawn by a pose graph, and the command."""

import functools
import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import rooms
from laser_office import CELL as CELL_M
from laser_office import drive, office, true_pose, write_bag

from app.command_line import main
from app.features.lab.trajectories.reading import parse_tum
from robot.fields.grid_map import load_map_yaml
from robot.geometry import Pose2
from robot.mapping.graph.detours import straighten
from robot.mapping.graph.graph_slam import GraphSettings, GraphSlam
from robot.mapping.grid.beams import Beams
from robot.scan import Scan

NOISE_M = 0.01


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


@pytest.mark.slow
def test_a_lap_in_a_room_becomes_its_walls() -> None:
    slam, true = lap(1)
    assert max(errors(slam, true)) < 0.03
    assert np.quantile(rooms.from_walls(slam.ends), 0.9) < 0.03
    places = np.argwhere(slam.grid.occupied)[:, ::-1] + 0.5
    assert (rooms.from_walls(slam.grid.origin.apply(places * slam.grid.resolution)) < 0.1).all()
    assert slam.loops > 0
    graph_sd = [np.sqrt(np.diag(slam.graph.covariance(k, 0))[:2]).max() for k in range(1, 60)]
    assert max(graph_sd) < 0.05
    assert slam.position_sd().max() < 0.08


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


def test_a_scan_from_elsewhere_is_no_place_that_is_claimed() -> None:
    true, steps, scans = rooms.lap(2)
    elsewhere = true[30] @ Pose2(0.45, 0.3, 0.0)
    scans[30] = Scan(scans[30].stamp, rooms.BEARINGS, rooms.ranges(elsewhere))
    slam = drawn(steps, scans, true[0])
    off, claimed = np.array(errors(slam, true)), 2.45 * slam.position_sd()
    assert off[30] > 0.4
    assert (off <= claimed).all()
    assert np.delete(off, 30).max() < 0.03
    assert list(slam.doubtful) == [30]
    assert not lap(1)[0].doubtful


def test_a_scan_that_was_matched_beside_the_way_is_matched_again() -> None:
    true, steps, scans = rooms.lap(5)
    slam = drawn(steps, scans, true[0])
    graph, wrong = slam.graph, Pose2(0.4, 0.3, 0.0)
    kept = [
        each for each in graph.constraints if each.by_odometry or 20 not in (each.begin, each.end)
    ]
    moved = [
        replace(each, moved=each.moved @ wrong)
        for each in graph.constraints
        if each.end == 20 and not each.by_odometry
    ]
    graph.keep_constraints(kept + moved)
    graph.poses[20] = (graph.pose(20) @ wrong).to_array()
    graph.adjust()
    assert errors(slam, true)[20] > 0.3
    assert straighten(slam._known) == {}
    assert max(errors(slam, true)) < 0.03


def through_a_door(between: Pose2) -> list[int]:
    """Where a path is torn that leads on from a room into a hall, by odometry."""
    slam, torn = GraphSlam(GraphSettings(), Pose2()), []
    _, steps, scans = rooms.lap(6, 30)
    _, others, later = rooms.lap(7, 30, rooms.HALL)
    for step, scan in zip([*steps, between, *others[1:]], [*scans, *later], strict=True):
        slam.update(step, Beams.of_scan(scan, 20.0))
        torn += [] if slam.torn() is None else [slam.torn()]
    return torn


@pytest.mark.parametrize("between", [Pose2(), Pose2(0.3, 0.0, 0.1), Pose2(4.0, 1.0, 2.0)])
def test_a_path_is_torn_where_only_odometry_leads_on(between: Pose2) -> None:
    assert through_a_door(between) == [30]


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


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["ros1", "mcap"])
def test_a_bag_becomes_a_map(tmp_path: Path, capsys: pytest.CaptureFixture[str], kind: str) -> None:
    bag, out = tmp_path / ("office.bag" if kind == "ros1" else "office"), tmp_path / "office.yaml"
    write_bag(bag, kind)
    start = [str(value) for value in true_pose(drive()[0]).to_array()]
    assert main(["map", str(bag), "--out", str(out), "--start", *start]) == 0
    assert "laser as told by" in capsys.readouterr().out
    true, drawn_map = office(), load_map_yaml(out)
    walls = true.origin.apply((np.argwhere(true.occupied)[:, ::-1] + 0.5) * CELL_M)
    places = np.argwhere(drawn_map.occupied)[:, ::-1] + 0.5
    cells = drawn_map.origin.apply(places * drawn_map.resolution)
    far = np.hypot(*(cells[:, None] - walls).transpose(2, 0, 1)).min(axis=1)
    # Some beams meet people, whom the office's map does not have.
    assert (far < 0.1).mean() > 0.85


def test_a_scan_with_an_earlier_stamp_is_taken_by_its_line_and_told(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    _, steps, scans = rooms.lap(6, 8)
    scans[4] = replace(scans[4], stamp=scans[2].stamp - 0.1)
    rooms.write_log(tmp_path / "room.log", steps, scans, Pose2())
    out = tmp_path / "room.yaml"
    assert main(["map", str(tmp_path / "room.log"), "--out", str(out)]) == 0
    assert "stamps do not rise: 1 of 8" in capsys.readouterr().out
    stamps = parse_tum(out.with_suffix(".tum").read_text(), "path").stamps
    np.testing.assert_allclose(stamps, 0.5 * np.arange(8))


def test_each_drive_in_a_log_becomes_a_map_of_its_own(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    log, out = tmp_path / "both.log", tmp_path / "both.yaml"
    parts = []
    for seed, looks in ((6, 8), (7, 9)):
        _, steps, scans = rooms.lap(seed, looks)
        rooms.write_log(log, steps, scans, Pose2())
        # No head tells where the second one begins: its clock does.
        parts.append("\n".join(log.read_text().splitlines()[2:]) + "\n")
    log.write_text("".join(parts))
    (tmp_path / "both-2.yaml").write_text("taken")
    assert main(["map", str(log), "--out", str(out)]) == 0
    assert "line 18: another drive begins, as its clock" in capsys.readouterr().out
    lengths = [
        len(parse_tum((tmp_path / name).read_text(), "path").stamps)
        for name in ("both.tum", "both-3.tum")
    ]
    assert lengths == [8, 9]
    assert (tmp_path / "both-2.yaml").read_text() == "taken"


def in_two_buildings(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], pause: float, jump: Pose2
) -> tuple[str, list[Path]]:
    """What is said of a log of two buildings, and its maps; no head, clock or laser tells."""
    log = tmp_path / "both.log"
    _, steps, scans = rooms.lap(6)
    _, others, later = rooms.lap(7, walls=rooms.HALL)
    later = [replace(scan, stamp=scan.stamp + 30.0 + pause) for scan in later]
    rooms.write_log(log, [*steps, jump, *others[1:]], [*scans, *later], Pose2())
    assert main(["map", str(log), "--out", str(tmp_path / "both.yaml")]) == 0
    return capsys.readouterr().out, sorted(tmp_path.glob("*.tum"))


@pytest.mark.parametrize(
    ("pause", "jump"), [(60.0, Pose2()), (0.0, Pose2(2.0, 1.0, 0.0))], ids=["pause", "jump"]
)
def test_two_buildings_in_a_log_are_two_maps(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], pause: float, jump: Pose2
) -> None:
    said, maps = in_two_buildings(tmp_path, capsys, pause, jump)
    assert "s after the start another map begins: what the laser sees from there on" in said
    assert [path.name for path in maps] == ["both-2.tum", "both.tum"]
    second, first = (parse_tum(path.read_text(), "path").stamps for path in maps)
    assert first[-1] < 30.0 + pause <= second[0]


def test_a_map_that_goes_on_by_wheels_alone_says_so(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    said, maps = in_two_buildings(tmp_path, capsys, 0.0, Pose2())
    assert "s after the start the wheels alone tell how the map goes on" in said
    assert len(maps) == 1


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
