"""``brickpose calibrate board``: a page to print, with a board for the other calibrations."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from app.console import say
from app.features.lab.calibrate.pictures import board_of
from app.files import atomic_file
from app.result_files import require_new
from robot.calibration.lens.board_page import lay_out
from robot.calibration.lens.page_files import pdf, svg
from robot.settings import SettingError

OUT = Path("board.pdf")
SUFFIXES = (".pdf", ".svg")


def print_board(given: dict[str, Any]) -> int:
    """Run the command with its options by name; return 0.

    Raises:
        SettingError, OSError: says what cannot be used.
    """
    out: Path = given.pop("out", OUT)
    suffix = out.suffix.lower()
    if suffix not in SUFFIXES:
        raise SettingError(f"--out is {out}; valid is a file that ends in .pdf or .svg")
    if not given.pop("force", False):
        require_new(out)
    paper = given.pop("paper", "a4")
    board = board_of(given)
    page = lay_out(board, paper)
    content = pdf(page) if suffix == ".pdf" else svg(page).encode("utf-8")
    with atomic_file(out) as new:
        new.write_bytes(content)
    say(f"a {board.words} of {1e3 * board.square:g} mm is in {out}")
    say("print it at 100 % (no fitting to the page), and measure both rulers: they are 100 mm long")
    return 0
