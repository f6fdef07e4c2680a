"""``brickpose sweep``: does all points of a sweep file; writes a table and a plot per setting."""

from __future__ import annotations

import shutil
from dataclasses import dataclass
from pathlib import Path

from tqdm import tqdm

from app.files import make_folder
from app.lab.sweep.plots import plot_setting
from app.lab.sweep.points import (
    Point,
    Row,
    SweepJob,
    duration_of,
    jobs_of,
    key_of,
    points_of,
    points_per_job,
)
from app.lab.sweep.result_cache import ResultCache
from app.lab.sweep.sweep_file import SweepFile
from app.lab.sweep.table import FORMATS, write_table
from app.lab.sweep.work import MEASURES, Measured, follow_all
from app.lab.workers import Workers
from app.settings.config import Config


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
        file: what to sweep.
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
