"""Light tape, dashes and several widths: fields that draw them, and the scanner on their floors."""

from __future__ import annotations

import math
from functools import lru_cache
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from tape_trials import STILL, VIEW, camera_of, expected
from taped_road import road

from robot.fields.edges import lengths
from robot.fields.field import Field
from robot.fields.svg_field import field_of_drawing
from robot.geometry import Pose2, heading_vectors
from robot.interface import Frame
from robot.scanning.line_scanner import LineScan, LineScanner, LineScannerSettings
from robot.scanning.tape import Tape, looks, nearest_widths
from robot.settings import SettingError
from sim.floor_camera import CameraSettings, FloorCamera

DARK, LIGHT = "#202225", "#f2f2f0"
QUIET = CameraSettings(noise=0, vignetting=0)


@lru_cache
def floor(marks: str, ground: str) -> Field:
    return field_of_drawing(
        '<svg xmlns="http://www.w3.org/2000/svg" width="1500mm" height="1500mm" '
        'viewBox="-750 -750 1500 1500"><rect x="-750" y="-750" width="1500" height="1500" '
        f'fill="{ground}"/><g fill="none">{marks}</g></svg>',
        "floor",
    )


def ring(tape: str, ground: str, width: float = 50, more: str = "") -> Field:
    return floor(
        f'<rect x="-500" y="-500" width="1000" height="1000" stroke="{tape}" '
        f'stroke-width="{width}" {more}/>',
        ground,
    )


def scan(field: Field, pose: Pose2, **wanted: object) -> LineScan:
    scanner = LineScanner(VIEW, LineScannerSettings(**wanted), field.tape)  # type: ignore[arg-type]
    return scanner.scan(Frame(0.0, quiet_camera(field).picture(pose, STILL)))


CAMERAS: dict[int, FloorCamera] = {}


def quiet_camera(field: Field) -> FloorCamera:
    """The camera over a field, which ``floor`` keeps, so that its key does not come again."""
    if id(field) not in CAMERAS:
        CAMERAS[id(field)] = camera_of(field, QUIET)
    return CAMERAS[id(field)]


POSES = st.builds(
    Pose2,
    st.floats(-0.2, 0.2),
    st.floats(-0.2, 0.2),
    st.floats(-math.pi, math.pi, exclude_max=True),
)


@settings(max_examples=12)
@given(POSES)
def test_light_tape_is_scanned_as_dark_tape_is(pose: Pose2) -> None:
    dark, light = (scan(ring(*inks), pose) for inks in ((DARK, LIGHT), (LIGHT, DARK)))
    both = dark.scan.hit & light.scan.hit
    assert both.sum() >= 0.97 * max(dark.scan.hit.sum(), light.scan.hit.sum())
    difference = np.abs(dark.scan.ranges[both] - light.scan.ranges[both])
    # Half a grey level of rounding moves an edge by no more.
    assert difference.max(initial=0) < 0.002


@settings(max_examples=12)
@given(POSES)
def test_ranges_to_light_tape_are_exact(pose: Pose2) -> None:
    field = ring(LIGHT, DARK)
    seen = scan(field, pose)
    begins, _ = expected(field, pose)
    hit = seen.scan.hit
    assert np.abs(seen.scan.ranges[hit] - begins[hit]).max(initial=0) < 0.004


@settings(max_examples=12)
@given(POSES, st.sampled_from([24.0, 36.0, 80.0]))
def test_the_width_is_the_fields(pose: Pose2, width: float) -> None:
    seen = scan(ring(DARK, LIGHT, width), pose)
    usual = scan(ring(DARK, LIGHT, width), pose, tape_width=0.05)
    assert not usual.scan.hit.any() or abs(width - 50) <= 14
    assert np.nanmedian(np.append(seen.tape_widths, width / 1e3)) == pytest.approx(width / 1e3)
    if seen.scan.hit.sum() > 20:
        assert seen.tape_width == pytest.approx(width / 1e3, abs=0.002)


def test_two_widths_on_one_field_are_told_apart() -> None:
    field = floor(
        f'<path stroke="{DARK}" stroke-width="50" d="M300,-600 V600"/>'
        f'<path stroke="{DARK}" stroke-width="24" d="M-300,-600 V600"/>',
        LIGHT,
    )
    assert [kind.width for kind in field.tape] == [0.05, 0.024]
    assert field.tape_width == 0.05
    for turned, width in ((0.0, 0.05), (math.pi, 0.024)):
        seen = scan(field, Pose2(0.0, 0.0, turned - (math.pi if turned else 0) * 2))
        assert seen.scan.hit.sum() > 60
        assert set(seen.tape_widths[seen.scan.hit]) == {width}
        assert seen.widths[seen.scan.hit] == pytest.approx(width, abs=0.002)
    # The health of the camera is judged by the main width alone.
    assert math.isnan(seen.tape_width)


def test_dark_and_light_tape_on_one_grey_floor() -> None:
    field = floor(
        f'<path stroke="{DARK}" stroke-width="50" d="M300,-600 V600"/>'
        f'<path stroke="{LIGHT}" stroke-width="50" d="M-300,-600 V600"/>',
        "#747474",
    )
    assert {kind.light for kind in field.tape} == {False, True}
    ahead, behind = (scan(field, Pose2(0, 0, turn)) for turn in (0.0, -math.pi))
    assert ahead.scan.hit.sum() > 60 and behind.scan.hit.sum() > 60
    for name, hits in (("dark", (True, False)), ("light", (False, True)), ("either", (True, True))):
        seen = [scan(field, Pose2(0, 0, turn), tape_brightness=name) for turn in (0.0, -math.pi)]
        assert tuple(bool(one.scan.hit.sum() > 60) for one in seen) == hits


def test_a_ray_without_tape_says_only_what_both_searches_would_have_found() -> None:
    """On a nearly black floor light tape is clear, but dark tape there cannot be told from it."""
    field = floor(f'<path stroke="{LIGHT}" stroke-width="50" d="M300,-600 V600"/>', "#101010")
    dark, light, either = (
        scan(field, Pose2(0, 0, -math.pi), tape_brightness=name).scan.clear
        for name in ("dark", "light", "either")
    )
    assert dark is not None and light is not None and either is not None
    assert light.max() > 0.9 and dark.max() < 0.1
    np.testing.assert_array_equal(either, np.minimum(dark, light))


@pytest.mark.parametrize("turn", [-0.6, -0.3, 0.0, 0.3, 0.6])
def test_dashes_are_seen_along_their_line(turn: float) -> None:
    dashed = floor(
        f'<path stroke="{LIGHT}" stroke-width="24" stroke-dasharray="50 25" d="M250,-600 V600"/>',
        DARK,
    )
    assert dashed.tape == (Tape(0.024, light=True, dash=0.05),)
    pose = Pose2(0.0, 0.013, turn)
    seen = scan(dashed, pose)
    points = (pose @ seen.scan.robot_from_scan).apply(
        heading_vectors(seen.scan.bearings[seen.scan.hit]) * seen.scan.ranges[seen.scan.hit, None]
    )
    assert len(points) > 15
    # On the side of the line that faces the robot, and on a dash.
    across = np.abs(points[:, 0] - 0.238)
    # At a corner a line through the ends of dashes may count: few readings, up to 8 mm off.
    assert (across < 0.001).mean() > 0.95 and across.max() < 0.010
    along = (-points[:, 1] + 0.6) % 0.075
    assert ((along < 0.053) | (along > 0.072)).mean() > 0.95


def test_a_line_without_gaps_is_not_taken_for_dashes() -> None:
    field = floor(
        f'<path stroke="{LIGHT}" stroke-width="24" d="M250,-600 V600"/>'
        f'<path stroke="{LIGHT}" stroke-width="24" stroke-dasharray="50 25" d="M-600,-600 V600"/>',
        DARK,
    )
    dashes_alone = LineScanner(VIEW, LineScannerSettings(), (Tape(0.024, True, 0.05),))
    picture = quiet_camera(field).picture(Pose2(), STILL)
    assert dashes_alone.scan(Frame(0.0, picture)).scan.hit.mean() < 0.05
    assert scan(field, Pose2()).scan.hit.mean() > 0.7


def test_curved_light_tape_is_seen_all_along() -> None:
    field = floor(f'<circle r="300" stroke="{LIGHT}" stroke-width="48"/>', DARK)
    seen = scan(field, Pose2())
    begins, ends = expected(field, Pose2())
    whole = np.isfinite(begins) & np.isfinite(ends)
    dark = scan(floor(f'<circle r="300" stroke="{DARK}" stroke-width="48"/>', LIGHT), Pose2())
    assert seen.scan.hit[whole].mean() >= dark.scan.hit[whole].mean() > 0.9
    hit = seen.scan.hit
    assert np.abs(seen.scan.ranges[hit] - begins[hit]).max() < 0.003


def test_a_road_has_its_kinds_of_tape_and_a_free_floor() -> None:
    field = road()
    assert field.tape == (Tape(0.048, light=True), Tape(0.024, light=True, dash=0.05))
    # Outlines of tape: the floor is to the right of each edge, also where tape is light.
    middle = (field.edges[:, :2] + field.edges[:, 2:]) / 2
    pixels = field.floor.pixel_from_map
    grey = [
        field.floor.image[tuple((pixels[:, :2] @ point + pixels[:, 2]).round().astype(int)[::-1])]
        for point in (middle + 0.006 * field.normals)[lengths(field.edges) > 0.03]
    ]
    assert np.median(grey) < 60
    poses = field.free_poses(np.random.default_rng(0), 500)
    places = (poses[:, :2] @ pixels[:, :2].T + pixels[:, 2]).round().astype(int)
    levels = field.floor.image[places[:, 1].clip(0, 1999), places[:, 0].clip(0, 1999)]
    assert (levels < 100).mean() > 0.98


def test_paint_of_the_floors_own_tone_hides_light_tape() -> None:
    line = f'<path stroke="{LIGHT}" stroke-width="50" d="M300,-600 V600"/>'
    covered = floor(line + f'<rect x="200" y="-100" width="200" height="200" fill="{DARK}"/>', DARK)
    assert len(covered.edges) == 2 * len(floor(line, DARK).edges)


def test_a_light_stroke_on_a_light_floor_is_no_tape() -> None:
    line = f'<path stroke="{DARK}" stroke-width="50" d="M300,-600 V600"/>'
    more = '<path stroke="#fff" stroke-width="50" d="M-300,-600 V600"/>'
    assert floor(line + more, LIGHT).tape == (Tape(0.05),)


def test_settings_overrule_the_field() -> None:
    tape = (Tape(0.048, light=True), Tape(0.024, light=True, dash=0.05))
    (field_look,) = looks("field", 0.0, tape)
    assert field_look.light and field_look.widths.tolist() == [0.048]
    assert field_look.dashes.tolist() == [[0.024, 0.05]]
    (dark,) = looks("dark", 0.03, tape)
    assert not dark.light and dark.widths.tolist() == [0.03]
    assert [look.light for look in looks("either", 0.0, ())] == [False, True]
    counted = np.array([True, True, False])
    nearest = nearest_widths(np.array([0.045, 0.027, 0.03]), counted, np.array([0.024, 0.048]))
    assert nearest[:2].tolist() == [0.048, 0.024] and math.isnan(nearest[2])


def test_bad_settings_name_what_is_valid() -> None:
    with pytest.raises(SettingError, match=r"is 0\.001 m; valid is 0 or 0\.005 to 0\.5 m"):
        LineScannerSettings(tape_width=0.001)
    with pytest.raises(SettingError, match="valid are field, dark, light, either"):
        LineScannerSettings(tape_brightness="bright")


def test_the_drawing_without_tape_says_what_would_be_tape(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="or a light one on a dark fill"):
        floor("", DARK)
