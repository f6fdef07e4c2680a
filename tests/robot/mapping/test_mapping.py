"""Maps drawn by driving: strokes, their edges, tracing, ends, drawing, and whole drives."""

import json
import math
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import shapely
from calibrations import SPEC, driven
from hypothesis import given
from hypothesis import strategies as st
from mappings import WIDTH, Tour, eight, errors_of, mapped

from app.command_line import main
from app.engine.build import load_field
from app.settings.config import MAPS
from robot.calibration.drive_log import DriveLog
from robot.estimation.fit_quality import ContradictionError, FitQuality
from robot.fields.svg_field import field_of_drawing
from robot.geometry import Array, Pose2
from robot.mapping.bare_floor import BIN, gaps
from robot.mapping.crossings import MOST_BARE, BareFloor, Crossings
from robot.mapping.cutting import pieces_of
from robot.mapping.drawing import drawing
from robot.mapping.ends import RaysOnFloor
from robot.mapping.mapper import Mapper
from robot.mapping.stroke_fitting import fit_stroke
from robot.mapping.strokes import Stroke, Strokes
from robot.mapping.tape_map import LEAST_STEADINESS, MappingError, steadiness
from robot.mapping.tidying import TidyStrokes


def arc(radius: float, angle: float, count: int = 40) -> Array:
    turns = np.linspace(0, angle, count)
    return radius * np.column_stack([np.cos(turns), np.sin(turns)])


def wave(count: int) -> Array:
    x = np.linspace(0, 0.5, count)
    return np.column_stack([x, 0.03 * np.sin(9 * x)])


RING = Stroke(arc(0.3, 2 * math.pi, 13)[:-1], curved=True, closed=True)
CURVE = Stroke(wave(7), curved=True)
LINE = Stroke(np.array([[0.1, -0.4], [0.7, -0.2]]))
AT_ORIGIN = np.zeros((1, 3))
"""Where a robot was that stood at the origin."""


@pytest.mark.slow
@given(st.lists(st.floats(-0.004, 0.004), min_size=21, max_size=21))
def test_derivatives_by_nodes_are_those_of_the_distances(offsets: list[float]) -> None:
    strokes = Strokes.of([LINE, CURVE, RING], WIDTH)
    # Strokes that were moved lie as if their nodes had been traced there.
    edges = strokes.moved_by(np.array(offsets)).edges
    middle = (edges.edges[:, :2] + edges.edges[:, 2:]) / 2
    which = np.arange(len(middle))
    nodes, slopes = edges.derivatives(which, middle)
    exact = np.zeros((len(middle), len(offsets)))
    np.add.at(exact, (which[:, None], nodes), slopes)
    step = 1e-6
    for node in range(len(offsets)):
        changed = np.array(offsets)
        changed[node] += step
        moved = strokes.moved_by(changed).edges
        away = (moved.normals * (middle - moved.edges[:, :2])).sum(axis=1)
        np.testing.assert_allclose(away / step, exact[:, node], atol=0.02)


def test_edges_have_their_tape_on_the_left_and_lie_half_a_width_beside() -> None:
    for stroke in (LINE, CURVE, RING):
        edges = Strokes.of([stroke], WIDTH).edges
        middle = (edges.edges[:, :2] + edges.edges[:, 2:]) / 2
        inward = middle - WIDTH / 2 * edges.normals
        assert distances(inward, stroke).max() < 5e-4


def distances(points: Array, stroke: Stroke) -> Array:
    """How far points (n, 2) are from the centre line of a stroke [m]."""
    return shapely.distance(shapely.points(points), shapely.LineString(stroke.points))


@pytest.mark.parametrize("radius", [0.1, 0.2, 0.5, 2.0])
def test_a_spline_follows_tape_that_bends(radius: float) -> None:
    length = min(1.5 * math.pi * radius, 1.0)
    stroke = fit_stroke(arc(radius, length / radius, 1 + round(length / 0.012)))
    assert stroke is not None
    assert stroke.curved
    assert np.abs(np.hypot(*stroke.points.T) - radius).max() < 0.0005


def test_a_line_with_noise_is_straight_and_its_hooks_are_cut() -> None:
    rng = np.random.default_rng(5)
    x = np.arange(0, 0.8, 0.012)
    line = np.column_stack([x, rng.normal(0, 0.0005, len(x))])
    line[:2, 1] += (0.012, 0.006)  # tape looks round in corners
    stroke = fit_stroke(line)
    assert stroke is not None
    assert not stroke.curved
    assert np.abs(stroke.nodes[:, 1]).max() < 0.0006
    assert fit_stroke(line[:3]) is None


def test_strokes_that_meet_in_corners_are_drawn_as_the_square_is() -> None:
    corners = np.array([[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5]])
    strokes = [Stroke(corners[[k, (k + 1) % 4]]) for k in range(4)]
    # One of them was traced the other way round.
    strokes[2] = strokes[2].reversed
    ends = ((0, True), (1, False)), ((1, True), (2, True)), ((2, False), (3, False))
    tidy = TidyStrokes(tuple(strokes), (*ends, ((3, True), (0, False))), {})
    text = drawing(tidy, WIDTH, AT_ORIGIN, "A <square>")
    assert text.count("<path") == 1
    (tape,) = load_field("square", MAPS).tape
    field = field_of_drawing(text, "own")
    assert field.tape == (tape,)
    own, truth = (np.sort(f.edges.round(6), axis=0) for f in (field, load_field("square", MAPS)))
    np.testing.assert_allclose(own, truth, atol=1e-5)


@given(
    st.lists(st.tuples(*[st.floats(-8.0, 8.0)] * 2, st.floats(-3.1, 3.1)), min_size=1, max_size=4)
)
def test_a_drawing_has_all_of_the_floor_that_the_robot_was_on(poses: list[tuple]) -> None:
    # It may begin and end far from any tape that it saw.
    path = np.array(poses)
    field = field_of_drawing(drawing(TidyStrokes((CURVE,), (), {}), WIDTH, path, "own"), "own")
    np.testing.assert_allclose(field.start.to_array(), path[0], atol=1e-5)
    for pose in path:
        field.require_inside(Pose2.from_array(pose))


def test_a_curve_is_drawn_exactly() -> None:
    field = field_of_drawing(drawing(TidyStrokes((CURVE,), (), {}), WIDTH, AT_ORIGIN, "own"), "own")
    away = distances(field.edges.reshape(-1, 2), CURVE)
    assert np.abs(away - WIDTH / 2).max() < 3e-4


@pytest.mark.parametrize(
    ("further", "length"), [(0.1, 0.1), (0.005, 0.005), (-0.05, -0.05), (-0.2, -0.2)]
)
@pytest.mark.parametrize("stroke", [LINE, CURVE])
def test_an_end_moves_along_the_stroke(stroke: Stroke, further: float, length: float) -> None:
    for last in (False, True):
        moved = stroke.with_end(last, further)
        assert moved.length == pytest.approx(stroke.length + length, abs=0.004)
        kept = stroke.end(not last)[0]
        np.testing.assert_allclose(moved.end(not last)[0], kept)


@pytest.mark.slow
@pytest.mark.parametrize(("name", "seed"), [("square", 60100), ("stubs", 60101), ("tee", 60102)])
def test_one_lap_draws_what_was_seen(name: str, seed: int) -> None:
    drawn, poses = mapped(name, seed)
    errors = errors_of(drawn, poses, load_field(name, MAPS))
    assert drawn.fits
    assert errors.path < 0.0005
    # Where sight ended, the map has a short edge that the floor has not: 125 mm off, at worst.
    assert errors.mean < (0.0015 if name == "tee" else 0.0005)
    # Behind the tee, half of a side is never in sight; that is told.
    assert errors.covered > (0.85 if name == "tee" else 0.99)
    if name == "tee":
        assert any("not seen" in words for words in drawn.remarks)
    else:
        assert errors.largest < 0.005
        assert drawn.remarks == ()
    # The tape is claimed to be known about as well as it is.
    assert drawn.node_sd.max() < 0.003


@pytest.mark.slow
def test_a_robot_that_nobody_calibrated_draws_by_the_width_of_the_tape() -> None:
    drawn, poses = mapped("stub", 60103, "hand-built", calibrate=True)
    errors = errors_of(drawn, poses, load_field("stub", MAPS))
    assert errors.mean < 0.003
    assert errors.covered > 0.95
    assert errors.path < 0.003


def polygon(folder: Path, corners: Array) -> str:
    """The file of an outline of tape through corners (n, 2) [mm]."""
    points = " ".join(f"{x:.1f},{y:.1f}" for x, y in corners)
    path = folder / "outline.svg"
    path.write_text(
        '<svg xmlns="http://www.w3.org/2000/svg" width="2200mm" height="2000mm" '
        'viewBox="-1100 -1000 2200 2000" data-start="-100 0 0"><title>Outline</title>'
        f'<polygon points="{points}" fill="none" stroke="#202225" stroke-width="50"/></svg>'
    )
    return str(path)


HEXAGON = arc(600, 2 * math.pi, 7)[:-1]
CHAMFERED = np.array([(-600, -450), (600, -450), (600, 150), (300, 450), (-600, 450)])
PENTAGON = 620 * np.column_stack([f(0.3 + np.arange(5) * math.tau / 5) for f in (np.cos, np.sin)])


@pytest.mark.slow
@pytest.mark.parametrize(
    ("corners", "seed", "seconds"),
    [(HEXAGON, 9003, 17.0), (CHAMFERED, 9002, 17.0), (PENTAGON, 9012, 33.0)],
    ids=["hexagon", "chamfered", "pentagon"],
)
def test_obtuse_corners_leave_the_scale_of_a_robot_that_nobody_calibrated(
    corners: Array, seed: int, seconds: float, tmp_path: Path
) -> None:
    """They were traced round, and the map came up to 20 % too small."""
    outline = polygon(tmp_path, corners)
    drawn, poses = mapped(outline, seed, "hand-built", seconds, calibrate=True)
    ways = [
        np.linalg.norm(np.diff(path[:, :2], axis=0), axis=1).sum()
        for path in (drawn.solution.state.poses, poses)
    ]
    assert ways[0] / ways[1] == pytest.approx(1.0, abs=0.002)
    assert errors_of(drawn, poses, load_field(outline, MAPS)).mean < 0.001
    assert len(drawn.tidy.corners) == len(corners)
    assert drawn.fits
    assert drawn.quality.overrun == {}
    assert drawn.node_sd.max() < 0.002


@pytest.mark.slow
def test_a_corner_that_was_taken_for_a_bend_is_found_by_what_it_contradicts(tmp_path: Path) -> None:
    """The map was 2.5 mm off, its ruler overrun by 15 deviations, and no profile was written."""
    outline = polygon(tmp_path, HEXAGON * 550 / 600)
    tour = Tour(load_field(outline, MAPS), 2)
    drawn, poses = mapped(outline, 9103, "hand-built", 300.0, calibrate=True, steer=tour)
    assert drawn.quality.contradictions == ()
    assert len(drawn.tidy.corners) == 6
    assert errors_of(drawn, poses, load_field(outline, MAPS)).mean < 0.001


@pytest.mark.slow
def test_what_did_not_converge_or_has_an_impossible_ruler_says_so() -> None:
    drawn, _ = mapped("square", 60100)
    assert drawn.quality.converged
    unfinished = replace(drawn, quality=replace(drawn.quality, converged=False))
    assert not unfinished.fits
    assert "did not come to an end" in unfinished.remarks[0]
    stretched = replace(drawn, quality=replace(drawn.quality, overrun={"tape_width": -65.0}))
    assert not stretched.fits
    assert "its scale too, may be wrong" in stretched.remarks[0]
    assert "tape_width -65 times" in stretched.remarks[0]
    # The file tells it as data, too.
    data = re.search("data-fit='(.*?)'", stretched.drawing("stretched"))
    assert data is not None
    assert FitQuality.of_table(json.loads(data[1])).contradictions == stretched.remarks[:1]


@pytest.mark.slow
@pytest.mark.parametrize("seed", [710, 711])
def test_a_robot_that_nobody_calibrated_claims_no_more_than_its_map_is(seed: int) -> None:
    """It claimed 0.9 mm where it was 1.6 mm off, and that somebody had pushed it."""
    drawn, poses = mapped("stub", seed, "as-real")
    assert not drawn.quality.is_noise
    errors = errors_of(drawn, poses, load_field("stub", MAPS))
    assert 1.96 * np.median(drawn.node_sd) > errors.mean
    words = " ".join(drawn.remarks)
    assert "the robot, its lens or the floor is not" in words
    assert "it slipped" not in words
    known, _ = mapped("square", 60100)
    assert known.quality.is_noise


def test_tape_that_looks_the_same_when_moved_is_not_steady() -> None:
    angles = np.linspace(0, 2 * math.pi, 40, endpoint=False)
    circle = Stroke(np.column_stack([np.cos(angles), np.sin(angles)]), curved=True, closed=True)
    side, opposite = Stroke(np.array([[0, 0], [1.0, 0]])), Stroke(np.array([[0, 1.0], [1, 1]]))
    across = Stroke(np.array([[0, 0], [0, 1.0]]))
    for strokes in ([circle], [side], [side, opposite]):
        assert steadiness(strokes) < LEAST_STEADINESS / 5
    for strokes in ([side, across], [side, opposite, across], [circle, side]):
        assert steadiness(strokes) > 2 * LEAST_STEADINESS


@pytest.mark.slow
def test_a_robot_that_is_pushed_says_so() -> None:
    log, _, _ = driven("default", 60100, 16.5, eight, "square", calibrated=True)
    # For half a second it moves while its wheels stand.
    begin, end = np.searchsorted(log.wheel_stamps, [8.0, 8.5])
    angles = log.wheel_angles.copy()
    angles[begin:] -= angles[begin : end + 1][
        np.minimum(np.arange(len(angles) - begin), end - begin)
    ]
    angles[begin:] += log.wheel_angles[begin]
    drawn = Mapper(_changed(log, wheel_angles=angles), SPEC, WIDTH).run()
    assert not drawn.fits
    assert any("at 8 s" in words and "pushed" in words for words in drawn.remarks)


@pytest.mark.slow
def test_glare_that_blinds_the_camera_for_seconds_bends_no_map() -> None:
    log, _, poses = driven("default", 60100, 16.5, eight, "square", calibrated=True)
    blinded = log.pixels.copy()
    blinded[(log.stamps > 6.0) & (log.stamps < 8.0)] = np.nan
    drawn = Mapper(_changed(log, pixels=blinded), SPEC, WIDTH).run()
    truth = poses[np.searchsorted(log.stamps, drawn.stamps)]
    assert drawn.fits
    assert errors_of(drawn, truth, load_field("square", MAPS)).mean < 0.001


def _changed(log: DriveLog, **fields: Array) -> DriveLog:
    return DriveLog(**{**vars(log), **fields})


def test_a_drive_that_shows_nothing_is_refused() -> None:
    log, _, _ = driven("default", 60100, 16.5, eight, "square", calibrated=True)
    with pytest.raises(MappingError, match="no picture"):
        Mapper(_changed(log, pixels=np.full_like(log.pixels, np.nan)), SPEC, WIDTH)
    with pytest.raises(MappingError, match="stood still"):
        Mapper(_changed(log, wheel_angles=0 * log.wheel_angles), SPEC, WIDTH)
    some = np.full_like(log.pixels, np.nan)
    some[40] = log.pixels[40]
    with pytest.raises(MappingError, match="too little tape"):
        Mapper(_changed(log, pixels=some), SPEC, WIDTH).run()


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (["--out", "field.png"], "ends in .svg"),
        (["--width", "0"], "--width is 0"),
        (["--start", "nan", "0", "0"], "--start"),
        ([], "nothing.mcap"),
    ],
)
def test_what_cannot_be_used_is_named(
    options: list[str], words: str, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    assert main(["map", str(tmp_path / "nothing.mcap"), *options]) in (1, 2)
    assert words in capsys.readouterr().err


def test_tape_where_rays_saw_bare_floor_contradicts_the_map() -> None:
    log, _, _ = driven("default", 60100, 16.5, eight, "square", calibrated=True)
    drawn, _ = mapped("square", 60100)
    used = log.some(np.searchsorted(log.stamps, drawn.stamps))
    rays = RaysOnFloor.of(used, SPEC, drawn.solution.state)
    assert drawn.bare.share == BareFloor.of(drawn.tidy.strokes, WIDTH, rays).share
    assert drawn.bare.share < 0.002
    # A side once more, where there is none, as if the robot had lost its path for a while.
    nowhere = Stroke(np.array([[-0.3, 0.15], [0.3, 0.15]]))
    bare = BareFloor.of([*drawn.tidy.strokes, nowhere], WIDTH, rays)
    assert bare.contradicts
    assert bare.places == pytest.approx(np.array([[0.0, 0.15]]))
    wrong = replace(drawn, bare=bare)
    assert not wrong.fits
    assert "saw bare floor there at" in " ".join(wrong.remarks)
    # A single one, which few rays crossed, is told with its place.
    few = replace(bare, share=0.9 * MOST_BARE)
    assert not few.is_lost
    one = replace(drawn, bare=few)
    assert not one.fits
    assert "its tape at (0.00, 0.15) m may not be there" in " ".join(one.remarks)


@given(st.lists(st.floats(0.045, 0.12), min_size=3, max_size=9))
def test_gaps_are_where_rays_saw_bare_floor(lengths: list[float]) -> None:
    borders = np.concatenate([[0.0], np.cumsum(lengths)])
    places = np.arange(0.0, borders[-1], 0.001)
    is_bare = np.searchsorted(borders, places, side="right") % 2 == 0
    found = list(gaps(places[~is_bare], places[is_bare], 0.0, float(borders[-1])))
    expected = list(zip(borders[1:-1:2], borders[2::2], strict=False))
    assert len(found) == len(expected)
    for gap, border in zip(found, expected, strict=True):
        assert gap == pytest.approx(border, abs=2.1 * BIN)


def test_dashes_are_cut_apart_and_a_ring_opens() -> None:
    for whole in (Stroke(np.array([[0.0, 0.0], [0.8, 0.0]])), CURVE, RING):
        total = whole.knots[-1]
        places = np.arange(0.0, total, 0.001)
        is_bare = np.abs(places - total / 2) < 0.04
        pieces = list(pieces_of(whole, Crossings(places[~is_bare], places[is_bare])))
        assert len(pieces) == (1 if whole.closed else 2)
        assert not any(piece.closed for piece in pieces)
        assert sum(piece.length for piece in pieces) == pytest.approx(whole.length - 0.08, abs=0.02)
        for piece in pieces:
            assert distances(piece.points, whole).max() < 0.001
    assert list(pieces_of(LINE, Crossings(places, np.zeros(0)))) == [LINE]


@pytest.mark.slow
def test_a_map_that_came_apart_says_so() -> None:
    """Two laps over a generated field, whose adjustment has not found to its end by now."""
    taped = load_field("generated-40305", MAPS)
    drawn, poses = mapped("generated-40305", 84305, seconds=60.0, steer=Tour(taped, 2))
    if errors_of(drawn, poses, taped).mean > 0.002:
        assert not drawn.fits
        assert any("did not come to an end" in words for words in drawn.remarks)
        assert any("rays across it saw bare floor" in words for words in drawn.remarks)
        with pytest.raises(ContradictionError, match="it is not kept"):
            drawn.quality.require_consistent()
