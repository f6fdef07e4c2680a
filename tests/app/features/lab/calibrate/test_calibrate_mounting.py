"""``brickpose calibrate mounting``: one picture in, the robot's profile out."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import cache
from pathlib import Path

import cv2
import numpy as np
import pytest
from board_pictures import CHESSBOARD
from floor_boards import SPEC, built, floor, seen_by
from mounting_pictures import CORNER, tape_picture

from app.command_line import main
from robot.description.profile import Profile, load_profile
from robot.description.unknowns import Differences
from robot.lens_files.camera_info import camera_info

pytestmark = pytest.mark.slow

AT = ["--at", "0.19", "-0.125", "0"]
BUILT = built(3)


@cache
def content(scale: float) -> bytes:
    below = floor(CHESSBOARD, tape=0.05, scale=scale)
    return cv2.imencode(".png", seen_by(BUILT, below, 3))[1].tobytes()


@pytest.fixture
def picture(tmp_path: Path) -> Path:
    result = tmp_path / "floor.png"
    result.write_bytes(content(1.0))
    return result


def run(*arguments: object) -> int:
    return main(["calibrate", "mounting", *map(str, arguments)])


def test_a_board_on_the_floor_makes_a_profile(picture: Path, tmp_path: Path, capsys) -> None:
    out = tmp_path / "new" / "spike.toml"
    assert run(picture, *AT, "--out", out) == 0
    said = capsys.readouterr().out
    assert "the tape beside the board seems" in said
    profile = load_profile(out)
    true = Differences.between(SPEC, BUILT, 0.0).values
    assert np.degrees(np.abs(profile.values[:3] - true[:3])).max() < 0.05
    assert np.abs(profile.values[3:6] - true[3:6]).max() < 0.0003
    assert profile.values[6:].tolist() == [0] * 5
    applied = profile.applied_to(SPEC).robot_from_camera
    assert applied == pytest.approx(BUILT.robot_from_camera, abs=0.001)
    report = cv2.imread(str(out.with_suffix(".png")))
    assert report.shape == (480, 640, 3)
    coloured = np.ptp(report.astype(int), axis=2) > 60
    assert 0.01 < coloured.mean() < 0.3


def test_what_the_profile_has_besides_is_kept(picture: Path, tmp_path: Path) -> None:
    out = tmp_path / "spike.toml"
    before = Profile.unmeasured("spike", "60 s of driving on square")
    values = np.linspace(0.001, 0.011, 11)
    out.write_text(replace(before, values=values).to_toml())
    assert run(picture, *AT, "--out", out) == 0
    after = load_profile(out)
    assert after.values[6:].tolist() == pytest.approx(values[6:].tolist())
    assert not np.allclose(after.values[:6], values[:6])
    assert after.source.startswith("60 s of driving on square; mounting by a chessboard")


def test_the_lens_of_a_file_is_used_and_kept(picture: Path, tmp_path: Path) -> None:
    lens, out = tmp_path / "camera.yaml", tmp_path / "spike.toml"
    longer = replace(SPEC.lens, matrix=SPEC.lens.matrix * [[1.004, 1, 1], [1, 1.004, 1], [1, 1, 1]])
    sd = np.array([0.5, 0.5, 0.4, 0.4, 0.01, 0.01, 0.001, 0.001, 0.01])
    lens.write_text(camera_info(longer, sd))
    assert run(picture, *AT, "--out", out, "--camera", lens, "--report", tmp_path / "seen.png") == 0
    first = load_profile(out)
    kept = first.lens
    assert kept is not None
    assert kept.lens.matrix[0, 0] == pytest.approx(1.004 * 530)
    assert kept.sd == pytest.approx(sd)
    assert (tmp_path / "seen.png").exists()
    assert run(picture, *AT, "--out", out) == 0  # and the profile's lens is used from now on
    again = load_profile(out)
    assert again.lens is not None
    assert again.values[:6] == pytest.approx(first.values[:6])


def test_a_focal_length_that_a_drive_measured_is_used(picture: Path, tmp_path: Path) -> None:
    """The same as a lens file that says so."""
    longer = replace(SPEC.lens, matrix=SPEC.lens.matrix * [[1.004, 1, 1], [1, 1.004, 1], [1, 1, 1]])
    lens, by_lens, by_drive = (tmp_path / name for name in ("c.yaml", "lens.toml", "drive.toml"))
    lens.write_text(camera_info(longer))
    assert run(picture, *AT, "--out", by_lens, "--camera", lens) == 0
    before = Profile.unmeasured("spike", "60 s of driving")
    by_drive.write_text(replace(before, values=0.004 * (np.arange(11) == 6)).to_toml())
    assert run(picture, *AT, "--out", by_drive) == 0
    expected = load_profile(by_lens).applied_to(SPEC)
    assert load_profile(by_drive).applied_to(SPEC).robot_from_camera == pytest.approx(
        expected.robot_from_camera
    )


def test_a_lens_that_nobody_measured_makes_wide_intervals(
    picture: Path, tmp_path: Path, capsys
) -> None:
    out, lens = tmp_path / "spike.toml", tmp_path / "camera.yaml"
    assert run(picture, *AT, "--out", out) == 0
    assert "the focal length is known to 5.9 % only" in capsys.readouterr().out
    lens.write_text(camera_info(SPEC.lens, np.array([0.5, 0.5, 0.4, 0.4, *[0.01] * 5])))
    exact = tmp_path / "exact.toml"
    assert run(picture, *AT, "--out", exact, "--camera", lens) == 0
    assert "focal length" not in capsys.readouterr().out
    assert load_profile(out).sd[5] > 10 * load_profile(exact).sd[5]


def test_the_tape_of_a_field_will_do(tmp_path: Path, capsys) -> None:

    picture, out = tmp_path / "corner.png", tmp_path / "spike.toml"
    cv2.imwrite(str(picture), tape_picture(BUILT, 3))
    start = [str(part) for part in CORNER.to_array()]
    assert run(picture, "--map", "square", "--start", *start, "--out", out) == 0
    true = Differences.between(SPEC, BUILT, 0.0).values
    assert math.degrees(abs(load_profile(out).values[1] - true[1])) < 0.1
    assert "mounting by tape of square in corner.png" in out.read_text()


OTHER = Profile.unmeasured("other", "").to_toml()


@pytest.mark.parametrize(
    ("options", "before", "code", "words"),
    [
        ([], "", 2, "where is the board, or the robot? valid are --at X Y THETA"),
        ([*AT, "--map", "square"], "", 2, "--map has no effect with --at"),
        (["--map", "square", "--size", "0.02"], "", 2, "--size has no effect with --map"),
        (["--map", "none"], "", 2, "there is no field 'none'"),
        ([*AT, "--squares", "12x9"], "", 1, "no whole chessboard of 12 x 9 inner corners"),
        (["--at", "0.2", "0.2", "1.57"], "", 1, "turned by"),
        (AT, OTHER, 1, "is of the robot 'other', not of 'spike'"),
        (AT, "as before", 1, "is no TOML"),
        ([*AT, "--camera", "absent.yaml"], "", 1, "absent.yaml: no readable camera file"),
    ],
)
def test_bad_input_is_told_and_nothing_is_overwritten(
    options: list[str], before: str, code: int, words: str, picture: Path, tmp_path: Path, capsys
) -> None:
    out = tmp_path / "spike.toml"
    if before:
        out.write_text(before)
    assert run(picture, *options, "--out", out) == code
    assert words in capsys.readouterr().err
    assert (out.read_text() if before else "") == before
    assert out.exists() == bool(before)
    assert not out.with_suffix(".png").exists()


@pytest.mark.parametrize(
    ("changed", "words"),
    [
        (b"", "no picture that can be read"),
        (cv2.imencode(".png", np.full((240, 320), 99, np.uint8))[1].tobytes(),
         "is of 320 x 240 px, but the lens is for pictures of 640 x 480 px"),
        (cv2.imencode(".png", np.full((480, 640), 99, np.uint8))[1].tobytes(), "in sight"),
        (content(0.95), "the squares are not 25.00 mm but 23.7"),
    ],
)  # fmt: skip
def test_a_picture_of_no_use_is_told(
    changed: bytes, words: str, picture: Path, tmp_path: Path, capsys
) -> None:
    picture.write_bytes(changed)
    assert run(picture, *AT, "--out", tmp_path / "spike.toml") == 1
    assert words in capsys.readouterr().err
    assert not (tmp_path / "spike.toml").exists()
