"""``brickpose calibrate lens``: measures a lens from pictures of a board."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from app.console import say
from app.engine.robots import robot_kind
from app.features.lab.calibrate.lens_report import lens_report
from app.features.lab.calibrate.pictures import board_of, find_in, picture_files, read_grey
from app.files import atomic_file
from app.result_files import require_new, require_new_report, require_writable
from app.settings.config import AUTO, Config
from app.settings.profile_files import profile_before, with_lens, write_profile
from robot.calibration.lens.board import Board
from robot.calibration.lens.coverage import missing
from robot.calibration.lens.lens_calibration import (
    LensCalibration,
    LensError,
    calibrate_lens,
    choice,
    extrapolated,
)
from robot.calibration.lens.result_file import camera_info_of
from robot.calibration.lens.sighting import SightingError
from robot.camera import Lens
from robot.cameras.picture_files import turned_line
from robot.description.lens_table import MeasuredLens
from robot.lens_files.writing import FORMATS, INI, Format
from robot.settings import SettingError

OUT = Path("camera.yaml")
ROS = "ros"


def calibrate_lens_command(given: dict[str, Any]) -> int:
    """Run the command with its options by name; return 0.

    Raises:
        LensError: the pictures do not determine a lens; nothing is written.
        ContradictionError: it contradicts itself; only the report is written.
        SettingError, OSError: says what cannot be used.
    """
    force = given.pop("force", False)
    form, out = _file_of(given.pop("format", None), given.pop("out", None))
    report = given.pop("report", out.with_suffix(".html"))
    require_writable(out, report)
    if not force:
        _require_new(out, report)
    spec = robot_kind(Config(robot=given.pop("robot", AUTO))).description()
    before = profile_before(out, spec) if out.suffix == ".toml" else None
    files = picture_files(given.pop("pictures"))
    if before is not None:
        _require_size(files, spec.lens, out)
    found_boards = find_in(files, board_of(given))
    board = found_boards.board
    if found_boards.to_turn:
        say(turned_line(found_boards.to_turn))
    result = calibrate_lens(found_boards.seen, board, found_boards.refused)
    if form is not None:
        result = _held_by(form, result)
    for line in lines_of(result, board):
        say(line)
    with atomic_file(report) as new:
        new.write_text(lens_report(result, board), encoding="utf-8")
    result.quality.require_consistent(force=force)
    if before is None:
        text = (
            camera_info_of(result, board, spec.lens.readout)
            if form is None
            else form.write(result.lens)
        )
        with atomic_file(out) as new:
            new.write_text(text, encoding="utf-8")
    else:
        measured = MeasuredLens(result.lens, result.sd)
        source = f"lens by {len(result.seen)} pictures"
        profile = replace(with_lens(before, measured, source), fit=result.quality.table())
        profile.applied_to(spec)
        write_profile(out, profile)
    say(f"the lens is in {out}, a report in {report}")
    return 0


def _require_new(out: Path, report: Path) -> None:
    """Refuse to write over a lens file, or over a file that is no report of a profile."""
    if out.suffix == ".toml":
        require_new_report(report, out)
    else:
        require_new(out, report)


def _require_size(files: Sequence[Path], lens: Lens, out: Path) -> None:
    """Refuse pictures of another camera for a robot's profile, before they are searched.

    Raises:
        SettingError: none has the size of the robot's; says which file could hold the lens.
    """
    size = ""
    for file in files:
        try:
            height, width = read_grey(file).pixels.shape
        except SightingError:
            continue
        if (width, height) == (lens.width, lens.height):
            return
        size = size or f"{file.name} is of {width} x {height} px"
    if size:
        raise SettingError(
            f"{size}, and none is of the robot's {lens.width} x {lens.height} px: "
            f"{out} is a robot's profile; valid is --out {out.with_suffix('.yaml')}, which holds "
            "the lens of any camera"
        )


def _file_of(name: str | None, out: Path | None) -> tuple[Format | None, Path]:
    """Return the format, None for ROS's ``camera_info`` or a profile, and the file to write."""
    if name is None and out is not None and out.suffix.lower() == INI.suffixes[0]:
        name = "ini"
    form = None if name in (None, ROS) else FORMATS[str(name)]
    suffixes = (".yaml", ".yml") if form is None else form.suffixes
    out = out or OUT.with_suffix(suffixes[0])
    if out.suffix.lower() == ".toml" and name is None:
        return None, out
    if out.suffix.lower() not in suffixes:
        title = "ROS's camera_info" if form is None else form.title
        profile = " or .toml (a robot's profile)" if name is None else "; a profile has no --format"
        raise SettingError(
            f"--out is {out}; valid is a file that ends in {' or '.join(suffixes)} ({title})"
            + profile
        )
    return form, out


def _held_by(form: Format, result: LensCalibration) -> LensCalibration:
    """Return a calibration with the best of the models that a format can hold."""
    if result.lens.model in form.models:
        return result
    able = [rating for rating in result.ratings if rating.model in form.models]
    if not able:
        raise LensError(f"none of the models that {form.title} can hold fits the pictures")
    chosen = choice(able)
    say(
        f"{form.title} can hold {', '.join(form.models)} only: {chosen.rms:.3f} px off in held-out "
        f"pictures, in place of {result.chosen.rms:.3f} px of {result.lens.model}"
    )
    return replace(result, chosen=chosen)


def lines_of(result: LensCalibration, board: Board) -> Iterator[str]:
    """Yield the lines of the report."""
    for name, reason in sorted(result.refused.items()):
        yield f"refused {name}: {reason}"
    yield f"{len(result.seen)} pictures count, of a {board.words}"
    for rating in result.ratings:
        mark = "  chosen" if rating is result.chosen else ""
        held_out = (
            f"{rating.rms:.3f} px off in held-out pictures"
            if math.isfinite(rating.rms)
            else "does not reach the picture's sides, or not without a part of the pictures"
        )
        yield f"{rating.model:<20} {held_out}, {rating.fit.rms:.3f} px in its own{mark}"
    sd = result.sd
    for (name, value), error in zip(result.lens.parameters.items(), sd, strict=True):
        digits = 2 if name in ("fx", "fy", "cx", "cy") else 4
        yield f"{name:<3}{value:>10.{digits}f} ± {1.96 * error:.{digits}f}"
    yield from (*result.quality.facts, *result.quality.remarks)
    bare = result.quality.unobservable
    if bare:
        apart = extrapolated(result.ratings, result.chosen)
        yield (
            f"extrapolated, as no board was there: {', '.join(bare)}; in the picture's corners the "
            f"models that fit differ by {apart:.1f} px"
        )
    for words in missing(list(result.seen.values()), board):
        yield f"better with more pictures: {words}"
