"""Occupancy grids drawn by particles: cells, likelihood, climbing, and whole drives."""

import math
from itertools import chain
from pathlib import Path

import numpy as np
import pytest
import rooms
from hypothesis import given
from hypothesis import strategies as st

from app.command_line import main
from app.features.lab.localize.reading.carmen import CarmenLog
from app.features.lab.localize.reading.sources import BagError
from app.features.lab.trajectories.reading import parse_tum
from robot.fields.grid_map import load_map_yaml
from robot.geometry import Pose2
from robot.mapping.grid.beams import Beams
from robot.mapping.grid.cells import measurement_model_map, updated_occupancy_grid
from robot.mapping.grid.climbing import climbed
from robot.mapping.grid.fast_slam import WALLS, FastSlam

CELL, SD = 0.1, 0.05
START = rooms.lap(0, 2)[0][0]


def beams_at(pose: Pose2) -> Beams:
    return Beams.of_scan(rooms.Scan(0.0, rooms.BEARINGS, rooms.ranges(pose)), 20.0)


def drawn_once(pose: Pose2) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """One particle's map of the room after some looks from the same place."""
    odds, ends = np.zeros((70, 90), np.float32), np.zeros((70, 90, 6), np.float32)
    corner, beams = np.array([-1.0, -1.0]), beams_at(pose)
    parts = beams.begin, beams.end, beams.beyond, beams.hit
    for _ in range(3):
        updated_occupancy_grid(odds, ends, corner, CELL, pose.to_array(), *parts)
    return odds, ends, corner


def test_beams_are_free_up_to_the_wall_that_they_meet() -> None:
    odds, ends, corner = drawn_once(START)
    points = corner + CELL * (np.argwhere(odds > 0)[:, ::-1] + 0.5)
    assert rooms.from_walls(points).max() < CELL
    free = corner + CELL * (np.argwhere(odds < 0)[:, ::-1] + 0.5)
    inside = (free > 0).all(axis=1) & (free < (6, 4)).all(axis=1)
    assert inside.mean() > 0.95
    assert ends[..., 0].sum() == 3 * len(rooms.BEARINGS)
    assert (odds[ends[..., 0] > 0] > 0).mean() > 0.9


def test_the_likelihood_is_highest_at_the_true_pose() -> None:
    grid = drawn_once(START)
    met = beams_at(START).end

    def fit(*change: float) -> float:
        pose = START.to_array() + change
        return measurement_model_map(*grid, CELL, pose, met, SD)

    at_place = fit(0, 0, 0)
    for far in (0.03, 0.06, 0.1):
        for change in ((far, 0, 0), (0, far, 0), (0, 0, far / 2)):
            assert fit(*change) < at_place
            assert fit(*(-part for part in change)) < at_place
    assert fit(0.1, 0, 0) < fit(0.05, 0, 0)


@pytest.mark.slow
@given(st.tuples(*3 * [st.floats(-0.06, 0.06)]))
def test_climbing_finds_back_to_the_true_pose(change: tuple[float, float, float]) -> None:
    moved = START.to_array() + change
    pose, fit = climbed(*drawn_once(START), CELL, moved, beams_at(START).end, SD, np.full(3, 5.0))
    assert pose[:2] == pytest.approx(START.to_array()[:2], abs=0.015)
    assert pose[2] == pytest.approx(START.theta, abs=0.01)
    assert (
        fit > measurement_model_map(*drawn_once(START), CELL, moved, beams_at(START).end, SD) - 1e-9
    )


def drawn(seed: int) -> tuple[FastSlam, list[Pose2], Pose2]:
    true, steps, scans = rooms.lap(seed)
    slam, odometry = FastSlam(WALLS, true[0], np.random.default_rng(seed)), true[0]
    for step, scan in zip(steps, scans, strict=True):
        slam.update(step, Beams.of_scan(scan, 20.0))
        odometry = odometry @ step
    return slam, true, odometry


def test_a_lap_in_a_room_becomes_its_map() -> None:
    slam, true, odometry = drawn(1)
    off = [math.dist(pose[:2], (at.x, at.y)) for pose, at in zip(slam.path, true, strict=True)]
    assert odometry.distance_to(true[-1]) > 0.3  # the drift that has to be found
    assert max(off) < 0.08
    assert np.quantile(rooms.from_walls(slam.ends), 0.9) < 0.06
    walls = np.argwhere(slam.grid.occupied)[:, ::-1] + 0.5
    places = slam.grid.origin.apply(walls * slam.grid.resolution)
    assert (rooms.from_walls(places) < 0.1).mean() > 0.9
    outside = np.array([[-2.0, -2.0], [8.0, 6.0]])
    assert (slam.grid.values_at(outside) == -1).all()


def test_the_same_seed_draws_the_same_map() -> None:
    (one, _, _), (other, _, _) = drawn(2), drawn(2)
    np.testing.assert_array_equal(one.path, other.path)
    np.testing.assert_array_equal(one.grid.data, other.grid.data)


def test_the_command_draws_a_lasers_log(tmp_path: Path, capsys) -> None:
    true, steps, scans = rooms.lap(3)
    log, out = tmp_path / "room.log", tmp_path / "room.yaml"
    rooms.write_log(log, steps, scans, Pose2(5.0, 5.0, 1.0))
    start = [str(value) for value in true[0].to_array()]
    assert main(["map", str(log), "--out", str(out), "--start", *start]) == 0
    assert f"the map is {out}" in capsys.readouterr().out
    grid = load_map_yaml(out)
    places = grid.origin.apply((np.argwhere(grid.occupied)[:, ::-1] + 0.5) * grid.resolution)
    assert (rooms.from_walls(places) < 0.1).mean() > 0.9
    path = parse_tum(out.with_suffix(".tum").read_text(), "path")
    at = [true[round(stamp / 0.5)] for stamp in path.stamps]
    assert max(math.dist(p[:2], (t.x, t.y)) for p, t in zip(path.positions, at, strict=True)) < 0.1


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--method", "strokes"], "needs pictures of tape"),
        (["--out", "room.svg"], "ends in .yaml"),
    ],
)
def test_what_a_laser_cannot_do_is_refused(
    tmp_path: Path, capsys, arguments: list[str], words: str
) -> None:
    _, steps, scans = rooms.lap(3, 3)
    rooms.write_log(tmp_path / "room.log", steps, scans, Pose2())
    assert main(["map", str(tmp_path / "room.log"), *arguments]) == 2
    assert words in capsys.readouterr().err


def test_a_log_keeps_scans_and_odometry(tmp_path: Path) -> None:
    _, steps, scans = rooms.lap(4, 5)
    rooms.write_log(tmp_path / "room.clf", steps, scans, Pose2(1.0, 2.0, 0.5))
    read = list(chain(*CarmenLog(tmp_path / "room.clf").drives()))
    assert len(read) == 5
    for measured, scan in zip(read, scans, strict=True):
        assert measured.scan.stamp == pytest.approx(scan.stamp)
        np.testing.assert_allclose(measured.scan.ranges, scan.ranges, atol=6e-4)
        np.testing.assert_allclose(measured.scan.bearings, scan.bearings, atol=1e-9)
    moved = read[0].odom_from_robot.inverse() @ read[1].odom_from_robot
    assert moved.distance_to(steps[1]) < 1e-5


def test_a_newer_log_tells_its_lasers_view(tmp_path: Path) -> None:
    path = tmp_path / "new.log"
    path.write_text(
        "ROBOTLASER1 0 -1.0 2.0 1.0 30.0 0.01 0 3 1.5 31.0 2.5 0 "
        "1.1 2.0 0.0 1.0 2.0 0.0 0 0 0 0 0 7.5 host 0.1\n"
    )
    (measured,) = chain(*CarmenLog(path).drives())
    assert measured.odom_from_robot == Pose2(1.0, 2.0, 0.0)
    assert measured.scan.robot_from_scan.x == pytest.approx(0.1)
    assert measured.scan.ranges.tolist() == [1.5, math.inf, 2.5]
    assert measured.scan.bearings.tolist() == [-1.0, 0.0, 1.0]
    assert measured.scan.stamp == 7.5


def test_the_greatest_range_of_a_laser_is_no_wall(tmp_path: Path) -> None:
    path = tmp_path / "short.log"
    read = " ".join(["2.500"] * 3 + ["5.600"] * 8 + ["5.590"])
    path.write_text(f"FLASER 12 {read} 0 0 0 0 0 0 1.0 host 1.0\n")
    (measured,) = chain(*CarmenLog(path).drives())
    assert measured.scan.ranges.tolist() == [2.5] * 3 + [math.inf] * 8 + [5.59]


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", "has no scan"),
        ("ODOM 0 0 0 0 0 0 0 host 0\n", "has no scan"),
        ("# a log\nFLASER 3 1.0 2.0\n", "line 2: a broken FLASER"),
        ("FLASER x 1.0\n", "line 1: a broken FLASER"),
        ("FLASER 1 nan 0 0 0 0 0 0 1.0 host 1.0\n", "line 1: a broken FLASER"),
    ],
)
def test_a_broken_log_is_told(tmp_path: Path, text: str, words: str) -> None:
    path = tmp_path / "broken.log"
    path.write_text(text)
    with pytest.raises(BagError, match=words):
        list(chain(*CarmenLog(path).drives()))


@given(st.text(max_size=200))
def test_any_text_is_read_or_refused(tmp_path_factory, text: str) -> None:
    path = tmp_path_factory.mktemp("logs") / "any.log"
    path.write_text("FLASER " + text, encoding="utf-8", errors="replace")
    with pytest.raises(BagError):
        list(chain(*CarmenLog(path).drives()))
