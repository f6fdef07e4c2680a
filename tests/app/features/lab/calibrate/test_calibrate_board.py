"""``brickpose calibrate board``: what is printed is the board, at its true size."""

from __future__ import annotations

import re
from itertools import pairwise
from pathlib import Path
from xml.etree import ElementTree

import cv2
import numpy as np
import pytest

from app.command_line import main
from robot.calibration.lens.board import Board
from robot.calibration.lens.board_search import find_board
from robot.calibration.lens.sighting import Grey
from robot.geometry import Array

PX = 4
"""Pixels in a millimetre."""
Painted = list[tuple[Array, bool]]
"""Polygons [mm], the lowest first, and whether they are black."""

BOARDS = {
    "usual": ([], Board("chessboard", 10, 7, 0.025)),
    "upright": (["--squares", "6x9", "--size", "0.028"], Board("chessboard", 6, 9, 0.028)),
    "markers": (
        ["--type", "charuco", "--squares", "7x5", "--size", "0.033", "--marker", "0.75"],
        Board("charuco", 7, 5, 0.033, 0.75),
    ),
    "other markers": (
        ["--type", "charuco", "--squares", "5x7", "--size", "0.03", "--dictionary", "6x6_250"],
        Board("charuco", 5, 7, 0.03, dictionary="6x6_250"),
    ),
    "large": (["--size", "0.036", "--paper", "a3"], Board("chessboard", 10, 7, 0.036)),
}


def run(*arguments: object) -> int:
    return main(["calibrate", "board", *map(str, arguments)])


def of_svg(path: Path) -> tuple[tuple[float, float], Painted]:
    root = ElementTree.fromstring(path.read_text())
    assert root.get("width", "").endswith("mm") and root.get("height", "").endswith("mm")
    size = float(root.get("width", "")[:-2]), float(root.get("height", "")[:-2])
    assert root.get("viewBox") == f"0 0 {size[0]:g} {size[1]:g}"
    shapes = []
    for item in root.findall("{*}polygon"):
        points = [
            [float(part) for part in pair.split(",")] for pair in item.get("points", "").split()
        ]
        shapes.append((np.array(points), item.get("fill") == "black"))
    return size, shapes


def of_pdf(path: Path) -> tuple[tuple[float, float], Painted]:
    """Read what this program writes; the cross-reference table must be right."""
    data = path.read_bytes()
    start = int(data.rsplit(b"startxref", 1)[1].split()[0])
    assert data[start:].startswith(b"xref\n0 6\n")
    places = [int(line[:10]) for line in data[start:].split(b"\n")[3:8]]
    for number, place in enumerate(places, 1):
        assert data[place:].startswith(b"%d 0 obj\n" % number)
    box = re.search(rb"/MediaBox \[0 0 ([\d.]+) ([\d.]+)\]", data)
    assert box is not None
    size = float(box[1]) * 25.4 / 72, float(box[2]) * 25.4 / 72
    length, content = re.search(rb"/Length (\d+) >>\nstream\n(.*)\nendstream", data, re.S).groups()  # type: ignore[union-attr]
    assert int(length) == len(content)
    lines = content.decode("ascii").splitlines()
    scale, _, _, flip, _, top = (float(part) for part in lines[0].split()[1:7])
    assert lines[0].startswith("q ") and flip == -scale
    assert scale == pytest.approx(72 / 25.4) and top == pytest.approx(size[1] * scale, abs=1e-3)
    shapes = []
    for line in lines[1 : lines.index("Q")]:
        numbers = re.findall(r"(-?[\d.]+) (-?[\d.]+) [ml]", line)
        shapes.append((np.array(numbers, float), line.startswith("0 g")))
    return size, shapes


def printed(size: tuple[float, float], shapes: Painted) -> Grey:
    """The page as a scanner would see it."""
    page = np.full((round(size[1] * PX), round(size[0] * PX)), 255, np.uint8)
    for points, black in shapes:
        corners = np.rint((points * PX - 0.5) * 16).astype(np.int32)
        cv2.fillPoly(page, [corners], 0 if black else 255, cv2.LINE_AA, 4)
    return np.asarray(cv2.GaussianBlur(page, (0, 0), 1.0))


@pytest.mark.parametrize("ending", [".svg", ".pdf"])
@pytest.mark.parametrize("name", BOARDS)
def test_the_printed_board_is_found_and_has_its_size(
    name: str, ending: str, tmp_path: Path
) -> None:
    options, board = BOARDS[name]
    out = tmp_path / f"board{ending}"
    assert run(*options, "--out", out) == 0
    size, shapes = (of_svg if ending == ".svg" else of_pdf)(out)
    page = printed(size, shapes)
    seen = find_board(page, board)
    assert len(seen.ids) == len(board.corners)
    # The board's frame: x up the page, y to the left.
    expected = -board.corners[seen.ids][:, [1, 0]] * 1e3
    if board.kind == "chessboard":  # which side is up is not told
        expected = min(expected, -expected, key=lambda way: spread(seen.pixels / PX - way))
    assert spread(seen.pixels / PX - expected) < 0.05
    assert page[[0, -1]].min() == 255 and page[:, [0, -1]].min() == 255


def spread(offsets: Array) -> float:
    return float(np.ptp(offsets, axis=0).max())


@pytest.mark.parametrize("ending", [".svg", ".pdf"])
def test_the_rulers_are_100_mm_long(ending: str, tmp_path: Path) -> None:
    out = tmp_path / f"board{ending}"
    assert run("--out", out) == 0
    _, shapes = (of_svg if ending == ".svg" else of_pdf)(out)
    sides = [np.ptp(points, axis=0) for points, _ in shapes]
    for axis in (0, 1):
        rulers = [side for side in sides if abs(side[axis] - 100) < 1e-3 and side[1 - axis] < 1]
        assert len(rulers) == 1


def test_the_page_says_how_it_is_used(tmp_path: Path) -> None:
    out = tmp_path / "board.svg"
    assert run("--type", "charuco", "--squares", "7x5", "--size", "0.03", "--out", out) == 0
    said = [item.text for item in ElementTree.fromstring(out.read_text()).findall("{*}text")]
    assert "Charuco of 7 x 5 squares (6 x 4 inner corners), 30 mm" in said
    command = next(words for words in said if words and words.startswith("brickpose"))
    assert command.endswith("--type charuco --dictionary 5x5_250 --squares 7x5 --size 0.03")


def test_no_shape_leaves_the_paper(tmp_path: Path) -> None:
    for paper, square in (("a4", 0.025), ("letter", 0.024), ("a3", 0.036)):
        out = tmp_path / f"{paper}.svg"
        assert run("--paper", paper, "--size", square, "--out", out) == 0
        size, shapes = of_svg(out)
        every = np.concatenate([points for points, _ in shapes])
        assert every.min() > 4 and (every < np.array(size) - 4).all()
    widths = [of_svg(tmp_path / f"{paper}.svg")[0] for paper in ("letter", "a4", "a3")]
    assert all(small < large for small, large in pairwise(widths))


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (["--size", "0.03"], "are 300 x 210 mm: too large for a4 (210 x 297 mm)"),
        (["--paper", "a5"], "the paper is 'a5'; valid are a4, a3, letter"),
        (["--out", "board.png"], "valid is a file that ends in .pdf or .svg"),
        (["--squares", "7"], "--squares is '7'; valid is such as 10x7"),
        (["--type", "charuco", "--marker", "1"], "markers of 1 of a square; valid is 0.3 to 0.95"),
        (["--type", "charuco", "--squares", "20x20", "--size", "0.008", "--dictionary", "4x4_50"],
         "a board of 20 x 20 squares has 200 markers, and there are 50 of 4x4_50"),
    ],
)  # fmt: skip
def test_what_cannot_be_printed_is_told(
    options: list[str], words: str, tmp_path: Path, capsys, monkeypatch
) -> None:
    monkeypatch.chdir(tmp_path)
    assert run(*options) == 2
    assert words in capsys.readouterr().err
    assert not list(tmp_path.iterdir())


def test_no_page_is_written_over_a_file_that_is_there(tmp_path: Path, capsys) -> None:
    precious = tmp_path / "board.svg"
    precious.write_text("precious")
    assert run("--out", precious) == 2
    assert f"{precious} would be overwritten; valid is another name" in capsys.readouterr().err
    assert precious.read_text() == "precious"
    assert run("--out", precious, "--force") == 0
    assert precious.read_text() != "precious"
