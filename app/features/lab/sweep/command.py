"""``brickpose sweep``: does the points that are not done yet, and writes table and plots."""

from __future__ import annotations

import argparse
import json
import shutil
from dataclasses import dataclass, replace
from pathlib import Path

from tqdm import tqdm

from app.console import say
from app.features.lab.sweep.points import (
    MEASURES,
    Measured,
    Point,
    Row,
    SweepJob,
    duration_of,
    follow_all,
    jobs_of,
    key_of,
    points_of,
    points_per_job,
)
from app.features.lab.sweep.report import FORMATS, plot_setting, require_format, write_table
from app.features.lab.sweep.sweep_file import SweepFile, load_sweep
from app.features.lab.workers import Workers, workers_from_options
from app.files import atomic_file
from app.options import config_of
from app.result_files import make_folder
from app.settings.config import Config
from robot.errors import BrickPoseError


class ResultCache:
    """A folder with a small file for each point that is done."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder

    def get(self, key: str) -> Measured | None:
        """Return the measures of a point; None if there are none or the file is damaged."""
        try:
            result = json.loads((self._folder / f"{key}.json").read_text(encoding="utf-8"))
        except (OSError, ValueError):
            return None
        whole = isinstance(result, dict) and set(result) == {*MEASURES, "error"}
        return result if whole else None

    def put(self, key: str, measured: Measured) -> None:
        """Store the measures of a point; the file is complete or not there.

        Raises:
            OSError: the file cannot be written.
        """
        with atomic_file(self._folder / f"{key}.json") as new:
            new.write_text(json.dumps(measured), encoding="utf-8")


@dataclass(frozen=True)
class SweepResult:
    """The outcome of a sweep."""

    rows: list[Row]
    done_before: int
    """Number of points whose results already existed."""


def sweep(
    file: SweepFile, base: Config, workers: Workers, folder: Path, kind: str = "csv"
) -> SweepResult:
    """Do the points that are not done yet, and write table and plots.

    Args:
        base: settings that are not swept.
        workers: the processes that do the work.
        folder: for ``results.csv`` (or ``.parquet``), ``plots/``, and ``points/`` with the points
            that are done; an interrupted sweep continues from there.
        kind: one of ``FORMATS``.

    Raises:
        SettingError: the folder cannot be created.
        OSError: the folder cannot be written.
    """
    make_folder(folder)
    _remove_former(folder)
    points = points_of(file, base)
    offset = file.sweep.offset
    keys = [_key(file, point) for point in points]
    configs = {key: point.config for key, point in zip(keys, points, strict=True) if point.config}
    kept = ResultCache(folder / "points")
    result = {key: item for key in configs if (item := kept.get(key)) is not None}
    done_before = len(result)
    left = {key: config for key, config in configs.items() if key not in result}
    with tqdm(total=len(configs), initial=done_before, unit="point", disable=None) as progress:
        # If several points together ended their worker, only one may be the cause: try each alone.
        for most in (points_per_job(len(left), workers.count), 1):
            jobs = jobs_of(left, file.sweep.laps, offset, most)
            result |= _do(jobs, workers, kept, progress)
            left = {key: config for key, config in left.items() if key not in result}
    rows = [_row(point, result.get(key)) for point, key in zip(points, keys, strict=True)]
    for setting in file.values:
        plot_setting(folder / "plots" / f"{setting}.svg", setting, rows, bool(offset))
    write_table(folder / f"results.{kind}", rows)
    return SweepResult(rows, done_before)


def _do(
    jobs: list[SweepJob], workers: Workers, kept: ResultCache, progress: tqdm[None]
) -> dict[str, Measured]:
    """Return the measures by key, without the points of a job of several points that failed."""
    result: dict[str, Measured] = {}
    for place, outcome in workers.each(follow_all, jobs):
        keys = list(jobs[place].configs)
        if isinstance(outcome, Exception) and len(keys) > 1:
            continue
        for key in keys:
            measured = _measured(outcome, key)
            result[key] = measured
            # A failed point is not stored: the next run tries it again, as the machine may have
            # been the cause.
            if not measured["error"]:
                kept.put(key, measured)
            progress.update()
    return result


def _measured(outcome: dict[str, Measured] | Exception, key: str) -> Measured:
    if isinstance(outcome, Exception):
        return dict.fromkeys(MEASURES) | {"error": str(outcome) or type(outcome).__name__}
    return outcome[key]


def _remove_former(folder: Path) -> None:
    """Remove the former table and plots, which may not match the sweep file any more."""
    for kind in FORMATS:
        (folder / f"results.{kind}").unlink(missing_ok=True)
    shutil.rmtree(folder / "plots", ignore_errors=True)


def _key(file: SweepFile, point: Point) -> str:
    """Return the key of a point's result; empty if its settings are invalid."""
    if point.config is None:
        return ""
    return key_of(point.config, duration_of(file, point.config), file.sweep.offset)


def _row(point: Point, measured: Measured | None) -> Row:
    about = point.settings | {
        "world": point.world,
        "condition": point.condition,
        "seed": point.seed,
    }
    if measured is None:
        measured = dict.fromkeys(MEASURES) | {"error": point.error}
    return about | measured


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
        say(f"interrupted; {kept} runs are kept in {folder}, and the same command goes on")
        raise
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
