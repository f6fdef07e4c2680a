"""``brickpose calibrate lens``: measures a lens from pictures of a board."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

from app.console import say
from app.files import atomic_file
from app.lab.calibrate.lens_report import lens_report
from app.lab.calibrate.pictures import board_of, find_in, picture_files
from app.settings.profiles import profile_before, with_lens, write_profile
from robot.calibration.lens.board import Board
from robot.calibration.lens.camera_info import parameters
from robot.calibration.lens.coverage import missing
from robot.calibration.lens.lens_calibration import LensCalibration, calibrate_lens
from robot.calibration.lens.lens_table import MeasuredLens
from robot.calibration.lens.result_file import camera_info_of
from robot.description.spec import RobotSpec
from robot.settings import SettingError

OUT = Path("camera.yaml")
SUFFIXES = (".yaml", ".yml", ".toml")


def calibrate_lens_command(given: dict[str, Any]) -> int:
    """Run the command with its options by name; return 0.

    Raises:
        LensError: the pictures do not determine a lens; nothing is written.
        SettingError, OSError: says what cannot be used.
    """
    out = given.pop("out", OUT)
    if out.suffix.lower() not in SUFFIXES:
        raise SettingError(
            f"--out is {out}; valid is a file that ends in .yaml (ROS's camera_info) or .toml (a "
            "robot's profile)"
        )
    spec = RobotSpec.load()
    before = profile_before(out, spec) if out.suffix == ".toml" else None
    files = picture_files(given.pop("pictures"))
    found_boards = find_in(files, board_of(given))
    board = found_boards.board
    result = calibrate_lens(found_boards.seen, board, found_boards.refused)
    for line in lines_of(result, board):
        say(line)
    report = given.pop("report", out.with_suffix(".html"))
    with atomic_file(report) as new:
        new.write_text(lens_report(result, board), encoding="utf-8")
    if before is None:
        with atomic_file(out) as new:
            new.write_text(camera_info_of(result, board, spec.lens.readout), encoding="utf-8")
    else:
        measured = MeasuredLens(result.lens, result.chosen.fit.sd)
        profile = with_lens(before, measured, f"lens by {len(result.seen)} pictures")
        profile.applied_to(spec)
        write_profile(out, profile)
    say(f"the lens is in {out}, a report in {report}")
    return 0


def lines_of(result: LensCalibration, board: Board) -> Iterator[str]:
    """Yield the lines of the report."""
    for name, reason in sorted(result.refused.items()):
        yield f"refused {name}: {reason}"
    yield f"{len(result.seen)} pictures count, of a {board.words}"
    for rating in result.ratings:
        mark = "  chosen" if rating is result.chosen else ""
        yield (
            f"{rating.model:<20} {rating.rms:.3f} px off in held-out pictures, "
            f"{rating.fit.rms:.3f} px in its own{mark}"
        )
    sd = result.chosen.fit.sd
    for (name, value), error in zip(parameters(result.lens).items(), sd, strict=True):
        digits = 2 if name in ("fx", "fy", "cx", "cy") else 4
        yield f"{name:<3}{value:>10.{digits}f} ± {1.96 * error:.{digits}f}"
    for words in missing(list(result.seen.values()), board):
        yield f"better with more pictures: {words}"
