"""``brickpose sweep``: all points of a sweep file, as a table and a plot for each setting."""

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
    at_once,
    duration_of,
    jobs_of,
    key_of,
    points_of,
)
from app.lab.sweep.result_cache import ResultCache
from app.lab.sweep.sweep_file import SweepFile
from app.lab.sweep.table import FORMATS, write_table
from app.lab.sweep.work import MEASURES, Measured, follow_all
from app.lab.workers import Workers
from app.settings.config import Config


@dataclass(frozen=True)
class Swept:
    """What came of a sweep."""

    rows: list[Row]
    done_before: int
    """Points whose results were there already."""


def sweep(
    file: SweepFile, base: Config, workers: Workers, folder: Path, kind: str = "csv"
) -> Swept:
    """Do what is not done yet, and write table and plots.

    Args:
        file: what to sweep.
        base: settings that are not swept.
        workers: who does it.
        folder: for ``results.csv`` (or ``.parquet``), ``plots/``, and ``points/`` with what is
            done; a sweep that was interrupted goes on from there.
        kind: one of ``FORMATS``.

    Raises:
        SettingError: there can be no such folder.
        OSError: it cannot be written.
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
        # Of several points that ended their worker together, one alone may be to blame.
        for most in (at_once(len(left), workers.count), 1):
            jobs = jobs_of(left, file.sweep.laps, offset, most)
            result |= _do(jobs, workers, kept, progress)
            left = {key: config for key, config in left.items() if key not in result}
    rows = [_row(point, result.get(key)) for point, key in zip(points, keys, strict=True)]
    for setting in file.values:
        plot_setting(folder / "plots" / f"{setting}.svg", setting, rows, bool(offset))
    write_table(folder / f"results.{kind}", rows)
    return Swept(rows, done_before)


def _do(
    jobs: list[SweepJob], workers: Workers, kept: ResultCache, progress: tqdm[None]
) -> dict[str, Measured]:
    """What was measured, by key; without points that ended their worker together with others."""
    result: dict[str, Measured] = {}
    for place, outcome in workers.each(follow_all, jobs):
        keys = list(jobs[place].configs)
        if isinstance(outcome, Exception) and len(keys) > 1:
            continue
        for key in keys:
            measured = _measured(outcome, key)
            result[key] = measured
            # What failed is tried again the next time: it may have been the machine's fault.
            if not measured["error"]:
                kept.put(key, measured)
            progress.update()
    return result


def _measured(outcome: dict[str, Measured] | Exception, key: str) -> Measured:
    if isinstance(outcome, Exception):
        return dict.fromkeys(MEASURES) | {"error": str(outcome) or type(outcome).__name__}
    return outcome[key]


def _remove_former(folder: Path) -> None:
    """A table and plots are of what the file says now, or not there."""
    for kind in FORMATS:
        (folder / f"results.{kind}").unlink(missing_ok=True)
    shutil.rmtree(folder / "plots", ignore_errors=True)


def _key(file: SweepFile, point: Point) -> str:
    """What a point's result is kept under; empty if there can be none."""
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
