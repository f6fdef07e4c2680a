"""One picture, one scan: what counts as tape, what does not, and what is refused."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
from tape_trials import SCANNER, SQUARE, STILL, VIEW, camera_of, drawn

from robot.fields.field_loading import load_field
from robot.geometry import Pose2, Twist2
from robot.interface import Frame
from robot.scanning.along_rays import between
from robot.scanning.line_scanner import LineScanner, LineScannerSettings
from robot.scanning.tape_edges import Verdict
from robot.settings import SettingError, describe
from sim.floor_camera import CameraSettings, FloorCamera

SIZE = (480, 640)


@pytest.fixture(scope="module")
def camera() -> FloorCamera:
    return camera_of(SQUARE)


@pytest.mark.parametrize(("millimetres", "is_tape"), [(30, False), (50, True), (70, False)])
def test_a_stripe_of_another_width_is_not_tape(
    tmp_path: Path, millimetres: int, is_tape: bool
) -> None:
    line = f'<path d="M 400 -600 V 600" fill="none" stroke="black" stroke-width="{millimetres}"/>'
    field = drawn(tmp_path, f"stripe{millimetres}", "", tape=line)
    scan = SCANNER.scan(Frame(0.0, camera_of(field).picture(Pose2(0, 0, 0.2), STILL)))
    assert (scan.scan.hit.sum() > 60) == is_tape
    if not is_tape:
        assert not scan.scan.hit.any()
        judged = scan.verdicts[45]
        assert judged == Verdict.WRONG_WIDTH
        assert scan.widths[45] == pytest.approx(millimetres / 1000, abs=3e-3)
        assert np.isnan(scan.tape_width)
    measured = np.isfinite(SCANNER.tape_and_first_edges(scan.picture)[0]).all(axis=1)
    np.testing.assert_array_equal(measured, scan.verdicts == Verdict.COUNTED)


def test_a_picture_that_comes_again_is_known_for_it() -> None:
    scanner = LineScanner(VIEW, LineScannerSettings())
    clean = camera_of(SQUARE, CameraSettings(noise=0)).picture(Pose2(0, 0, 0.2), STILL)
    rng = np.random.default_rng(5)
    noisy, other = (
        np.clip(clean + rng.normal(0, 3, clean.shape), 0, 255).astype(np.uint8) for _ in range(2)
    )
    pictures = [noisy, noisy.copy(), other, noisy, noisy, clean, clean]
    sums = [scanner.scan(Frame(0.1 * i, p)).scan.picture for i, p in enumerate(pictures)]
    assert sums[0] == sums[1] == sums[3] == sums[4]
    assert sums[0] != 0 != sums[2] != sums[0]
    # Without noise, a robot may truly see the same again.
    assert sums[5:] == [0, 0]


def test_an_edge_without_the_other_side_in_view_is_no_return(tmp_path: Path) -> None:
    """Tape that leaves the picture at its upper border."""
    line = '<path d="M 860 -700 V 700" fill="none" stroke="black" stroke-width="50"/>'
    path = tmp_path / "leaving.svg"
    path.write_text(
        '<svg xmlns="http://www.w3.org/2000/svg" width="2000mm" height="1500mm" '
        f'viewBox="-750 -750 2000 1500">{line}</svg>'
    )
    field = load_field(str(path), tmp_path)
    scan = SCANNER.scan(Frame(0.0, camera_of(field).picture(Pose2(), STILL)))
    straight_on = np.abs(SCANNER.table.bearings) < 0.1
    assert not scan.scan.hit[straight_on].any()
    assert set(scan.verdicts[straight_on]) <= {int(Verdict.NO_EXIT), int(Verdict.NO_EDGE)}
    near = SCANNER.scan(Frame(0.0, camera_of(field).picture(Pose2(0.1), STILL)))
    assert set(near.verdicts[straight_on]) == {int(Verdict.COUNTED)}


def test_what_lies_behind_something_else_is_still_found(tmp_path: Path) -> None:
    """A blob before the tape fails the checks; the tape behind it passes them."""
    field = drawn(tmp_path, "blob", '<circle cx="250" cy="0" r="60" fill="black"/>')
    scan = SCANNER.scan(Frame(0.0, camera_of(field).picture(Pose2(), STILL)))
    assert scan.scan.ranges[45] == pytest.approx(0.475, abs=1e-3)


def test_things_on_the_floor_are_told_with_where_they_begin_and_end(tmp_path: Path) -> None:
    """One shoe lies on the tape, one before it, and the ray straight on begins in a third."""
    shoes = [(500, 0, 80), (180, 0, 60), (330, 150, 30)]
    drawing = "".join(f'<circle cx="{x}" cy="{y}" r="{r}"/>' for x, y, r in shoes)
    field = drawn(tmp_path, "shoes", drawing)
    found = SCANNER.scan(Frame(0.0, camera_of(field).picture(Pose2(), STILL))).scan
    assert found.hidden is not None
    assert not found.hit[45]
    assert found.hidden[45] == pytest.approx([0.0, 0.58], abs=4e-3)
    # y is to the left, and so are positive bearings; the drawing's y is down.
    aside = int(np.argmin(np.abs(found.bearings - math.atan2(-150, 330))))
    middle = math.hypot(330, 150) / 1000
    assert found.hit[aside]
    assert found.hidden[aside] == pytest.approx([middle - 0.03, middle + 0.03], abs=4e-3)
    opposite = len(found.bearings) - 1 - aside
    assert found.hit[opposite]
    assert found.hidden[opposite].tolist() == [math.inf, -math.inf]


def test_an_entry_without_exit_hides_all_that_lies_behind(tmp_path: Path) -> None:
    """The tape beyond a carpet that fills the upper part of the picture."""
    carpet = '<rect x="300" y="-700" width="500" height="1400"/>'
    field = drawn(tmp_path, "carpet", carpet)
    found = SCANNER.scan(Frame(0.0, camera_of(field).picture(Pose2(), STILL))).scan
    assert found.hidden is not None and not found.hit[45]
    assert found.hidden[45, 0] == pytest.approx(0.3, abs=4e-3)
    assert found.hidden[45, 1] == math.inf or found.hidden[45, 1] > 0.75


@pytest.mark.parametrize("grey", [0, 128, 255])
def test_an_even_picture_has_no_returns_and_says_why(grey: int) -> None:
    found = SCANNER.scan(Frame(3.5, np.full(SIZE, grey, dtype=np.uint8)))
    assert not found.scan.hit.any()
    assert (found.scan.ranges == np.inf).all()
    assert (found.verdicts == Verdict.NO_EDGE).all()
    assert np.isnan(found.edges).all() and np.isnan(found.widths).all()
    assert found.scan.stamp == 3.5
    assert len(found.scan.points()) == 0
    assert found.noise == 0 and math.isnan(found.tape_width)


def test_pure_noise_has_no_returns() -> None:
    rng = np.random.default_rng(0)
    for sd in (5, 30, 80):
        noise = np.clip(rng.normal(128, sd, SIZE), 0, 255).astype(np.uint8)
        assert SCANNER.scan(Frame(0.0, noise)).scan.hit.mean() < 0.03


def test_a_colour_picture_gives_what_its_grey_one_gives(camera: FloorCamera) -> None:
    grey = camera.picture(Pose2(0.1, 0, 0.3), STILL)
    colour = SCANNER.scan(Frame(0.0, np.dstack([grey] * 3)), Twist2(0.1, 0.2))
    plain = SCANNER.scan(Frame(0.0, grey), Twist2(0.1, 0.2))
    assert plain.scan.hit.any()
    np.testing.assert_array_equal(colour.scan.ranges, plain.scan.ranges)


def test_red_tape_is_seen_as_dark_as_it_is(camera: FloorCamera) -> None:
    """BGR: taken as RGB, a light blue would be a dark red."""
    grey = camera.picture(Pose2(), STILL)
    colour = np.dstack([np.full_like(grey, 200), np.full_like(grey, 60), grey])
    expected_grey = cv2.cvtColor(colour, cv2.COLOR_BGR2GRAY)
    np.testing.assert_array_equal(
        SCANNER.scan(Frame(0.0, colour)).picture, SCANNER.scan(Frame(0.0, expected_grey)).picture
    )


@pytest.mark.parametrize("shape", [(640, 480), (240, 320), (480, 641, 3), (0, 0), (480,)])
def test_a_picture_of_another_size_is_refused(shape: tuple[int, ...]) -> None:
    with pytest.raises(ValueError, match="the lens is described for 640 x 480"):
        SCANNER.scan(Frame(0.0, np.zeros(shape, dtype=np.uint8)))


@pytest.mark.parametrize("channels", [1, 2, 4])
def test_a_picture_with_another_number_of_colours_is_refused(channels: int) -> None:
    with pytest.raises(ValueError, match=r"grey .* or BGR"):
        SCANNER.scan(Frame(0.0, np.zeros((*SIZE, channels), dtype=np.uint8)))


def test_the_same_picture_gives_the_same_scan(camera: FloorCamera) -> None:
    picture = camera.picture(Pose2(0.2, 0.1, 1), STILL)
    first, again = (SCANNER.scan(Frame(0.0, picture), Twist2(0.2, 1)) for _ in range(2))
    np.testing.assert_array_equal(first.scan.ranges, again.scan.ranges)
    assert first.scan.hit.any()


@pytest.mark.parametrize("rays", [3, 5])
def test_rays_too_far_apart_support_no_line_and_say_so(rays: int, camera: FloorCamera) -> None:
    scanner = LineScanner(VIEW, LineScannerSettings(rays=rays, field_of_view=0.9))
    found = scanner.scan(Frame(0.0, camera.picture(Pose2(), STILL)))
    assert found.scan.bearings.shape == found.scan.ranges.shape == (rays,)
    assert (found.verdicts == Verdict.TOO_SHORT).all()
    assert not found.scan.hit.any()


@pytest.mark.parametrize(
    ("name", "least", "others"),
    [
        ("rays", 3, {"field_of_view": 0.2}),
        ("field_of_view", 0.01, {"support": 0.005}),
        ("support", 0.005, {}),
        ("width_tolerance", 0.0005, {}),
        ("straightness", 0.0002, {}),
        ("taper", 0.0001, {}),
    ],
)
def test_at_its_lower_limit_a_setting_still_lets_tape_be_found(
    name: str, least: float, others: dict[str, Any], camera: FloorCamera
) -> None:
    limit = describe(LineScannerSettings)[name].low
    assert limit == least
    scanner = LineScanner(VIEW, LineScannerSettings(**{name: least}, **others))
    assert scanner.scan(Frame(0.0, camera.picture(Pose2(), STILL))).scan.hit.sum() >= 3
    with pytest.raises(SettingError, match=f"{name} is 0"):
        LineScannerSettings(**{name: 0})


def test_rays_out_of_sight_say_so_and_the_others_go_on(camera: FloorCamera) -> None:
    scanner = LineScanner(VIEW, LineScannerSettings(rays=181, field_of_view=math.pi * 2))
    found = scanner.scan(Frame(0.0, camera.picture(Pose2(), STILL)), Twist2(0.2, 1))
    aside = np.abs(scanner.table.bearings) > math.radians(45)
    assert (found.verdicts[aside] == Verdict.OUT_OF_SIGHT).all()
    assert np.isnan(scanner.table.limits[aside]).all()
    assert not found.scan.hit[aside].any()
    assert found.scan.hit[np.abs(scanner.table.bearings) < 0.3].all()


def test_a_scanner_whose_rays_are_all_out_of_sight_finds_nothing() -> None:
    scanner = LineScanner(VIEW, LineScannerSettings(range_max=0.05))
    found = scanner.scan(Frame(0.0, np.full(SIZE, 90, dtype=np.uint8)), Twist2(0.2, 1))
    assert (found.verdicts == Verdict.OUT_OF_SIGHT).all()
    assert not found.scan.hit.any()


def test_a_hit_lies_in_the_picture_where_it_was_measured(camera: FloorCamera) -> None:
    """The pixel drawn for an entry sees the floor that the range says."""
    found = SCANNER.scan(Frame(0.0, camera.picture(Pose2(0.1, 0, 0.2), STILL)))
    pixels = SCANNER.pixels(found.edges[:, 0])
    hit = found.scan.hit
    np.testing.assert_allclose(VIEW.floor_points(pixels[hit]), found.scan.points(), atol=5e-5)
    assert np.isnan(pixels[np.isnan(found.edges[:, 0])]).all()
    ray = int(np.flatnonzero(hit)[0])
    position = float(found.edges[ray, 0])
    assert between(SCANNER.table.distances[ray], position) == pytest.approx(
        found.scan.ranges[ray], abs=1e-9
    )


def test_one_wrong_width_does_not_change_the_width_that_is_told(camera: FloorCamera) -> None:
    found = SCANNER.scan(Frame(0.0, camera.picture(Pose2(), STILL)))
    assert found.tape_width == pytest.approx(0.050, abs=5e-4)
    for wrong in (0.0, 0.2):
        widths = found.widths.copy()
        widths[np.flatnonzero(found.verdicts == Verdict.COUNTED)[0]] = wrong
        assert replace(found, widths=widths).tape_width == pytest.approx(0.050, abs=5e-4)


@pytest.mark.parametrize("step", [0.5, 1.0, 3.0])
def test_noise_is_the_same_whatever_the_step(step: float) -> None:
    """Samples closer than pixels see the same pixel twice."""
    rng = np.random.default_rng(0)
    picture = np.clip(rng.normal(128, 10, SIZE), 0, 255).astype(np.uint8)
    scanner = LineScanner(VIEW, LineScannerSettings(step=step))
    assert scanner.scan(Frame(0.0, picture)).noise == pytest.approx(10, rel=0.08)
