"""``brickpose calibrate lens``: a folder of pictures in, a camera_info file out."""

from __future__ import annotations

import shutil
from dataclasses import replace
from functools import cache
from pathlib import Path

import cv2
import numpy as np
import pytest
import yaml
from board_pictures import CHESSBOARD, lens_of, picture, poses
from exif_pictures import tiff_header, with_exif
from places import SHARED

from app.command_line import main
from robot.description.profile import Profile, load_profile
from robot.description.spec import RobotSpec
from robot.lens_files.reading import read_lens_file

pytestmark = pytest.mark.slow

LEFT_RIGHT = SHARED / "calib_opencv_left_right"
ASKED = ["--squares", "10x7", "--size", "0.025"]


@cache
def board_pictures() -> tuple[bytes, ...]:
    rng, lens = np.random.default_rng(3), lens_of()
    places = poses(CHESSBOARD, lens, 7, rng)
    greys = (picture(CHESSBOARD, place, rng) for place in places)
    return tuple(cv2.imencode(".png", grey)[1].tobytes() for grey in greys)


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    result = tmp_path / "pictures"
    result.mkdir()
    for number, content in enumerate(board_pictures()):
        (result / f"{number}.png").write_bytes(content)
    return result


def run(*arguments: object) -> int:
    return main(["calibrate", "lens", *map(str, arguments)])


def test_a_folder_of_pictures_gives_a_lens_file(folder: Path, tmp_path: Path, capsys) -> None:
    (folder / "empty.png").write_bytes(b"")
    turned = folder / "3.png"
    turned.write_bytes(with_exif(turned.read_bytes(), tiff_header(6)))
    (folder / "notes.txt").write_text("no picture")
    (folder / "again.png").write_bytes(board_pictures()[0])
    out = tmp_path / "made" / "camera.yaml"
    assert run(folder, *ASKED, "--out", out) == 0
    said = capsys.readouterr().out
    assert "refused empty.png: no picture that can be read" in said
    assert "3.png says by EXIF that it is to be turned; pictures are taken" in said
    assert "repeated: the board is where it is in" in said
    assert "7 pictures count" in said
    true, lens = lens_of(), read_lens_file(out).lens
    assert lens.model == "plumb_bob"
    sd = yaml.safe_load(out.read_text())["parameter_sd"]
    assert abs(lens.matrix[0, 0] - true.matrix[0, 0]) < 4 * sd["fx"] < 8
    assert abs(lens.matrix[0, 2] - true.matrix[0, 2]) < 4 * sd["cx"] < 8
    assert lens.readout == 0.015  # the description's
    report = out.with_suffix(".html").read_text()
    assert report.count("data:image/svg+xml;base64,") == 2
    assert "<h1>The lens: plumb_bob</h1>" in report
    assert "refused: no picture that can be read" in report


@pytest.mark.parametrize(
    ("form", "name", "title"),
    [
        ("opencv", "camera.yaml", "OpenCV's FileStorage"),
        ("kalibr", "camera.yaml", "Kalibr's camchain"),
        ("ini", "camera.ini", "ROS's .ini"),
    ],
)
def test_the_lens_is_written_for_other_programs(
    form: str, name: str, title: str, folder: Path, tmp_path: Path, monkeypatch, capsys
) -> None:
    monkeypatch.chdir(tmp_path)
    assert run(folder, *ASKED, "--format", form) == 0
    said = capsys.readouterr().out
    file = read_lens_file(tmp_path / name)
    assert (file.form, file.remarks) == (title, ())
    assert file.lens.model == ("equidistant" if form == "kalibr" else "plumb_bob")
    assert ("Kalibr's camchain can hold equidistant only" in said) == (form == "kalibr")
    assert abs(file.lens.matrix[0, 0] - lens_of().matrix[0, 0]) < 5
    assert (tmp_path / "camera.html").exists()


@pytest.mark.parametrize(
    ("options", "reason"),
    [
        (["--format", "ini", "--out", "x.yaml"], "ends in .ini or .txt (ROS's .ini)"),
        (["--format", "ros", "--out", "x.toml"], "a profile has no --format"),
        (["--out", "x.json"], "ends in .yaml or .yml (ROS's camera_info) or .toml"),
    ],
)
def test_a_file_of_another_ending_is_refused(
    options: list[str], reason: str, folder: Path, capsys
) -> None:
    assert run(folder, *ASKED, *options) == 2
    assert reason in capsys.readouterr().err


@pytest.mark.parametrize("squares", ["9x6", "10x7"])
def test_squares_may_be_told_or_inner_corners_as_ros_counts_them(
    squares: str, folder: Path, tmp_path: Path, capsys
) -> None:
    out = tmp_path / "camera.yaml"
    assert run(folder, "--squares", squares, "--out", out) == 0
    assert "10 x 7 squares (9 x 6 inner corners)" in capsys.readouterr().out
    assert out.exists()


def test_the_lens_may_go_into_a_profile(folder: Path, tmp_path: Path) -> None:
    """Wheels and delay are kept; the mounting, measured through another lens, is not."""
    out = tmp_path / "spike.toml"
    before = Profile.unmeasured("spike", "")
    out.write_text(replace(before, values=np.full(11, 0.01)).to_toml())
    assert run(folder, *ASKED, "--out", out) == 0
    profile = load_profile(out)
    assert profile.lens is not None
    assert profile.lens.lens.matrix[0, 0] == pytest.approx(lens_of().matrix[0, 0], abs=3)
    assert profile.values.tolist() == [0] * 7 + [0.01] * 4
    assert profile.sd[6] < 0.005
    seen_by = profile.applied_to(RobotSpec.load())
    assert seen_by.lens.matrix[0, 2] == pytest.approx(327, abs=3)
    assert seen_by.lens.readout == 0.015
    assert seen_by.as_drawn.lens.matrix[0, 2] == 319.5


@pytest.mark.parametrize(
    ("options", "code", "words"),
    [
        (["--squares", "8x5"], 1, "0 pictures of 2 are of use; valid are 6 or more"),
        (["--squares", "ten"], 2, "--squares is 'ten'; valid is such as 10x7"),
        (["--squares", "2x7"], 2, "a board of 2 x 7 squares; valid is 3 to 40"),
        (["--size", "25"], 2, "valid is 0.001 to 1 m (25 mm are 0.025 m)"),
        (["--type", "charuco"], 1, "0 corners of the charuco board in sight"),
        (["--type", "charuco", "--dictionary", "7x7"], 2, "valid are 4x4_50"),
        (["--out", "lens.txt"], 2, "valid is a file that ends in .yaml"),
    ],
)
def test_bad_input_is_told_and_nothing_is_overwritten(
    options: list[str], code: int, words: str, folder: Path, tmp_path: Path, capsys
) -> None:
    for path in sorted(folder.iterdir())[2:]:
        path.unlink()
    out = tmp_path / "camera.yaml"
    out.write_text("as before")
    assert run(folder, "--out", out, "--force", *options) == code
    assert words in capsys.readouterr().err
    assert out.read_text() == "as before"


def test_no_pictures_are_told(tmp_path: Path, capsys) -> None:
    assert run(tmp_path) == 2
    assert "has no pictures; valid are files that end in .bmp" in capsys.readouterr().err
    assert run(tmp_path / "absent.png") == 1
    assert "absent.png: cannot be read: No such file" in capsys.readouterr().err


@pytest.mark.data
@pytest.mark.skipif(not LEFT_RIGHT.exists(), reason="needs the recordings beside the repository")
def test_the_lens_of_opencvs_pictures_is_the_published_one(tmp_path: Path, capsys) -> None:
    """Published: f 535.9 and 533.5, c (342.3, 235.6) and (341.6, 235.2)."""
    for path in LEFT_RIGHT.glob("left*.jpg"):
        shutil.copy(path, tmp_path)
    first = cv2.imread(str(LEFT_RIGHT / "left03.jpg"))
    bad = {
        "blurred": cv2.GaussianBlur(first, (0, 0), 3),
        "cut": first[:, :400],
        "half": cv2.resize(first, None, fx=0.5, fy=0.5),
        "mirrored": first[:, ::-1],
        "repeated": first,
        "black": 0 * first,
    }
    for name, image in bad.items():
        assert cv2.imwrite(str(tmp_path / f"{name}.png"), image)
    out = tmp_path / "camera.yaml"
    assert run(tmp_path, "--squares", "9x6", "--size", "0.025", "--out", out) == 0
    said = capsys.readouterr().out
    assert said.count("refused") == len(bad)
    assert "refused mirrored.png: mirrored: turned round, it is left03.jpg" in said
    assert float(said.split("plumb_bob")[1].split()[0]) < 0.3
    matrix = read_lens_file(out).lens.matrix
    assert 531 < matrix[0, 0] < 537 and 531 < matrix[1, 1] < 537
    assert np.abs(matrix[:2, 2] - (342.3, 235.6)).max() < 3
    assert np.abs(matrix[:2, 2] - (341.6, 235.2)).max() < 3


def test_another_cameras_pictures_are_refused_for_a_profile_before_they_are_searched(
    tmp_path: Path, capsys
) -> None:
    folder, out = tmp_path / "wide", tmp_path / "wide.toml"
    folder.mkdir()
    cv2.imwrite(str(folder / "a.png"), np.full((600, 800), 128, np.uint8))
    options = ["--squares", "9x6", "--size", "0.025", "--out", out]
    assert run(folder, *options) == 2
    told = capsys.readouterr().err
    assert "a.png is of 800 x 600 px" in told
    assert f"valid is --out {tmp_path / 'wide.yaml'}" in told
    assert not out.exists()
