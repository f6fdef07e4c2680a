"""Carries out ``brickpose sweep`` with its arguments."""

from __future__ import annotations

import argparse
from dataclasses import replace
from pathlib import Path

from app.console import say
from app.lab.evaluation.command import workers_from_options
from app.lab.sweep.sweep import sweep
from app.lab.sweep.sweep_file import load_sweep
from app.lab.sweep.table import require_format
from app.options import config_of
from robot.errors import BrickPoseError


def sweep_command(parsed: argparse.Namespace) -> int:
    """Do the points of a sweep that are not done yet."""
    file, base = load_sweep(parsed.file), config_of(vars(parsed))
    if "condition" in parsed:
        conditions = tuple(dict.fromkeys(parsed.condition))
        file = replace(file, sweep=replace(file.sweep, conditions=conditions))
    require_format(parsed.format)
    folder = parsed.out or Path("sweeps") / file.name
    crew = workers_from_options(vars(parsed))
    try:
        swept = sweep(file, base, crew, folder, parsed.format)
    except KeyboardInterrupt:
        kept = len(list((folder / "points").glob("*.json")))
        raise BrickPoseError(
            f"interrupted; {kept} runs are kept in {folder}, and the same command goes on"
        ) from None
    finally:
        crew.close()
    failed = [row for row in swept.rows if row["error"]]
    say(f"{len(swept.rows)} runs, {swept.done_before} of them done before, {len(failed)} failed")
    if failed:
        say(f"the first that failed: {failed[0]['error']}")
    if len(failed) == len(swept.rows):
        raise BrickPoseError(f"all runs of {parsed.file} failed")
    say(f"the table is {folder / f'results.{parsed.format}'}, the plots are in {folder / 'plots'}")
    return 0
